"""GIFTI surfaces (.surf.gii), scalar maps (.shape.gii, .func.gii; float32 by the standard) and labels, by nibabel."""

from __future__ import annotations

import binascii
import gzip
import zlib
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import DTypeLike

from ..errors import MeshError, import_optional, printable
from ..mesh.arrays import AnyArray, FloatArray, IntArray
from .reading import check_expansion, expansion_limit, unpacked
from .records import Label, LabelTable, Metadata, NamedArrays, RawMesh, ScalarMaps, of_triangles

_STRUCTURE = "AnatomicalStructurePrimary"
_MARK = "ProgramProvenance"  # the name that Connectome Workbench gives such an entry


def read(path: Path) -> RawMesh:
    """A surface as stored, with its structure and coordinate system."""
    image = _load(path)
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
        metadata["structure"] = printable(structure)
    if points[0].coordsys is not None:
        metadata["coordinate_system"] = points[0].coordsys
    return RawMesh(points[0].data, of_triangles(triangles[0].data), metadata)


def _load(path: Path) -> Any:
    gifti = import_optional("nibabel.gifti", "GIFTI", "io")
    content = unpacked(path)
    _check_blocks(content, path.stat().st_size)
    return gifti.GiftiImage.from_bytes(content)


def _check_blocks(content: bytes, stored: int) -> None:
    """Refuse blocks of data that expand too far, and too many dimensions, neither of which nibabel limits."""
    expanded = 0
    for element in ElementTree.fromstring(content).iter():
        if len(element.get("Dimensionality", "1")) > 1:
            raise MeshError("damaged: an array of more than 9 dimensions; write the file anew")
        try:
            block = binascii.a2b_base64(element.text or "")
            expanded += len(zlib.decompressobj().decompress(block, expansion_limit(stored) + 1))
        except (ValueError, zlib.error):  # text, or not compressed
            continue
        check_expansion(expanded, stored)


def write(path: Path, v: FloatArray, f: IntArray, metadata: Metadata) -> None:
    """Write a surface in float32; ``structure``, ``coordinate_system`` and the mark are kept.

    If none is given, ``geometric_type`` is "Anatomical".
    """
    kind = {"GeometricType": metadata.get("geometric_type", "Anatomical")}
    points = _array(
        v,
        "POINTSET",
        np.float32,
        _structure(metadata) | kind,
        metadata.get("coordinate_system"),
    )
    triangles = _array(f, "TRIANGLE", np.int32, {"TopologicalType": "Closed"})
    _save(path, [points, triangles], metadata)


def read_scalars(path: Path) -> NamedArrays:
    """The data arrays by their names, or else their places."""
    arrays = {}
    for k, array in enumerate(_load(path).darrays):
        arrays[dict(array.meta).get("Name") or str(k)] = array.data
    return arrays


def read_table(path: Path) -> LabelTable | None:
    """The table of a file of labels; None if its arrays have another intent."""
    image = _load(path)
    if not image.get_arrays_from_intent("NIFTI_INTENT_LABEL"):
        return None
    rows = [(int(row.key), row.label, row.rgba) for row in image.labeltable.labels]
    return tuple(Label(key, printable(name or ""), rgba) for key, name, rgba in rows)


def write_scalars(path: Path, maps: ScalarMaps, metadata: Metadata) -> None:
    """Write maps, one data array each, in float32, or in int32 with their table if ``labels`` are known."""
    intent, kind = "SHAPE", "float32"
    if "labels" in metadata:
        intent, kind = "LABEL", "int32"
    _save(
        path,
        [_array(values, intent, kind, {"Name": name}) for name, values in maps.items()],
        metadata,
    )


def _array(
    values: AnyArray, intent: str, kind: DTypeLike, meta: dict[str, str], coordsys: Any = None
) -> Any:
    gifti, dtype = import_optional("nibabel.gifti", "GIFTI", "io"), np.dtype(kind)
    return gifti.GiftiDataArray(
        values.astype(dtype),
        f"NIFTI_INTENT_{intent}",
        f"NIFTI_TYPE_{dtype.name.upper()}",
        meta=gifti.GiftiMetaData(meta),
        coordsys=coordsys,
    )


def _structure(metadata: Metadata) -> dict[str, str]:
    if "structure" not in metadata:
        return {}
    return {_STRUCTURE: metadata["structure"]}


def _save(path: Path, arrays: list[Any], metadata: Metadata) -> None:
    gifti, meta = import_optional("nibabel.gifti", "GIFTI", "io"), _structure(metadata)
    if "mark" in metadata:
        meta[_MARK] = metadata["mark"]
    image = gifti.GiftiImage(meta=gifti.GiftiMetaData(meta), darrays=arrays)
    for label in metadata.get("labels", ()):
        row = gifti.GiftiLabel(label.key, *label.rgba)
        row.label = label.name
        image.labeltable.labels.append(row)
    content = image.to_xml()
    if path.suffix.lower() == ".gz":
        content = gzip.compress(content, mtime=0)
    path.write_bytes(content)
