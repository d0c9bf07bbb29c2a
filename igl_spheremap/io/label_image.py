"""Images of labels (.nii, .nii.gz, .mgz), by nibabel: the surface of each label, in the image's coordinates."""

from __future__ import annotations

import gzip
import math
from io import BytesIO
from pathlib import Path
from typing import Any

import igl
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import MeshError, import_optional
from ..gate import gate
from ..mesh.arrays import FloatArray, IntArray, plain_array
from .formats import GZIP
from .nifti import array_behind
from .records import RawMesh, of_triangles

#: Bytes that deflate makes of one at most: images of labels do expand that far.
_DEFLATE = 1032
#: How files begin that are not of NIfTI's first version.
_MGH, _NIFTI2 = b"\0\0\0\1", (b"\x1c\2\0\0", b"\0\0\2\x1c")
#: Labels that a message lists.
_LISTED = 12


@gate
def label_surface(
    labels: ArrayLike, label: int, *, affine: ArrayLike | None = None
) -> tuple[FloatArray, IntArray]:
    """The surface around the voxels of a label, by libigl's marching cubes.

    It is closed, where the label touches the image's border, too, and halves the way between the centres of voxels that
    have the label and of those that don't. It may have parts, handles and cavities: `info` counts them, `repair_mesh`
    makes a sphere of it.

    Parameters
    ----------
    labels : (a, b, c) array_like
        A label at each voxel.
    label : int
        Whose surface; 1 of a mask.
    affine : (4, 4) array_like, optional
        Takes the indices of voxels to coordinates, as ``image.affine`` of nibabel does; by default they are the
        coordinates.

    Returns
    -------
    (n, 3) float64 array, (m, 3) int64 array
        Vertices and faces, which are oriented outwards.

    Raises
    ------
    MeshError
        If the array does not have three dimensions, no voxel has the label, or the affine matrix is not invertible.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> image = np.zeros((9, 9, 9), dtype=int)
    >>> image[2:7, 3:6, 3:6] = 7
    >>> v, f = ism.label_surface(image, 7, affine=np.diag([2.0, 2.0, 2.0, 1.0]))
    >>> (v.max(axis=0) - v.min(axis=0)).tolist()
    [10.0, 6.0, 6.0]
    >>> ism.spherical_conformal_map(v, f).certificate.folding_free
    True
    """
    image = plain_array(labels, "labels")
    if image.ndim != 3:
        shape = " x ".join(map(str, image.shape))
        raise MeshError(f"it holds an array of {shape or 'one number'}; give a label at each voxel")
    matrix = np.eye(4) if affine is None else plain_array(affine, "affine").astype(np.float64)
    if matrix.shape != (4, 4) or not abs(np.linalg.det(matrix[:3, :3])) > 0:
        raise MeshError("the affine matrix is not 4 x 4 and invertible; correct the image's header")
    inside = image == label
    if not inside.any():
        raise MeshError(f"no voxel has the label {label}; it has {_listed(_keys(image))}")
    corner, box = [], inside
    for axis in range(3):
        at = np.flatnonzero(inside.any(axis=tuple({0, 1, 2} - {axis})))
        corner.append(at[0] - 1)
        box = box.take(range(at[0], at[-1] + 1), axis=axis)
    padded = np.pad(box, 1)
    places = np.stack(np.unravel_index(np.arange(padded.size), padded.shape, order="F"), axis=1)
    values = padded.ravel(order="F").astype(np.float64)
    points = np.ascontiguousarray((places + corner) @ matrix[:3, :3].T + matrix[:3, 3])
    v, f, _ = igl.marching_cubes(values, points, *padded.shape, 0.5)
    if np.linalg.det(matrix[:3, :3]) > 0:
        f = f[:, ::-1]
    return v, np.ascontiguousarray(f)


def read(path: Path, label: int | None = None) -> RawMesh:
    """The surface of a label, or of the only one of the image."""
    image, affine = _load(path)
    keys = _keys(image)
    if label is None:
        if len(keys) != 1:
            raise MeshError(
                f"it holds the labels {_listed(keys)}; give one of them, as {path}:{keys[0]}"
            )
        label = int(keys[0])
    v, f = label_surface(image, label, affine=affine)
    return RawMesh(v, of_triangles(f))


def labels_in(path: Path) -> list[int]:
    """The labels of an image but 0, in ascending order."""
    return [int(key) for key in _keys(_load(path)[0])]


def _keys(image: NDArray[Any]) -> NDArray[Any]:
    """The labels of an image but 0; a MeshError if there are none, or values that are no labels."""
    keys = np.unique(image)
    keys = keys[keys != 0]
    if not len(keys):
        raise MeshError("it holds no label but 0; give an image of labels")
    if not np.isfinite(keys).all() or (keys != np.rint(keys)).any():
        raise MeshError(
            "it holds grey values, no labels; threshold it first, or give an image of labels"
        )
    return keys


def _listed(keys: NDArray[Any]) -> str:
    names = ", ".join(f"{key:.0f}" for key in keys[:_LISTED])
    return f"{names} and {len(keys) - _LISTED} more" if len(keys) > _LISTED else names


def _load(path: Path) -> tuple[NDArray[Any], FloatArray]:
    """An image's array and affine matrix."""
    nibabel = import_optional("nibabel", "images of labels", "io")
    data = path.read_bytes()
    if data.startswith(GZIP):
        stored = len(data)
        with gzip.open(BytesIO(data)) as file:
            data = file.read(_DEFLATE * stored + 1)
    if data.startswith(_MGH):
        kind = nibabel.freesurfer.mghformat.MGHHeader
    elif data.startswith(_NIFTI2):
        kind = nibabel.Nifti2Header
    else:
        kind = nibabel.Nifti1Header
    # without nibabel's checks, which print what they mend
    header = kind.from_fileobj(BytesIO(data), check=False)
    shape = header.get_data_shape()
    if len(shape) > 4:
        raise MeshError("it holds data over surfaces (CIFTI), no image; give a surface")
    array = array_behind(header, data)
    if math.prod(shape[3:]) == 1:
        array = array.reshape(shape[:3])
    return array, np.asarray(header.get_best_affine(), dtype=np.float64)
