"""NumPy archives: a mesh, or a whole `SphereMap`, each array under the name of its field, the rest as JSON."""

from __future__ import annotations

import dataclasses
import json
import math
import zipfile
from collections.abc import Mapping
from enum import Enum
from io import BytesIO
from pathlib import Path
from types import UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import igl
import numpy as np
import scipy
from numpy.typing import NDArray

from ..errors import MeshError
from ..mesh.arrays import FloatArray, IntArray
from ..result.sphere_map import SphereMap
from .reading import check_expansion
from .records import Format, Metadata, RawMesh, of_triangles

_HEADERS = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
_COMPRESSIONS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)  # those of NumPy, whose expansion can be bounded


def read(path: Path) -> RawMesh:
    """The mesh of an archive, or source and sphere of a map."""
    arrays = read_arrays(path)
    v = arrays.get("vertices", arrays.get("sphere"))
    if v is None or "faces" not in arrays:
        raise MeshError(f"the archive holds no arrays 'vertices' and 'faces' but: {', '.join(arrays) or 'nothing'}; "
                        "save them under these names")
    return RawMesh(v, of_triangles(arrays["faces"]), sphere=arrays.get("sphere"))


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write a mesh, exactly, and the mark."""
    write_arrays(path, {"vertices": v, "faces": f}, metadata)


def read_map(path: Path) -> SphereMap:
    """A map as it was written; what the arrays hold is not checked."""
    arrays = read_arrays(path)
    if "json" not in arrays:
        raise MeshError("the archive holds no map; give a file that was written by write_map or `igl-spheremap map`")
    result: SphereMap = unpack(SphereMap, json.loads(str(arrays["json"])), "", arrays)
    return result


def write_map(path: Path, result: SphereMap, metadata: Metadata) -> None:
    """Write a map with all that is known of it, its conformal factor, and the versions of what made it."""
    arrays: dict[str, Any] = {}
    text = json.dumps(pack(result, "", arrays), default=str)
    versions = {"libigl": getattr(igl, "__version__", ""), "numpy": np.__version__, "scipy": scipy.__version__}
    more = {"conformal_factor": result.conformal_factor(), "json": text, "versions": json.dumps(versions)}
    write_arrays(path, arrays | more, metadata)


def read_arrays(path: Path) -> dict[str, NDArray[Any]]:
    """All arrays of an archive, in memory bounded by its size; numpy.load takes as much as headers announce."""
    data = path.read_bytes()
    with zipfile.ZipFile(BytesIO(data)) as archive:
        members = archive.infolist()
        check_expansion(sum(member.file_size for member in members), len(data))
        if any(member.compress_type not in _COMPRESSIONS for member in members):
            raise MeshError("the archive is packed by a method other than NumPy's; save it by numpy.savez")
        return {member.filename.removesuffix(".npy"): _array(archive, member) for member in members}


def _array(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> NDArray[Any]:
    with archive.open(member) as file:
        stream = BytesIO(file.read(member.file_size))
    shape, fortran, dtype = _HEADERS[np.lib.format.read_magic(stream)](stream)
    flat = np.frombuffer(stream.read(), dtype, math.prod(shape))
    return np.array(flat.reshape(shape, order="F" if fortran else "C"))


def write_arrays(path: Path, arrays: dict[str, Any], metadata: Metadata | None = None) -> None:
    """Write an archive; the mark comes first, so that it is found without unpacking."""
    mark: dict[str, Any] = {"mark": np.bytes_(metadata["mark"])} if metadata and "mark" in metadata else {}
    with path.open("wb") as file:
        np.savez(file, **mark | arrays)


def pack(value: Any, name: str, arrays: dict[str, NDArray[Any]]) -> Any:
    """What JSON holds of `value`; its arrays are added to `arrays`, under names such as ``certificate.flipped``."""
    if isinstance(value, np.ndarray):
        arrays[name] = value
        return None
    if isinstance(value, Enum):
        return value.name
    if dataclasses.is_dataclass(value):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value) if field.compare}
    if isinstance(value, Mapping):
        return {str(key): pack(item, _below(name, key), arrays) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [pack(item, _below(name, k), arrays) for k, item in enumerate(value)]
    return value.item() if isinstance(value, np.generic) else value


def unpack(kind: Any, value: Any, name: str, arrays: Mapping[str, NDArray[Any]]) -> Any:
    """The value of type `kind` that `pack` took apart."""
    if name in arrays:
        return arrays[name]
    if get_origin(kind) in (Union, UnionType):  # of one type or None
        kind = next(option for option in get_args(kind) if option is not type(None))
    if value is None:
        return None
    if isinstance(kind, type) and issubclass(kind, Enum):
        return kind[value]
    if isinstance(kind, type) and dataclasses.is_dataclass(kind):
        types = get_type_hints(kind)
        return kind(**{key: unpack(types[key], item, _below(name, key), arrays) for key, item in value.items()})
    if hasattr(kind, "_fields"):  # a named tuple
        types = get_type_hints(kind)
        return kind(*(unpack(types[key], item, _below(name, k), arrays)
                      for k, (key, item) in enumerate(zip(kind._fields, value, strict=True))))
    if get_origin(kind) is tuple:
        return tuple(unpack(get_args(kind)[0], item, _below(name, k), arrays) for k, item in enumerate(value))
    if isinstance(value, dict):
        return {key: unpack(Any, item, _below(name, key), arrays) for key, item in value.items()}
    return value


def _below(name: str, key: object) -> str:
    return f"{name}.{key}" if name else str(key)


FORMAT = Format("NPZ", (".npz",), read, write, magic=(b"PK\x03\x04",), both=True)
