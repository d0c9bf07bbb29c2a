"""A series in files: arrays, a table of frames, the frames at corresponding points, their mean, and their maps."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ...gate import PathLike
from ...io import npz
from ...io.replacing import make_folder
from ...io.tables import write_cells
from ...io.write_mesh import write_mesh
from ...mesh.arrays import FloatArray
from .files import write_mean
from .series import Series

#: The archive in a series' folder.
ARCHIVE = "series.npz"
_ARRAYS = ("vertices", "faces", "sphere", "areas", "features", "drift")


def write_series(
    folder: PathLike,
    found: Series,
    names: Sequence[str],
    feature_names: Sequence[str] = (),
) -> FloatArray:
    """Write a series into a folder, replacing an earlier one there, and return the mean of its frames.

    ``series.npz`` holds the arrays of `Series`; ``frames.tsv`` area, volume, movement and mean features of each frame;
    ``frames/frame_0000.vtk`` and so on the frames on one mesh, with areas and features; ``mean.*`` their mean in
    space, with drift and means in time. `series` writes each frame's map.
    """
    out = make_folder(Path(folder) / "frames", follow=False).parent
    npz.save_arrays(
        out / ARCHIVE,
        {name: getattr(found, name) for name in _ARRAYS}
        | {
            "names": np.array(names, dtype=str),
            "feature_names": np.array(feature_names, dtype=str),
        },
    )
    write_cells(out / "frames.tsv", frame_rows(found, names, feature_names), force=True)
    for k, (v, area, features) in enumerate(
        zip(found.vertices, found.areas, found.features, strict=True)
    ):
        data = {"area": area, **dict(zip(feature_names, features.T, strict=True))}
        write_mesh(
            out / "frames" / f"frame_{k:04d}.vtk",
            v,
            found.faces,
            force=True,
            metadata={"point_data": data},
        )
    mean = found.aligned.mean(axis=0)
    over = {
        "drift": found.drift,
        "area": found.areas.mean(axis=0),
        "growth": found.areas[-1] / found.areas[0],
    }
    for name, values in zip(feature_names, np.moveaxis(found.features, 2, 0), strict=True):
        over |= {name: values.mean(axis=0), f"{name}_sd": values.std(axis=0)}
    write_mean(out, mean, found.faces, over, {}, force=True)
    return mean


def frame_rows(
    found: Series, names: Sequence[str], feature_names: Sequence[str]
) -> list[Sequence[object]]:
    """The table of frames: movement is the root mean square over the area, since the frame before."""
    weights = found.areas / found.areas.sum(axis=1, keepdims=True)
    steps = np.diff(found.vertices, axis=0, prepend=found.vertices[:1])
    moved = np.sqrt((weights * (steps**2).sum(axis=2)).sum(axis=1))
    means = np.einsum("kn,knj->kj", weights, found.features)
    rows = zip(
        names,
        found.surface_areas.tolist(),
        found.volumes.tolist(),
        moved.tolist(),
        means.tolist(),
        strict=True,
    )
    return [
        ("frame", "area", "volume", "moved", *feature_names),
        *((*row, *mean) for *row, mean in rows),
    ]
