"""NumPy archives: a mesh, or a whole `SphereMap`, each array under the name of its field, the rest as JSON."""

from __future__ import annotations

import json
import math
import sys
import types
import zipfile
from dataclasses import asdict, replace
from io import BytesIO
from pathlib import Path
from typing import Any, get_args, get_origin, get_type_hints

import igl
import numpy as np
import scipy

from ..errors import MeshError, Remedy, printable, shown
from ..gate import PathLike
from ..maps.sphere_map import SphereMap
from ..mesh.arrays import AnyArray, FloatArray, IntArray, check_rows
from ..mesh.check import check_mesh
from ..result.run import Round, Run, Stage, Status, Step
from ..verify.certificate import Certificate
from .reading import check_expansion
from .records import Label, LabelTable, Metadata, NamedArrays, RawMesh, ScalarMaps, of_triangles
from .replacing import replacing

#: The array beside maps of labels that holds their table.
LABEL_TABLE = "label_table"
_HEADERS = {
    (1, 0): np.lib.format.read_array_header_1_0,
    (2, 0): np.lib.format.read_array_header_2_0,
}


def read(path: Path) -> RawMesh:
    """The mesh of an archive, or source and sphere of a map."""
    arrays = read_arrays(path)
    v = next((arrays[name] for name in ("vertices", "sphere", "v") if name in arrays), None)
    f = arrays.get("faces", arrays.get("f"))
    if v is None or f is None:
        raise MeshError(
            f"the archive holds no arrays 'vertices' and 'faces' but: {', '.join(arrays) or 'nothing'}; "
            "save them under these names, or as 'v' and 'f'"
        )
    caps = {name: array for name, array in arrays.items() if name == "caps"}
    return RawMesh(v, of_triangles(f), caps, arrays.get("sphere"))


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write a mesh, exactly, and the mark."""
    write_arrays(path, {"vertices": v, "faces": f}, metadata)


def read_map(path: Path) -> SphereMap:
    """A map as it was written, its mesh checked, and certified anew."""
    return map_of(read_arrays(path))


def map_of(arrays: NamedArrays) -> SphereMap:
    """The map whose arrays these are."""
    if not {"vertices", "faces", "sphere", "json"} <= arrays.keys():
        raise MeshError(
            "the archive holds no map; give a file that was written by "
            f"{Remedy('write_map', given='path, result')}"
        )
    mesh = check_mesh(arrays["vertices"], arrays["faces"], caps=arrays.get("caps"))
    runs = json.loads(str(arrays["json"]))
    if not isinstance(runs.get("sphere"), dict):
        raise MeshError(
            "damaged: the archive does not say how its map was made; its surfaces can be read, and "
            f"{Remedy('sphere_map', given='v, f, x')} certifies them"
        )

    def stored(name: str) -> SphereMap:
        x = check_rows(arrays[name], len(mesh.v), name)
        return SphereMap(mesh, x, Certificate.of(x, mesh.f), _unpack(runs[name]))

    result = stored("sphere")
    if "conformal" not in arrays:
        return result
    return replace(result, conformal=stored("conformal"))


def write_map(path: Path, result: SphereMap, metadata: Metadata) -> None:
    """Write a map with all its data, its conformal factor, and the versions of programs that made it."""
    versions = {
        "libigl": getattr(igl, "__version__", ""),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
    }
    more = {"conformal_factor": result.conformal_factor(), "versions": json.dumps(versions)}
    write_arrays(path, arrays_of(result) | more, metadata)


def arrays_of(result: SphereMap) -> dict[str, Any]:
    """All data of a map; `map_of` makes it again."""
    maps = {"sphere": result}
    if result.conformal is not None:
        maps["conformal"] = result.conformal
    arrays: dict[str, Any] = {"vertices": result.vertices, "faces": result.faces}
    arrays |= {name: each.sphere for name, each in maps.items()}
    if result.mesh.caps is not None:
        arrays["caps"] = result.mesh.caps
    runs = {name: asdict(each.run) for name, each in maps.items()}
    for run in runs.values():
        del run["timings"]
    return arrays | {"json": json.dumps(runs, default=_plain)}


def read_arrays(path: PathLike) -> NamedArrays:
    """All arrays of an archive, in memory bounded by its size; numpy.load takes as much as headers announce."""
    data = Path(path).read_bytes()
    with zipfile.ZipFile(BytesIO(data)) as archive:
        members = archive.infolist()
        check_expansion(sum(member.file_size for member in members), len(data))
        # whose expansion can be bounded
        packed = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
        if any(member.compress_type not in packed for member in members):
            raise MeshError(
                "the archive is packed by a method other than NumPy's; save it by numpy.savez"
            )
        if alien := [member.filename for member in members if not member.filename.endswith(".npy")]:
            raise MeshError(
                f"the archive holds {printable(alien[0])[:40]}, which is no array of NumPy's; check that "
                "the file is what its name says"
            )
        arrays = {}
        for member in members:
            with archive.open(member) as file:
                content = file.read(member.file_size)  # a member may hold more than it says
            arrays[member.filename.removesuffix(".npy")] = array_of(content)
        return arrays


read_scalars = read_arrays


def array_of(data: bytes) -> AnyArray:
    """The array that the bytes of an .npy file hold."""
    stream = BytesIO(data)
    shape, fortran, dtype = _HEADERS[np.lib.format.read_magic(stream)](stream)
    flat = np.frombuffer(stream.read(), dtype, math.prod(shape))
    return np.array(flat.reshape(shape, order="F" if fortran else "C"))


def read_table(path: Path) -> LabelTable | None:
    """The table of labels beside maps; None if there is none."""
    arrays = read_arrays(path)
    if LABEL_TABLE not in arrays:
        return None
    rows = json.loads(str(arrays[LABEL_TABLE]))
    return tuple(
        Label(int(key), printable(str(name)), (float(r), float(g), float(b), float(a)))
        for key, name, (r, g, b, a) in rows
    )


def write_scalars(path: Path, maps: ScalarMaps, metadata: Metadata) -> None:
    """Write maps, exactly; of labels as whole numbers, with their table as JSON."""
    if "labels" not in metadata:
        write_arrays(path, maps)
        return
    table = json.dumps([(label.key, label.name, label.rgba) for label in metadata["labels"]])
    write_arrays(
        path,
        {name: values.astype(np.int64) for name, values in maps.items()} | {LABEL_TABLE: table},
    )


def write_arrays(path: Path, arrays: dict[str, Any], metadata: Metadata | None = None) -> None:
    """Write an archive; the mark comes first, so that it is found without unpacking."""
    mark: dict[str, Any] = {}
    if metadata and "mark" in metadata:
        mark["mark"] = np.bytes_(metadata["mark"])
    # arguments of numpy.savez could not be names of arrays
    with zipfile.ZipFile(path, "w") as archive:
        for name, array in (mark | arrays).items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asanyarray(array), allow_pickle=False)


def save_arrays(path: PathLike, arrays: dict[str, Any], force: bool = True) -> None:
    """Write an archive whole or not at all; only with `force` it replaces an existing file."""
    with replacing(path, force) as partial:
        write_arrays(partial, arrays)


def _plain(value: Any) -> Any:
    """Convert values that JSON does not know: statuses and NumPy's numbers."""
    match value:
        case Status():
            return value.name
        case np.generic():
            return value.item()
        case _:
            return str(value)


