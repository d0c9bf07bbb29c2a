"""Meshes from files and to files."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import lru_cache
from hashlib import sha256
from pathlib import Path

import numpy as np

from .. import samples
from ..errors import MeshError
from ..gate import PathLike, gate
from ..mesh.arrays import IntArray, check_rows
from ..mesh_repair.topology import closed_parts
from .formats import format_in, stem_of
from .hemispheres import structure_of
from .reading import opening, reading
from .records import LoadedMesh, RawMesh

#: Beginning of names of samples.
SAMPLE = "sample:"


@gate
def read_mesh(path: PathLike, *, triangulate: bool = False) -> LoadedMesh:
    """Read a triangle mesh; the file's first bytes, or else the end of its name, decide its format.

    Parameters
    ----------
    path : str or path-like
        An OBJ, OFF, PLY, STL, VTK, glTF, GIFTI, FreeSurfer, MZ3 or NPZ file, or a shape model of a small body; or
        ``sample:NAME[:key=value,...]``, a shape of `igl_spheremap.samples`. ``FILE:K`` is the closed part K of a file,
        counted from 0 in the order of their first faces; of an image of labels the surface of label K.
    triangulate : bool
        Cut polygons into triangles, each in its plane, so that concave ones keep their shape; by default they are
        refused.

    Returns
    -------
    LoadedMesh
        Unpacks to ``v, f``, both unchecked; ``metadata`` holds data that `write_mesh` can keep.

    Raises
    ------
    FileError
        If the file can't be opened or is not a regular file, its format is unknown, or the package that reads it is not
        installed.
    MeshError
        If it is damaged, empty or not a triangle mesh, or would expand to far more memory than its size.
    ValueError
        If there is no such sample.

    Examples
    --------
    >>> import tempfile
    >>> import igl_spheremap as ism
    >>> ism.read_mesh("sample:sphere:n_vertices=42")
    LoadedMesh(42 vertices, 80 faces)
    >>> v, f = ism.samples.sphere(42)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     ism.write_mesh(f"{folder}/ball.off", v, f)
    ...     w, g = ism.read_mesh(f"{folder}/ball.off")
    >>> bool((v == w).all()), bool((f == g).all())
    (True, True)
    """
    return _read(path, triangulate=triangulate)


def read_sphere(path: PathLike) -> LoadedMesh:
    """Read the image of a map: the sphere of an NPZ or PLY file that holds both surfaces, the mesh of any other file.

    Parameters
    ----------
    path : str or path-like
        As for `read_mesh`.

    Returns
    -------
    LoadedMesh
        Unpacks to ``x, f``; the radius is as stored.

    Raises
    ------
    FileError, MeshError
        As from `read_mesh`.
    """
    return _read(path, sphere=True)


def _read(path: PathLike, sphere: bool = False, triangulate: bool = False) -> LoadedMesh:
    """Read a file or make a sample; if the sphere is asked for, that of a file that holds a map."""
    if str(path).startswith(SAMPLE):
        return LoadedMesh(*samples.from_spec(str(path).removeprefix(SAMPLE)))
    path, part = part_of(path)
    with reading(path):
        kind = format_in(path)
        if part is None:
            raw: RawMesh = kind.functions.read(path)
        elif kind.labels:
            raw = kind.functions.read(path, part)
        else:
            return _part(path, part, triangulate)
        positions = raw.v
        if sphere and raw.sphere is not None:
            positions = raw.sphere
        v, metadata = check_rows(positions, name="vertices"), structure_of(path) | {**raw.metadata}
        if triangulate:
            f, polygons, concave = raw.faces.cut(v)
            return LoadedMesh(v, f, metadata, polygons, concave)
        return LoadedMesh(v, raw.faces.triangles(), metadata)


def part_of(name: PathLike) -> tuple[Path, int | None]:
    """The file of FILE:K, and the number of its closed part; of a file's name no part.

    >>> part_of("cells.obj:12")[1], part_of("cells.obj")[1]
    (12, None)
    """
    found = re.fullmatch(r"(.+):(\d+)", str(name))
    if found is None or Path(name).exists():
        return Path(name), None
    return Path(found[1]), int(found[2])


def own_name(name: PathLike) -> Path:
    """The path after which files of a mesh are named: that of its file, with the number of its part.

    >>> own_name("a/cells.obj:12").as_posix(), own_name("a/cells.obj").as_posix()
    ('a/cells_12.obj', 'a/cells.obj')
    >>> own_name("labels.nii.gz:3").as_posix()
    'labels_3.nii.gz'
    """
    path, part = part_of(name)
    if part is None:
        return path
    stem = stem_of(path)
    return path.with_name(f"{stem}_{part}{path.name.removeprefix(stem)}")


def parts_in(path: PathLike) -> list[str]:
    """The names FILE:K of the closed parts of a file, or of the labels of an image, by which `read_mesh` takes them."""
    source = Path(path)
    with reading(source):
        kind = format_in(source)
        if kind.labels:
            keys: Iterable[int] = kind.functions.labels_in(source)
        else:
            keys = range(len(_parts_of(source, triangulate=True)[1]))
        return [f"{path}:{k}" for k in keys]


def _parts_of(path: Path, triangulate: bool) -> tuple[LoadedMesh, list[IntArray]]:
    """The mesh of a file, and the faces of its closed parts."""
    with opening(path):
        content = sha256(path.read_bytes()).digest()
    if format_in(path).name == "glTF":  # its contents may lie in other files
        return _split.__wrapped__(path, content, triangulate)
    return _split(path, content, triangulate)


@lru_cache(maxsize=1)  # parts are read one by one
def _split(path: Path, content: bytes, triangulate: bool) -> tuple[LoadedMesh, list[IntArray]]:
    mesh = read_mesh(path, triangulate=triangulate)
    return mesh, closed_parts(mesh.f, len(mesh.v))


def _part(path: Path, part: int, triangulate: bool) -> LoadedMesh:
    """The mesh of one closed part, whose vertices keep their order."""
    mesh, parts = _parts_of(path, triangulate)
    if part >= len(parts):
        raise MeshError(
            f"{path}: {len(parts)} parts of it are closed, numbered from 0; there is no part {part}"
        )
    used, faces = np.unique(mesh.f[parts[part]], return_inverse=True)
    return LoadedMesh(mesh.v[used], faces.reshape(-1, 3).astype(np.int64), structure_of(path))
