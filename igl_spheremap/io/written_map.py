"""A map written to a file, with a mark of its origin, and certified as written.

The mark is one line of ASCII with the source, the method and the options, which is the same for every run.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from .._version import __version__
from ..errors import FileError, MeshError
from ..gate import PathLike, gate
from ..maps.sphere_map import SphereMap
from ..mesh.arrays import BoolArray, FloatArray, IntArray, check_rows
from ..mesh.check import check_faces
from ..sphere.rows import row_lengths
from ..verify.certificate import UNIT_TOLERANCE, Certificate
from . import npz
from .files import read_sphere
from .float32 import certified_float32
from .formats import format_of, head_of
from .reading import reading
from .records import Metadata
from .replacing import replacing
from .write_mesh import kept_of

_MARK = re.compile(rb"igl_spheremap( [!-~]+){3} [0-9a-f]{24}")


def make_mark(
    v: FloatArray,
    f: IntArray,
    method: str,
    options: Mapping[str, Any],
    caps: BoolArray | None = None,
    longest: int = 80,
) -> str:
    """The mark of the map of this mesh: program, version, method, options, and a digest of the mesh.

    The number of faces that are caps stands with the options. Options that do not fit are replaced by their digest: the
    header of an STL file has 80 bytes, a comment of FreeSurfer's 199.

    Examples
    --------
    >>> make_mark(np.zeros((3, 3)), np.arange(3)[None], "auto", {"polish": "angles"}).split()[2:]
    ['auto', 'polish=angles', '47ae891934ca4ae3d3970f3e']
    """
    if caps is not None:
        options = {**options, "caps": int(caps.sum())}
    positions, faces = np.asarray(v, dtype="<f8"), np.asarray(f, dtype="<i8")
    digest = _digest(b"%d " % len(positions) + positions.tobytes() + faces.tobytes())
    asked = "-"
    if options:
        asked = ",".join(f"{key}={_text(value)}" for key, value in sorted(options.items()))
    method = re.sub(r"[^!-~]", "?", method)  # it may come from a file
    line = f"igl_spheremap {__version__} {method} {asked} {digest}"
    if len(line) <= longest and re.fullmatch(r"[\w.,=+-]+", asked, re.ASCII):
        return line
    return f"igl_spheremap {__version__} {method} {_digest(asked.encode())[:16]} {digest}"


def mark_of(result: SphereMap) -> str:
    """The mark of a result."""
    return make_mark(
        result.vertices, result.faces, result.method, result.settings, result.mesh.caps
    )


def read_mark(path: PathLike) -> str | None:
    """The mark of a file that this package wrote; None if it has none.

    Parameters
    ----------
    path : str or path-like
        A file of any format that `write_map` writes.

    Returns
    -------
    str or None
        ``igl_spheremap VERSION METHOD OPTIONS DIGEST``, the last of the source's positions and faces.

    Raises
    ------
    FileError
        If the file can't be opened.

    Examples
    --------
    >>> import tempfile
    >>> import igl_spheremap as ism
    >>> from igl_spheremap.io.written_map import read_mark
    >>> result = ism.spherical_conformal_map(*ism.samples.make("spheroid", n_vertices=300))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     check = ism.write_map(f"{folder}/sphere.obj", result)
    ...     mark = read_mark(f"{folder}/sphere.obj")
    >>> mark.split()[2]
    'auto'
    """
    path = Path(path)
    try:
        with reading(path):  # every writer puts the mark into the first bytes
            found = _MARK.search(head_of(path)[0])
    except MeshError:  # damaged
        return None
    if found is None:
        return None
    return found[0].decode()


def _text(value: object) -> str:
    """A value of an option; of an array its digest."""
    if isinstance(value, np.ndarray):
        return _digest(value.tobytes())
    return str(value)


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:24]


@dataclass(frozen=True, eq=False)
class SphereCheck(Certificate):
    """The certificate of a sphere of any radius about the origin, such as a file holds.

    Attributes
    ----------
    radius : float
        The median distance of its vertices from the origin, to which ``off_sphere`` is relative.
    moved : int
        Vertices that were moved, when the file was written, to keep its float32 numbers from folding.
    """

    radius: float = 1.0
    moved: int = 0


def certify_radius(x: FloatArray, f: IntArray) -> SphereCheck:
    """Certify a map to a sphere of any radius about the origin, on its numbers as they are.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> x, f = ism.samples.sphere(42)
    >>> check = certify_radius(100 * x, f)
    >>> check.folding_free, round(check.radius, 9)
    (True, 100.0)
    """
    x = check_rows(x)
    certificate = Certificate.of(x, check_faces(f, len(x)))
    distance = row_lengths(x)
    finite, radius = distance[np.isfinite(distance)], np.nan
    if len(finite):
        radius = float(np.median(finite))
    if abs(radius - 1) < UNIT_TOLERANCE:  # rounding: a unit sphere is written back digit for digit
        radius = 1.0
    off = np.flatnonzero(~(np.abs(distance - radius) <= UNIT_TOLERANCE * radius))
    off_sphere = off[~np.isin(off, certificate.not_finite)]
    return SphereCheck(**{**vars(certificate), "off_sphere": off_sphere}, radius=radius)


@gate
def write_map(
    path: PathLike,
    result: SphereMap,
    *,
    force: bool = False,
    radius: float | None = None,
    surface: bool = False,
    metadata: Metadata | None = None,
) -> SphereCheck:
    """Write the sphere of a map (NPZ: the whole map), read it back, and certify the file.

    The file carries a mark of its origin, see `read_mark`. STL files lose the order of the vertices.

    Parameters
    ----------
    path : str or path-like
        The new file; the end of its name decides the format.
    result : SphereMap
        The map.
    force : bool
        Replace an existing file.
    radius : float, optional
        Radius of the sphere in the file; by default that of the format's users: 100 for GIFTI and FreeSurfer, 1
        elsewhere. NPZ files hold the unit sphere.
    surface : bool
        Write the surface with the sphere beside it, ``x y z`` and ``px py pz`` of a PLY file, as programs for Moebius
        registration and dense correspondences read it. NPZ files hold both in any case.
    metadata : dict, optional
        As `read_mesh` gave it for the source; nothing by default.

    Returns
    -------
    SphereCheck
        The certificate of the numbers in the file, and their radius. If rounding to float32 folds the map, vertices are
        moved to repair it; a map that can't be repaired is written all the same.

    Raises
    ------
    FileError
        If the file exists and `force` is not set, it can't be written, or `surface` is set and its format holds no
        sphere beside a surface; nothing is left behind.

    Examples
    --------
    >>> import tempfile
    >>> import igl_spheremap as ism
    >>> result = ism.spherical_conformal_map(*ism.samples.make("spheroid", n_vertices=300))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     ism.write_map(f"{folder}/sphere.ply", result).folding_free
    True
    """
    known = dict(metadata or {}) | {"mark": mark_of(result)}
    if format_of(path).name == "NPZ":
        with replacing(path, force) as partial:
            npz.write_map(partial, result, known)
            return _check_written(partial, path)
    beside = None
    if surface:
        beside = result.vertices
    return write_sphere(
        path,
        result.sphere,
        result.faces,
        force=force,
        radius=radius,
        surface=beside,
        metadata=known,
    )


def write_sphere(
    path: PathLike,
    x: FloatArray,
    f: IntArray,
    *,
    force: bool = False,
    radius: float | None = None,
    surface: FloatArray | None = None,
    metadata: Metadata | None = None,
) -> SphereCheck:
    """Write unit rows and faces as `write_map` does; positions of a surface, if given, go beside them."""
    kind = format_of(path)
    if surface is not None and not kind.both:
        raise FileError(
            f"{path}: {kind.name} files hold no sphere beside a surface; write .ply or .npz"
        )
    known = kept_of(path, metadata, geometric_type="Spherical")
    if radius is None:
        radius = kind.radius
    positions, moved = radius * x, 0
    if kind.single:
        rounded = certified_float32(x, f, radius)
        positions, moved = rounded.positions.astype(np.float64), len(rounded.moved)
    if surface is not None:
        known["sphere"], positions = positions, surface
    with replacing(path, force) as partial:
        kind.functions.write(partial, positions, f, known)
        return replace(_check_written(partial, path), moved=moved)


@gate
def read_map(path: PathLike) -> SphereMap:
    """Read a whole map from an NPZ file.

    Parameters
    ----------
    path : str or path-like
        A file that `write_map` or ``igl-spheremap map`` wrote.

    Returns
    -------
    SphereMap
        Equal to the one that was written; the certificate is computed from the numbers in the file.

    Raises
    ------
    FileError
        If the file can't be opened.
    MeshError
        If it is damaged or holds no map.

    Examples
    --------
    >>> import tempfile
    >>> import igl_spheremap as ism
    >>> result = ism.spherical_conformal_map(*ism.samples.make("spheroid", n_vertices=300))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     check = ism.write_map(f"{folder}/map.npz", result)
    ...     again = ism.read_map(f"{folder}/map.npz")
    >>> bool((again.sphere == result.sphere).all())
    True
    """
    path = Path(path)
    with reading(path):
        return npz.read_map(path)


def _check_written(partial: Path, path: PathLike) -> SphereCheck:
    try:
        return certify_radius(*read_sphere(partial))
    except MeshError as error:
        # STL holds no indices: if float32 makes vertices coincide, the welded mesh is no sphere any more.
        raise FileError(
            f"can't write {path}: its numbers are too coarse for this map ({error}); write .obj, .ply or .npz"
        ) from error
