"""Maps between surfaces in NumPy archives: both maps to the sphere, and the landmarks."""

from __future__ import annotations

import json
from pathlib import Path

from ...errors import FileError, MeshError, Remedy
from ...gate import PathLike, gate
from ...io import npz
from ...io.reading import reading
from ...io.replacing import replacing
from ...io.written_map import mark_of
from ...resampling.locate import Location
from ...verify.certificate import Certificate
from .surface_map import SurfaceMap, checked_location

#: Before the names of the arrays of the target's map; those of the source's have the names that a map's archive has.
_TARGET = "target_"
_OWN = ("landmarks", "goal_faces", "goal_weights", "notes")


@gate
def write_surface_map(path: PathLike, result: SurfaceMap, *, force: bool = False) -> Certificate:
    """Write a map from one surface to another with all its data.

    `read_map` reads the source's map to the sphere, in the frame of the target's, from the same file; its array
    ``positions`` has the source's vertices on the target.

    Parameters
    ----------
    path, force
        As for `write_map`; the name ends in .npz.
    result : SurfaceMap
        The map.

    Returns
    -------
    Certificate
        Of the source's map, from the numbers in the file.

    Raises
    ------
    FileError
        As by `write_map`, or if the name ends otherwise.

    Examples
    --------
    >>> import tempfile
    >>> import igl_spheremap as ism
    >>> a, b = (ism.samples.make("pear", n_vertices=n) for n in (300, 420))
    >>> onto = ism.shapes.match(a, b, landmarks=([0, 100, 200], [0, 140, 280]))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     check = ism.shapes.write_surface_map(f"{folder}/onto.npz", onto)
    ...     again = ism.shapes.read_surface_map(f"{folder}/onto.npz")
    >>> check.folding_free, bool((again.positions == onto.positions).all())
    (True, True)
    """
    if Path(path).suffix.lower() != ".npz":
        raise FileError(f"{path}: a map between surfaces is written to .npz files")
    arrays = npz.arrays_of(result.map)
    arrays |= {_TARGET + name: array for name, array in npz.arrays_of(result.target).items()}
    arrays |= {
        "positions": result.positions, "landmarks": result.landmarks, "goal_faces": result.goals.face,
        "goal_weights": result.goals.weights, "notes": json.dumps(result.notes),
    }  # fmt: skip
    with replacing(path, force) as partial:
        npz.write_arrays(partial, arrays, {"mark": mark_of(result.map)})
        return Certificate.of(npz.read_arrays(partial)["sphere"], result.map.faces)


@gate
def read_surface_map(path: PathLike) -> SurfaceMap:
    """Read a map between surfaces from an NPZ file.

    Parameters
    ----------
    path : str or path-like
        A file that `write_surface_map` or ``igl-spheremap match`` wrote.

    Returns
    -------
    SurfaceMap
        Equal to the one that was written; both certificates are computed from the numbers in the file.

    Raises
    ------
    FileError
        If the file can't be read.
    MeshError
        If it holds no map between surfaces, or one that is damaged; see `write_surface_map` for an example.
    """
    with reading(Path(path)):
        arrays = npz.read_arrays(path)
        if not {*_OWN, _TARGET + "sphere"} <= arrays.keys():
            raise MeshError(
                "the archive holds no map between surfaces; give a file that was written by "
                f"{Remedy('write_surface_map', given='path, result')}"
            )
        target = npz.map_of(
            {
                name.removeprefix(_TARGET): array
                for name, array in arrays.items()
                if name.startswith(_TARGET)
            }
        )
        landmarks = arrays["landmarks"]
        own = npz.map_of(arrays)
        if (
            landmarks.ndim != 1
            or landmarks.dtype.kind != "i"
            or ((landmarks < 0) | (landmarks >= len(own.vertices))).any()
            or len(arrays["goal_faces"]) != len(landmarks)
        ):
            raise MeshError(
                "damaged: the landmarks are not vertices of the source with as many points of the target; "
                "write the file anew"
            )
        goals = checked_location(
            Location(arrays["goal_faces"], arrays["goal_weights"]), target.faces, "the target"
        )
        return SurfaceMap(own, target, landmarks, goals, tuple(json.loads(str(arrays["notes"]))))
