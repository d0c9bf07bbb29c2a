"""GIFTI surfaces (.surf.gii), scalar maps (.shape.gii, .func.gii; float32 by the standard) and labels, by nibabel."""

from __future__ import annotations

import binascii
import gzip
import zlib
from io import BytesIO
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from ..errors import MeshError, import_optional, printable
from ..mesh.arrays import FloatArray, IntArray
from .reading import check_expansion, expansion_limit
from .records import Label, Metadata, RawMesh, of_triangles

_GZIP = b"\x1f\x8b"
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
    content = path.read_bytes()
    stored = len(content)
    if content.startswith(_GZIP):
        with gzip.open(BytesIO(content)) as file:
            content = file.read(expansion_limit(stored) + 1)
        check_expansion(len(content), stored)
    _check_blocks(content, stored)
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

    ``geometric_type`` is "Anatomical" if none is given.
    """
    gifti = import_optional("nibabel.gifti", "GIFTI", "io")
    meta = _meta(gifti, metadata, GeometricType=metadata.get("geometric_type", "Anatomical"))
    points = gifti.GiftiDataArray(
        v.astype(np.float32),
        "NIFTI_INTENT_POINTSET",
        "NIFTI_TYPE_FLOAT32",
        meta=meta,
        coordsys=metadata.get("coordinate_system"),
    )
    triangles = gifti.GiftiDataArray(
        f.astype(np.int32),
        "NIFTI_INTENT_TRIANGLE",
        "NIFTI_TYPE_INT32",
        meta=gifti.GiftiMetaData(TopologicalType="Closed"),
    )
    _save(gifti, path, [points, triangles], metadata)


def read_scalars(path: Path) -> dict[str, NDArray[Any]]:
    """The data arrays by their names, or else their places."""
    return {
        dict(array.meta).get("Name") or str(k): array.data
        for k, array in enumerate(_load(path).darrays)
    }


def read_table(path: Path) -> tuple[Label, ...] | None:
    """The table of a file of labels; None if its arrays have another intent."""
    image = _load(path)
    if not image.get_arrays_from_intent("NIFTI_INTENT_LABEL"):
        return None
    return tuple(
        Label(int(row.key), printable(row.label or ""), row.rgba) for row in image.labeltable.labels
    )


def write_scalars(path: Path, maps: dict[str, FloatArray], metadata: Metadata) -> None:
    """Write maps, one data array each, in float32, or in int32 with their table if ``labels`` are known."""
    gifti = import_optional("nibabel.gifti", "GIFTI", "io")
    labelled = "labels" in metadata
    intent, code, kind = (
        ("LABEL", "INT32", np.int32) if labelled else ("SHAPE", "FLOAT32", np.float32)
    )
    arrays = [
        gifti.GiftiDataArray(
            values.astype(kind),
            f"NIFTI_INTENT_{intent}",
            f"NIFTI_TYPE_{code}",
            meta=gifti.GiftiMetaData(Name=name),
        )
        for name, values in maps.items()
    ]
    _save(gifti, path, arrays, metadata)


def _save(gifti: Any, path: Path, arrays: list[Any], metadata: Metadata) -> None:
    mark = {_MARK: metadata["mark"]} if "mark" in metadata else {}
    image = gifti.GiftiImage(meta=_meta(gifti, metadata, **mark), darrays=arrays)
    for label in metadata.get("labels", ()):
        row = gifti.GiftiLabel(label.key, *label.rgba)
        row.label = label.name
        image.labeltable.labels.append(row)
    content = image.to_xml()
    path.write_bytes(gzip.compress(content, mtime=0) if path.suffix.lower() == ".gz" else content)


def _meta(gifti: Any, metadata: Metadata, **entries: str) -> Any:
    structure = {_STRUCTURE: metadata["structure"]} if "structure" in metadata else {}
    return gifti.GiftiMetaData(structure | entries)
