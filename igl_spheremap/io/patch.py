"""FreeSurfer's patches (lh.cortex.patch.3d, lh.cortex.patch.flat): parts of a surface, in float32, without faces."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError
from ..gate import PathLike
from ..mesh.arrays import BoolArray, FloatArray, IntArray, check_rows, check_triangles
from .reading import Bytes, reading
from .replacing import replacing

SUFFIXES = (".patch.3d", ".patch.flat")
#: A vertex: its row, from 1 on, negative at the boundary, and its position.
_VERTEX = np.dtype([("number", ">i4"), ("position", ">f4", 3)])


@dataclass(frozen=True, eq=False)
class Patch:
    """Vertices of a surface and their positions, cut out or laid flat.

    Attributes
    ----------
    rows : (k,) int64 array
        Rows of the whole surface.
    positions : (k, 3) float64 array
        Their positions; the third coordinate of a flat patch is 0.
    border : (k,) bool array
        Whether each lies on the boundary.
    """

    rows: IntArray
    positions: FloatArray
    border: BoolArray

    def __repr__(self) -> str:
        return f"Patch({len(self.rows)} vertices, {int(self.border.sum())} on the boundary)"

    def part(self, v: ArrayLike, f: ArrayLike) -> tuple[FloatArray, IntArray]:
        """The part of the whole surface that the patch holds.

        Parameters
        ----------
        v : (n, 3) array_like
            Vertices of the whole surface, such as lh.white.
        f : (m, 3) array_like
            Its faces.

        Returns
        -------
        (k, 3) float64 array, (j, 3) int64 array
            Vertices, in the order of the patch, and the faces all of whose corners it holds.

        Raises
        ------
        MeshError
            If the patch is of a larger surface.
        """
        v, f = check_rows(v, name="vertices"), check_triangles(f)
        if self.rows.max() >= len(v):
            raise MeshError(
                f"the patch names vertex {self.rows.max()} but the surface has {len(v)}; give the surface "
                "that it was cut from"
            )
        number = np.full(len(v), -1)
        number[self.rows] = np.arange(len(self.rows))
        faces = number[f]
        return v[self.rows], faces[(faces >= 0).all(axis=1)]


def read_patch(path: PathLike) -> Patch:
    """Read a patch of FreeSurfer's.

    Parameters
    ----------
    path : str or path-like
        A file such as lh.cortex.patch.3d or lh.cortex.patch.flat.

    Returns
    -------
    Patch
        Its faces are those of the surface that it was cut from: ``v, f = read_patch(path).part(*read_mesh(surface))``.

    Raises
    ------
    FileError
        If the file can't be opened.
    MeshError
        If it is damaged or no patch.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> import igl_spheremap as ism
    >>> from igl_spheremap.io.patch import Patch, read_patch, write_patch
    >>> v, f = ism.samples.make("spheroid", n_vertices=300)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     patch = Patch(f[0], v[f[0]], np.ones(3, dtype=bool))
    ...     write_patch(f"{folder}/lh.cut.patch.3d", patch)
    ...     part, faces = read_patch(f"{folder}/lh.cut.patch.3d").part(v, f)
    >>> part.shape, faces.tolist()
    ((3, 3), [[0, 1, 2]])
    """
    path = Path(path)
    with reading(path):
        file = Bytes(path.read_bytes())
        version, count = file.array(">i4", 2).tolist()
        if version != -1:
            raise MeshError(
                f"the file begins with {version} where patches have -1; give a patch of FreeSurfer's"
            )
        table = file.array(_VERTEX, count)
        if file.at < len(file.data):
            raise MeshError(f"damaged: bytes follow behind its {count} vertices; write it anew")
        number = table["number"].astype(np.int64)
        rows = np.abs(number) - 1
        if count < 1 or rows.min() < 0 or len(np.unique(rows)) < count:
            raise MeshError(
                "damaged: no vertices, or vertices without a number of their own; write it anew"
            )
        return Patch(rows, table["position"].astype(np.float64), number < 0)


def write_patch(path: PathLike, patch: Patch, *, force: bool = False) -> None:
    """Write a patch as FreeSurfer's programs read it, in float32.

    Parameters
    ----------
    path : str or path-like
        The new file.
    patch : Patch
        Rows of the whole surface, positions, and marks of the boundary.
    force : bool
        Replace an existing file.

    Raises
    ------
    FileError
        As by `write_plane_map`.

    Examples
    --------
    >>> import tempfile
    >>> import numpy as np
    >>> from igl_spheremap.io.patch import Patch, read_patch, write_patch
    >>> patch = Patch(np.array([7, 3, 5]), np.eye(3), np.array([True, True, False]))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_patch(f"{folder}/lh.cut.patch.3d", patch)
    ...     read_patch(f"{folder}/lh.cut.patch.3d")
    Patch(3 vertices, 2 on the boundary)
    """
    table = np.empty(len(patch.rows), _VERTEX)
    table["number"] = np.where(patch.border, -1, 1) * (patch.rows + 1)
    table["position"] = patch.positions
    with replacing(path, force) as partial:
        partial.write_bytes(np.array([-1, len(table)], ">i4").tobytes() + table.tobytes())
