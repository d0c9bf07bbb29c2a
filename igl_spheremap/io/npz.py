"""NumPy archives: a mesh, or a whole `SphereMap` with its certificate, history, settings and versions."""

from __future__ import annotations

import json
import zipfile
from dataclasses import asdict, fields
from io import BytesIO
from pathlib import Path
from typing import Any

import igl
import numpy as np
import scipy

from ..descent.iterate import Round, Status, Step
from ..errors import MeshError
from ..maps.sphere_map import SphereMap
from ..verify.certificate import Certificate
from .polygons import of_triangles
from .records import FloatArray, Format, IntArray, Metadata, RawMesh

_CERTIFICATE = [entry.name for entry in fields(Certificate)]
_PLAIN = ("energy", "iterations", "seconds", "method", "backend", "notes", "settings")


def read(path: Path) -> RawMesh:
    """Read the mesh of an archive; of a map, the source.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    RawMesh
        Positions and faces.

    Raises
    ------
    MeshError
        If the archive holds no arrays ``vertices`` and ``faces``.
    """
    data = _load(path)
    if not {"vertices", "faces"} <= data.keys():
        raise MeshError(
            f"the archive holds no arrays 'vertices' and 'faces' but: {', '.join(data) or 'nothing'}; "
            "save them under these names"
        )
    return RawMesh(np.asarray(data["vertices"], dtype=np.float64), of_triangles(data["faces"]))


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write a mesh, exactly.

    Parameters
    ----------
    path : Path
        The file.
    v : (n, 3) float64 array
        Positions.
    f : (m, 3) int64 array
        Faces.
    metadata : dict
        Nothing of it can be kept.

    Returns
    -------
    None
    """
    write_arrays(path, {"vertices": v, "faces": f})


def write_map(path: Path, result: SphereMap) -> None:
    """Write a map with all that is known of it.

    Parameters
    ----------
    path : Path
        The file.
    result : SphereMap
        The map.

    Returns
    -------
    None
    """
    from .._version import __version__

    plain = {name: getattr(result, name) for name in _PLAIN} | {
        "status": result.status.name,
        "rounds": [asdict(entry) | {"status": entry.status.name} for entry in result.rounds],
        "versions": {
            "igl_spheremap": __version__,
            "libigl": getattr(igl, "__version__", ""),
            "numpy": np.__version__,
            "scipy": scipy.__version__,
        },
    }
    arrays: dict[str, Any] = {
        "vertices": result.vertices,
        "faces": result.faces,
        "sphere": result.sphere,
        "conformal_factor": result.conformal_factor(),
    }
    arrays |= {f"certificate_{name}": getattr(result.certificate, name) for name in _CERTIFICATE}
    columns = zip(*result.history, strict=True) if result.history else [()] * len(Step._fields)
    arrays |= {
        f"history_{name}": np.array(column) for name, column in zip(Step._fields, columns, strict=True)
    }
    write_arrays(path, arrays | {"json": json.dumps(plain, default=str)})


def read_map(path: Path) -> SphereMap:
    """Read a map back.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    SphereMap
        Equal to the one that was written.

    Raises
    ------
    MeshError
        If the archive holds no map.
    """
    data = _load(path)
    if not {"sphere", "json"} <= data.keys():
        raise MeshError(
            "the archive holds no map; give a file that was written by write_map or `igl-spheremap map`"
        )
    plain = json.loads(str(data["json"]))
    certificate = {name: data[f"certificate_{name}"] for name in _CERTIFICATE}
    certificate["degree"] = int(certificate["degree"])
    history = zip(*(data[f"history_{name}"].tolist() for name in Step._fields), strict=True)
    return SphereMap(
        vertices=data["vertices"],
        faces=data["faces"],
        sphere=data["sphere"],
        certificate=Certificate(**certificate),
        status=Status[plain["status"]],
        history=tuple(Step(*row) for row in history),
        rounds=tuple(Round(**(entry | {"status": Status[entry["status"]]})) for entry in plain["rounds"]),
        **{name: plain[name] for name in _PLAIN} | {"notes": tuple(plain["notes"])},
    )


def _load(path: Path) -> dict[str, Any]:
    """All arrays; pickles are refused by numpy, and a plain .npy is no archive."""
    file = BytesIO(path.read_bytes())  # so that whatever fails from here on is damage, not the disk
    if not zipfile.is_zipfile(file):
        raise MeshError("damaged: no NumPy archive; the file seems cut off, write it anew")
    file.seek(0)
    with np.load(file, allow_pickle=False) as archive:
        return dict(archive)


def write_arrays(path: Path, arrays: dict[str, Any]) -> None:
    """Write an archive.

    Parameters
    ----------
    path : Path
        The file.
    arrays : dict of arrays
        By name.

    Returns
    -------
    None
    """
    with path.open("wb") as file:
        np.savez(file, **arrays)


FORMAT = Format("NPZ", (".npz",), read, write, magic=(b"PK\x03\x04",))
