"""Inputs of commands: meshes, their maps, data over their vertices, and lists of files."""

import glob
import os
import re
import shutil
import sys
import tempfile
from argparse import Namespace
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ...balance.balanced_spherical_map import balanced_spherical_map
from ...errors import FileError, MeshError, naming
from ...io.files import SAMPLE, parts_in, read_mesh, read_sphere
from ...io.hemispheres import other_side
from ...io.npz import read_arrays
from ...io.reading import read_lines
from ...io.records import Label, LoadedMesh
from ...io.scalars import file_of, read_labels, read_named
from ...io.templates import TEMPLATES, template_files
from ...io.written_map import read_map
from ...maps.given_sphere import certified
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import BoolArray, FloatArray, IntArray, check_directions
from ...mesh.check import check_faces, check_mesh
from ...mesh_repair.polygons import triangulation
from ...mesh_repair.repair_mesh import repair_mesh
from ...resampling.transfer import regular_mesh
from ...sphere.rows import row_lengths
from ..viewer.choices import guess_up
from .arguments import repair_of
from .exits import UsageError, usage

#: The name of stdin and stdout on the command line.
STREAM = "-"
#: The factors of a mirror image.
MIRROR = np.array([-1.0, 1.0, 1.0])


@dataclass(frozen=True, eq=False)
class InputMesh:
    """A mesh, its name as given, its file's further contents, and the changes by a repair."""

    name: str
    v: FloatArray
    f: IntArray
    metadata: Mapping[str, Any] = field(default_factory=dict)
    repairs: tuple[str, ...] = ()
    #: (m,) of the faces that are caps, if there are any
    caps: BoolArray | None = None
    #: if it was repaired, (m,) numbers of these faces in the file, -1 of caps
    face_source: IntArray | None = None
    #: if it is mapped to the plane, (n,) numbers of these vertices in the whole surface, -1 of new ones
    rows: IntArray | None = None

    @property
    def up(self) -> str:
        """The axis that is up in pictures of it."""
        return guess_up(self.name, self.metadata.get("structure"))

    def mirrored(self) -> "InputMesh":
        """Its mirror image, x to -x, of the other side of the body; faces are reversed."""
        structure = self.metadata.get("structure")
        metadata = {}
        if structure:
            metadata["structure"] = other_side(structure)
        return replace(
            self, v=self.v * MIRROR, f=np.ascontiguousarray(self.f[:, ::-1]), metadata=metadata
        )


@dataclass(frozen=True, eq=False)
class InputMap:
    """A mesh and a map of it: positions (n, 3) as they are stored, and the name of their file."""

    source: InputMesh
    name: str
    x: FloatArray

    def mirrored(self) -> "InputMap":
        """The mirror images of both."""
        return InputMap(self.source.mirrored(), self.name, self.x * MIRROR)

    @property
    def unit(self) -> FloatArray:
        """The positions divided by their median distance from the origin."""
        x = check_directions(self.x, name=f"{self.name}: images")
        return np.asarray(x / np.median(row_lengths(x)))

    def map(self) -> SphereMap:
        """The map as a certified result; errors name its file. A mirror image is refused: its frame is another."""
        with naming(self.name):
            return certified(
                check_mesh(self.source.v, self.source.f, caps=self.source.caps), self.x
            )


def load_source(args: Namespace, name: str | None = None, *, check: bool = True) -> InputMesh:
    """A mesh that the command line names, SOURCE by default; repairs, which may renumber vertices, go to stderr."""
    if name is None:
        name = args.source
    args.progress.begin(f"reading {name}")
    source = read_source(name, repair=repair_of(args), kind=args.format, check=check)
    if source.repairs:
        args.progress.write(f"igl-spheremap: repaired {source.name}: {'; '.join(source.repairs)}")
    return source


