"""CIFTI-2 files of data (.dscalar.nii, .dlabel.nii, .dtseries.nii), by nibabel; float32.

Each hemisphere has a model: its vertices that have data. The others, those of the medial wall, are NaN here.
"""

from __future__ import annotations

import re
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import FileError, MeshError, import_optional, printable
from ..mesh.arrays import AnyArray
from .formats import CIFTI_SCALARS, CIFTI_SERIES
from .nifti import array_behind, nibabel_for
from .records import Label, LabelTable, Metadata, NamedArrays, ScalarMaps

_PREFIX = "CIFTI_STRUCTURE_"


def read_scalars(path: Path, structure: str | None = None) -> NamedArrays:
    """The maps over a hemisphere, or over the only one that has any; NaN at vertices without data."""
    maps, rows, data = _load(path)
    models = {
        _ours(name): (where, model, rows.nvertices[name])
        for name, where, model in rows.iter_structures()
        if name in rows.nvertices
    }
    known = ", ".join(map(printable, models))
    if structure is None and len(models) != 1:
        raise MeshError(
            f"it holds data of {known or 'no surface'}, and the mesh does not say which it is; name it "
            "lh.NAME, rh.NAME or NAME_hemi-L"
        )
    if structure is None:
        structure = next(iter(models))
    if structure not in models:
        raise MeshError(f"it holds no data of {structure}; it has {known or 'none of a surface'}")
    where, model, n = models[structure]
    found = np.full((len(maps), n), np.nan)
    found[:, model.vertex] = data[:, where]
    names = [str(name) for name in getattr(maps, "name", range(len(maps)))]
    return dict(zip(names, found, strict=True))


def read_table(path: Path) -> LabelTable | None:
    """The table of labels, which all maps must have in common; None if they hold other data."""
    axis = _load(path)[0]
    if not hasattr(axis, "label"):
        return None
    if any(table != axis.label[0] for table in axis.label):
        raise MeshError(
            "its maps have tables of labels of their own; give a file of one map, as `wb_command "
            "-cifti-merge ONE.dlabel.nii -cifti FILE -column 1` makes it"
        )
    return tuple(
        Label(int(key), printable(name), tuple(map(float, rgba)))  # type: ignore[arg-type]
        for key, (name, rgba) in axis.label[0].items()
    )


def write_scalars(path: Path, maps: ScalarMaps, metadata: Metadata) -> None:
    """Write maps over ``structure`` of the metadata, and those over its ``others`` by their structures.

    Vertices at which all maps are NaN get no data.
    """
    cifti2 = import_optional("nibabel.cifti2", "CIFTI", "io")
    if "structure" not in metadata:
        raise FileError(
            "a CIFTI file names the hemisphere of its data; name the surface lh.NAME, rh.NAME or NAME_hemi-L"
        )
    names, name = list(maps), path.name.lower()
    axis: Any
    if name.endswith(CIFTI_SCALARS):
        axis = cifti2.ScalarAxis(names)
    elif name.endswith(CIFTI_SERIES):
        axis = cifti2.SeriesAxis(0, 1, len(names))
    elif metadata.get("labels"):
        table = {label.key: (label.name, label.rgba) for label in metadata["labels"]}
        axis = cifti2.LabelAxis(names, [table] * len(names))
    else:
        raise MeshError(
            "a .dlabel.nii file names labels, and the data have no table of them; write .dscalar.nii"
        )
    models, parts = [], []
    for structure, each in {metadata["structure"]: maps, **metadata.get("others", {})}.items():
        rows = np.stack([each[key] for key in names])
        kept = np.flatnonzero(~np.isnan(rows).all(axis=0))
        models.append(cifti2.BrainModelAxis.from_surface(kept, rows.shape[1], _theirs(structure)))
        parts.append(rows[:, kept])
    data = np.concatenate(parts, axis=1)
    kind: type = np.float32
    if "labels" in metadata:
        data, kind = np.nan_to_num(data), np.int32
    image = cifti2.Cifti2Image(data.astype(kind), header=(axis, sum(models[1:], models[0])))
    path.write_bytes(image.to_bytes())


def _load(path: Path) -> tuple[Any, Any, AnyArray]:
    """The axes of maps and of vertices, and the maps, one a row.

    The header is read without nibabel's checks, which print their mends.
    """
    content = path.read_bytes()
    with nibabel_for("CIFTI") as nibabel:
        header = nibabel.Nifti2Header.from_fileobj(BytesIO(content), check=False)
        cifti = nibabel.nifti1.extension_codes["cifti"]
        known = [each.get_content() for each in header.extensions if each.get_code() == cifti]
        if not known:
            raise MeshError("it is an image, not data over surfaces; give a CIFTI file")
        maps, rows = (known[0].get_axis(k) for k in range(2))
        if not hasattr(rows, "iter_structures"):
            raise MeshError(
                "it holds data of parcels, not of vertices; give a dense file, such as .dscalar.nii"
            )
        return maps, rows, array_behind(header, content).reshape(len(maps), len(rows))


def _theirs(structure: str) -> str:
    """CIFTI's name of a structure of GIFTI's.

    >>> _theirs("CortexLeft"), _ours("CIFTI_STRUCTURE_CORTEX_LEFT")
    ('CIFTI_STRUCTURE_CORTEX_LEFT', 'CortexLeft')
    """
    return _PREFIX + re.sub("(?<!^)(?=[A-Z])", "_", structure).upper()


def _ours(name: str) -> str:
    return "".join(word.capitalize() for word in name.removeprefix(_PREFIX).split("_"))
