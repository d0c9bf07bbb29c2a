"""GIFTI surfaces (.surf.gii) and scalar maps (.shape.gii, .func.gii), by nibabel; float32 by the standard."""

from __future__ import annotations

import gzip
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import MeshError, import_optional
from .polygons import of_triangles
from .records import FloatArray, Format, IntArray, Metadata, RawMesh

_GZIP = b"\x1f\x8b"
_STRUCTURE = "AnatomicalStructurePrimary"


def read(path: Path) -> RawMesh:
    """Read a GIFTI surface, with its structure and coordinate system.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    RawMesh
        Positions as stored, in their own coordinate system, and faces.

    Raises
    ------
    MeshError
        If it holds no surface.
    FileError
        If nibabel is not installed.
    """
    gifti = import_optional("nibabel.gifti", "GIFTI", "io")
    content = path.read_bytes()
    image = gifti.GiftiImage.from_bytes(gzip.decompress(content) if content.startswith(_GZIP) else content)
    points = image.get_arrays_from_intent("NIFTI_INTENT_POINTSET")
    triangles = image.get_arrays_from_intent("NIFTI_INTENT_TRIANGLE")
    if not points or not triangles:
        raise MeshError(
            "no surface in the GIFTI file: it holds no points and triangles (a scalar map or a label "
            "file?); give a .surf.gii"
        )
    metadata: dict[str, Any] = {}
    structure = dict(points[0].meta).get(_STRUCTURE) or dict(image.meta).get(_STRUCTURE)
    if structure:
        metadata["structure"] = structure
    if points[0].coordsys is not None:
        metadata["coordinate_system"] = points[0].coordsys
    return RawMesh(np.array(points[0].data, dtype=np.float64), of_triangles(triangles[0].data), metadata)


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write a GIFTI surface in float32.

    Parameters
    ----------
    path : Path
        The file.
    v : (n, 3) float64 array
        Positions.
    f : (m, 3) int64 array
        Faces.
    metadata : dict
        ``structure`` and ``coordinate_system`` are kept; ``geometric_type`` (``"Spherical"``) is stated.

    Returns
    -------
    None
    """
    gifti = import_optional("nibabel.gifti", "GIFTI", "io")
    meta = _meta(gifti, metadata, GeometricType=metadata.get("geometric_type", "Anatomical"))
    arrays = [
        gifti.GiftiDataArray(
            v.astype(np.float32),
            "NIFTI_INTENT_POINTSET",
            "NIFTI_TYPE_FLOAT32",
            meta=meta,
            coordsys=metadata.get("coordinate_system"),
        ),
        gifti.GiftiDataArray(
            f.astype(np.int32),
            "NIFTI_INTENT_TRIANGLE",
            "NIFTI_TYPE_INT32",
            meta=gifti.GiftiMetaData(TopologicalType="Closed"),
        ),
    ]
    _save(gifti, path, arrays, metadata)


def read_scalars(path: Path) -> dict[str, FloatArray]:
    """The data arrays that hold one number a vertex, by their names, or else their places."""
    gifti = import_optional("nibabel.gifti", "GIFTI", "io")
    content = path.read_bytes()
    image = gifti.GiftiImage.from_bytes(gzip.decompress(content) if content.startswith(_GZIP) else content)
    return {
        dict(array.meta).get("Name") or str(k): np.array(array.data, dtype=np.float64)
        for k, array in enumerate(image.darrays)
        if array.data.ndim == 1
    }


def write_scalars(path: Path, maps: dict[str, FloatArray], metadata: Metadata) -> None:
    """Write scalar maps, one data array each, in float32.

    Parameters
    ----------
    path : Path
        The file.
    maps : dict of (n,) float64 arrays
        Values at the vertices, by name.
    metadata : dict
        ``structure`` is kept.

    Returns
    -------
    None
    """
    gifti = import_optional("nibabel.gifti", "GIFTI", "io")
    arrays = [
        gifti.GiftiDataArray(
            values.astype(np.float32),
            "NIFTI_INTENT_SHAPE",
            "NIFTI_TYPE_FLOAT32",
            meta=gifti.GiftiMetaData(Name=name),
        )
        for name, values in maps.items()
    ]
    _save(gifti, path, arrays, metadata)


def _save(gifti: Any, path: Path, arrays: list[Any], metadata: Metadata) -> None:
    image = gifti.GiftiImage(meta=_meta(gifti, metadata), darrays=arrays)
    content = image.to_xml()
    path.write_bytes(gzip.compress(content, mtime=0) if path.suffix.lower() == ".gz" else content)


def _meta(gifti: Any, metadata: Metadata, **entries: str) -> Any:
    structure = {_STRUCTURE: metadata["structure"]} if "structure" in metadata else {}
    return gifti.GiftiMetaData(structure | entries)


FORMAT = Format("GIFTI", (".gii", ".gii.gz"), read, write, magic=(b"<?xml", _GZIP), radius=100.0, single=True)