def read_source(
    name: str, *, repair: Mapping[str, Any] | None = None, kind: str = "obj", check: bool = True
) -> InputMesh:
    """A mesh from a file, a sample, or stdin, whose format is `kind`; `repair` are options of `repair_mesh`.

    Raises UsageError for an unknown sample, FileError and MeshError for a file without a closed genus-0 mesh. Without
    `check` any mesh will do; its polygons, and those of meshes to repair, are cut into triangles.
    """
    mesh = read_any(
        name, kind, lambda path: read_mesh(path, triangulate=repair is not None or not check)
    )
    name = _in_words(name)
    cut = triangulation(mesh.triangulated, mesh.concave)
    with naming(name):
        if repair is None:
            caps = None
            if check:
                caps = check_mesh(mesh).caps
            return InputMesh(name, mesh.v, mesh.f, mesh.metadata, cut, caps)
        done = repair_mesh(mesh, **repair)
    return InputMesh(
        name, done.v, done.f, mesh.metadata, cut + done.actions, done.caps, done.face_source
    )


def _in_words(name: str) -> str:
    """A file's name in messages."""
    return {STREAM: "stdin"}.get(name, name)


def up_of(args: Namespace, source: InputMesh) -> str:
    """The up direction: that of --up, or else by the name and the format of the mesh."""
    if args.up is not None:
        return str(args.up)
    return source.up


def sphere_name(args: Namespace) -> str:
    """The file of the map: SPHERE, or else SOURCE, which may hold both."""
    if args.sphere is not None:
        return str(args.sphere)
    return str(args.source)


def map_of(args: Namespace, source: InputMesh, **options: Any) -> SphereMap:
    """The map that the archive of a mesh holds; other meshes, and those that were repaired, are mapped."""
    if (
        not source.repairs
        and source.name.lower().endswith(".npz")
        and "sphere" in read_arrays(source.name)
    ):
        return read_map(source.name)
    args.progress.begin(f"mapping {source.name}")
    return balanced_spherical_map(
        source.v, source.f, caps=source.caps, listener=args.progress.listener(source.f), **options
    )


def load_pair(args: Namespace, mirror: bool = False) -> InputMap:
    """The mesh and the map that the command line names, or the mirror images of both."""
    if args.source == STREAM and args.sphere in (None, STREAM):
        raise UsageError("stdin is read once: give the mesh or its map as a file")
    if args.sphere is None and not args.source.lower().endswith(".npz"):
        raise UsageError(f"{args.source} holds no map: give SPHERE, or an .npz with both")
    source = load_source(args)
    args.progress.begin(f"reading {sphere_name(args)}")
    found = read_pair(source, sphere_name(args), args.format)
    if mirror:
        return found.mirrored()
    return found


def read_pair(source: InputMesh, name: str, kind: str = "obj") -> InputMap:
    """A mesh and a map of it from a file or stdin; a MeshError if its vertices or faces are not those of the mesh."""
    x, f = read_any(name, kind, read_sphere)
    name = _in_words(name)
    if len(x) != len(source.v):
        raise MeshError(
            f"{name} has {len(x)} vertices but {source.name} has {len(source.v)}; give a map of this mesh"
        )
    if len(f) != len(source.f) or not np.array_equal(_face_set(f), _face_set(source.f)):
        raise MeshError(
            f"{name} has other faces than {source.name}: not the same vertex order; give a map of this mesh "
            "in a format that keeps the order (not .stl)"
        )
    if _is_round(source.v) and not _is_round(x):
        raise MeshError(
            f"{source.name} is a sphere and {name} is none: the surface comes first, then its sphere"
        )
    return InputMap(source, name, x)


def _is_round(x: FloatArray) -> bool:
    """Whether all vertices are as far from the origin, to a hundredth."""
    lengths = row_lengths(x)
    return bool(np.ptp(lengths) < 0.01 * lengths.max())


def _face_set(f: IntArray) -> IntArray:
    """Faces in sorted order, whatever their orientation and first vertex."""
    f = np.sort(f, axis=1)
    return f[np.lexsort(f.T)]