def _printable(value: Any) -> Any:
    """Escape control characters in all texts of a JSON value, which are printed and written into other files."""
    match value:
        case str():
            return printable(value)
        case list():
            return [_printable(item) for item in value]
        case dict():
            return {printable(key): _printable(item) for key, item in value.items()}
        case _:
            return value


def _unpack(known: dict[str, Any]) -> Run:
    """The record that `arrays_of` took apart."""
    known = _printable(known)
    for each in (known, *known["rounds"]):
        each["status"] = Status[each["status"]]
    known["history"] = tuple(Step(Stage(stage), *rest) for stage, *rest in known["history"])
    known["rounds"] = tuple(Round(**each) for each in known["rounds"])
    run = Run(**known | {"notes": tuple(known["notes"])})
    for record in (run, *run.history, *run.rounds):
        for name, kind in get_type_hints(type(record)).items():
            value = getattr(record, name)
            if not _is_of(kind, value):
                raise MeshError(f"damaged: {name} of its record is {shown(value)}; write it anew")
    return run


def _is_of(kind: Any, value: Any) -> bool:
    """Whether a value of JSON fits an annotation."""
    if kind is Any:
        return True
    outer, inner = get_origin(kind), get_args(kind)
    if outer is types.UnionType:
        return any(_is_of(each, value) for each in inner)
    if outer is tuple:
        return isinstance(value, tuple) and all(_is_of(inner[0], each) for each in value)
    if outer is not None:
        return isinstance(value, dict) and all(_is_of(inner[1], each) for each in value.values())
    if type(value) is int:
        return kind in (int, float) and abs(value) <= sys.maxsize
    if type(value) is bool:
        return bool(kind is bool)
    return isinstance(value, kind)