def read_any(name: str, kind: str, read: Callable[[str | Path], LoadedMesh]) -> LoadedMesh:
    """Read a file, a sample:NAME, or, for the name `-`, stdin as a file of that kind."""
    if name.startswith(SAMPLE):
        with usage(""):
            return read(name)
    if name != STREAM:
        return read(name)
    if sys.stdin is None:
        raise FileError("can't read stdin: it is closed")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"stdin.{kind}"
        try:
            with path.open("wb") as copy:
                # in pieces: readers bound memory by the size of a file
                shutil.copyfileobj(sys.stdin.buffer, copy)
        except OSError as error:
            raise FileError(f"can't copy stdin to {path}: {error.strerror}") from error
        if not path.stat().st_size:
            raise MeshError("stdin: it is empty, nothing came through the pipe")
        try:
            return read(path)
        except (MeshError, FileError) as error:
            error.args = (str(error.args[0]).replace(str(path), "stdin"), *error.args[1:])
            raise


def read_target_sphere(to: str, source: InputMesh | None = None) -> tuple[FloatArray, IntArray]:
    """Vertices and faces of the sphere mesh that --to names, of a template on the side of `source`."""
    if to.startswith("ico:"):
        with usage("--to "):
            return regular_mesh(to)
    if to in TEMPLATES and not Path(to).exists():
        structure = None
        if source is not None:
            structure = source.metadata.get("structure")
        _, f, x = template_files(to, structure, None).read()
    else:
        x, f = read_sphere(to)
    return x, check_faces(f, len(x))


def read_data(path: str, mesh: InputMesh) -> FloatArray:
    """The maps of a file over the vertices of a mesh as columns (n, k)."""
    return np.stack(list(read_maps(path, mesh).values()), axis=1)


def read_maps(path: str, mesh: InputMesh) -> dict[str, FloatArray]:
    """The maps of a file, or that of FILE:NAME, by name, (n,) each."""
    maps = read_named(path, mesh.metadata.get("structure"))
    for key, values in maps.items():
        if len(values) != len(mesh.v):
            raise MeshError(
                f"{path}: {key} has {len(values)} values but {mesh.name} has {len(mesh.v)} vertices; "
                "give data of this mesh"
            )
    return maps


def read_table(path: str) -> tuple[Label, ...] | None:
    """The table of the labels that a file, or FILE:NAME, holds; None if it holds none."""
    return read_labels(file_of(path)[0])


def parts_of(name: str) -> list[str]:
    """The closed parts of a file; if it has none or can't be read, as its row will say, the file itself."""
    with suppress(MeshError, FileError):
        if parts := parts_in(name):
            return parts
    return [name]


def expand(words: Iterable[str], lists: tuple[str, ...] = ()) -> list[str]:
    """Files in the order given; of a list `@FILE` one a line, of a glob in alphabetical order, numbers by value.

    Words of a list come with the lists around them, none of which may be named again.
    """
    names: list[str] = []
    for word in words:
        if word == STREAM:
            raise UsageError("a batch reads files, not stdin")
        if word.startswith("@") and not os.path.exists(word):
            place = os.path.realpath(word[1:])
            if place in lists:
                raise UsageError(f"{word} names itself; give a list of mesh files")
            lines = [line.strip() for line in read_lines(word[1:], pipes=True)]
            files = [line for line in lines if line and not line.startswith("#")]
            names += expand(files, (*lists, place))
        elif os.path.isdir(word):
            raise UsageError(f"{word} is a folder; name its files, such as '{word}/*.ply'")
        elif glob.has_magic(word) and not os.path.exists(word):
            found = sorted(glob.glob(word, recursive=True), key=_by_number)
            if not found:
                raise UsageError(f"no file is called {word}")
            names += found
        else:
            names.append(word)
    return names


def _by_number(name: str) -> list[tuple[int, str]]:
    """A key by which frame_2 comes before frame_10.

    >>> sorted(["frame_10.ply", "frame_2.ply"], key=_by_number)
    ['frame_2.ply', 'frame_10.ply']
    """
    key = []
    for part in re.split("([0-9]+)", name):
        number = -1
        if part.isdecimal():
            number = int(part)
        key.append((number, part))
    return key
