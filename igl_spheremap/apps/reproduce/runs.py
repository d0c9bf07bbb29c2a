"""The surfaces that stand for the paper's, and runs of methods on them, kept in files."""

from __future__ import annotations

import csv
import hashlib
import importlib.util
import json
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import igl
import numpy as np

from ... import samples
from ..._version import __version__
from ...errors import FactorisationFailed, FileError, MapError, MeshError
from ...io.files import read_mesh
from ...io.replacing import replacing
from ...maps.options import Auto, GuYau, Lai2014, Method
from ...maps.spherical_conformal_map import spherical_conformal_map
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import check_mesh
from ...result.recording import Recording
from ...result.run import Iterate, Listener
from ...verify.distortion import angle_differences


@dataclass(frozen=True)
class Counterpart:
    """What stands for a surface of the paper: a file of the folder, or a sample."""

    file: str
    relation: str
    sample: str
    sample_relation: str
    #: Number of vertices to which the file is simplified; empty if it is taken as it is.
    simplify_to: str = ""
    #: The direction of the file's that is up, if it does not show where it stands.
    up: str = "auto"


@dataclass(frozen=True, eq=False)
class PaperSurface:
    """A checked mesh under the paper's name, where it is from, and how it relates to the paper's."""

    name: str
    v: FloatArray
    f: IntArray
    source: str
    relation: str
    up: str = "auto"

    @property
    def digest(self) -> str:
        """A hash of the mesh."""
        return hashlib.sha256(self.v.tobytes() + self.f.tobytes()).hexdigest()[:16]


_GRAY_MATTER = "public/fsaverage5_pial_left.obj"
_TABLE = files(__package__).joinpath("counterparts.csv").read_text(encoding="utf-8")
#: What stands for each surface, by the paper's name of it.
COUNTERPARTS = {row.pop("surface"): Counterpart(**row) for row in csv.DictReader(_TABLE.splitlines())}


def load_surface(name: str, folder: Path | None) -> PaperSurface:
    """The surface that stands for one of `COUNTERPARTS`: from the folder, from nilearn, or a sample.

    >>> load_surface("Bird 1", None).source
    'sample:bird:n_vertices=890'
    """
    one = COUNTERPARTS[name]
    up = one.up
    if folder is not None and one.file and (folder / one.file).is_file():
        v, f = _read(folder / one.file)
        source, relation = one.file, one.relation
        if one.simplify_to:
            v, f = _simplified(v, f, int(one.simplify_to))
    elif one.file == _GRAY_MATTER and (shipped := _nilearn_fsaverage()) is not None:
        v, f = _read(shipped)
        source, relation = f"nilearn's {shipped.name}", one.relation
    else:
        v, f = samples.from_spec(one.sample)
        source, relation, up = f"sample:{one.sample}", one.sample_relation, "auto"
    check_mesh(v, f)
    return PaperSurface(name, v, f, source, relation, up)


def all_surfaces(folder: Path | None) -> Iterator[PaperSurface]:
    """All samples, and all closed meshes of genus 0 of a folder and its subfolders."""
    for name in samples.names():
        yield PaperSurface(name, *samples.make(name), f"sample:{name}", "the sample")
    for path in sorted(folder.rglob("*.obj")) if folder else ():
        try:
            v, f = _read(path)
            check_mesh(v, f)
        except (FileError, MeshError):
            continue
        yield PaperSurface(path.stem, v, f, str(path), "the file")


def _read(path: Path) -> tuple[FloatArray, IntArray]:
    """Positions and faces; archives of the corpus hold arrays `v` and `f`."""
    if path.suffix == ".npz":
        with np.load(path) as arrays:
            return arrays["v"], arrays["f"].astype(np.int64)
    mesh = read_mesh(path)
    return mesh.v, mesh.f


def _simplified(v: FloatArray, f: IntArray, n: int) -> tuple[FloatArray, IntArray]:
    """Quadric simplification to n vertices."""
    v, f, _, _ = igl.qslim(np.asfortranarray(v), np.asfortranarray(f, dtype=np.int32), 2 * n - 4)
    return np.ascontiguousarray(v), np.ascontiguousarray(f, dtype=np.int64)


def _nilearn_fsaverage() -> Path | None:
    """The pial surface that nilearn ships, if it is installed and files can be read."""
    if importlib.util.find_spec("nibabel") is None:
        return None
    spec = importlib.util.find_spec("nilearn")
    for root in (spec.submodule_search_locations or ()) if spec else ():
        path = Path(root) / "datasets" / "data" / "fsaverage5" / "pial_left.gii.gz"
        if path.is_file():
            return path
    return None


#: What is run, by the name that tables give it.
METHODS: dict[str, Method] = {
    "Algorithm 1": Lai2014(rounds=0),
    "Algorithm 2": Lai2014(),
    "Delaunay weights": Lai2014(edge_weights="delaunay"),
    "Gu-Yau": GuYau(tutte=False),
    "fast": Auto(),
    "Algorithm 1 without a stopping rule": Lai2014(rounds=0, gradient_tolerance=0, plateau=0),
}

#: Share by which an energy may miss the common one and still count as having reached it.
_REACHED = 1e-6
#: Stages of iterates that only start a minimisation, whose own first iterate follows.
_STARTS = ("gauss map", "star map")


def _nothing() -> FloatArray:
    return np.empty(0)


@dataclass(frozen=True, eq=False)
class Outcome:
    """The outcome of a run.

    `rounds` holds the fields of each `Round`, its status by name; `seconds` is CPU time; `foldings` is -1 where
    there is no map, and `status` then the error's message. `energies`, `residuals` and `clock`, CPU seconds, are (k,)
    over all iterates of minimisations. `maps` (r, n, 3) are the rounds' last iterates.
    """

    status: str
    seconds: float
    rounds: list[dict[str, Any]] = field(default_factory=list)
    iterations: int = 0
    energy: float = float("nan")
    foldings: int = -1
    energies: FloatArray = field(default_factory=_nothing)
    residuals: FloatArray = field(default_factory=_nothing)
    clock: FloatArray = field(default_factory=_nothing)
    maps: FloatArray = field(default_factory=_nothing)
    sphere: FloatArray = field(default_factory=_nothing)

    def mean_angle(self, surface: PaperSurface) -> float:
        """Mean size of the angle differences of the result in degrees; NaN if there is no map."""
        if self.foldings < 0:
            return float("nan")
        return float(np.abs(angle_differences(surface.v, surface.f, self.sphere)).mean())

    def reach(self, energy: float) -> tuple[int, float]:
        """Iterations and CPU seconds down to an energy."""
        k = int(np.argmax(self.energies <= energy))
        return k, float(self.clock[k])


class Runs:
    """All runs, computed at first use and kept in a folder: a file for each mesh, method, cap and version.

    `meshes` is a folder of real counterparts of the paper's surfaces. `report` takes a line on each run, `listen`
    makes a listener for a run on a mesh with these faces.
    """

    def __init__(
        self,
        folder: Path,
        meshes: Path | None = None,
        max_iterations: int | None = None,
        report: Callable[[str], None] = lambda line: None,
        listen: Callable[[IntArray], Listener | None] = lambda f: None,
    ) -> None:
        self._folder, self.meshes, self._cap = folder, meshes, max_iterations
        self._report, self._listen = report, listen

    def surface(self, name: str, sample: bool = False) -> PaperSurface:
        """The surface that stands for one of the paper's; a sample if asked, or where the meshes lack it."""
        return load_surface(name, None if sample else self.meshes)

    def get(self, surface: PaperSurface, name: str, method: Method | None = None) -> Outcome:
        """The outcome of a method, by default that of `METHODS`; of a failed run, the status is the error's message."""
        method = method or METHODS[name]
        if self._cap is not None and isinstance(method, Lai2014 | GuYau):  # those that take thousands of iterations
            method = replace(method, max_iterations=self._cap)
        key = json.dumps([surface.digest, method.name, method.settings(), __version__, _ARRAYS], sort_keys=True)
        path = self._folder / f"{hashlib.sha256(key.encode()).hexdigest()[:20]}.npz"
        if path.is_file():
            return _load(path)
        self._report(f"{name} on {surface.name} ({surface.source}, {len(surface.v)} vertices) ...")
        outcome = run(surface, method, self._listen(surface.f))
        self._report(f"    {outcome.iterations} iterations, {outcome.seconds:.1f} s, {outcome.foldings} foldings")
        _save(path, outcome)
        return outcome


class _Timed(Recording):
    """Recording of the ends of all stages that keeps CPU seconds, too, its own left out, and passes iterates on."""

    def __init__(self, f: IntArray, listener: Listener | None) -> None:
        super().__init__(f, budget=0)
        self._next = listener
        self.clock: list[float] = []
        self._began, self._own = time.process_time(), 0.0

    @property
    def seconds(self) -> float:
        """CPU seconds so far."""
        return time.process_time() - self._began - self._own

    def __call__(self, iterate: Iterate) -> None:
        """Keep the iterate."""
        seconds = self.seconds
        self.clock.append(seconds)
        try:
            super().__call__(iterate)
            if self._next is not None:
                self._next(iterate)
        finally:
            self._own += self.seconds - seconds


def run(surface: PaperSurface, method: Method, listener: Listener | None = None) -> Outcome:
    """Map a surface and record the run; an error that the method raises is the outcome's status."""
    record = _Timed(surface.f, listener)
    n = len(surface.v)
    try:
        result = spherical_conformal_map(surface.v, surface.f, method, listener=record)
    except (MapError, FactorisationFailed) as error:
        return Outcome(str(error), record.seconds, sphere=np.full((n, 3), np.nan))
    steps = [k for k, step in enumerate(record.history) if step.stage not in _STARTS]
    maps = {frame.iterate.round: frame.iterate.x for frame in record.frames if frame.iterate.stage not in _STARTS}
    return Outcome(
        result.status.name,
        record.seconds,
        [asdict(entry) | {"status": entry.status.name} for entry in result.rounds],
        result.iterations,
        result.energy,
        result.certificate.foldings,
        np.array([record.history[k].energy for k in steps]),
        np.array([record.history[k].residual for k in steps]),
        np.array(record.clock)[steps],
        np.array(list(maps.values())).reshape(-1, n, 3),
        result.sphere,
    )


_ARRAYS = ("energies", "residuals", "clock", "maps", "sphere")


def _save(path: Path, outcome: Outcome) -> None:
    facts = {key: value for key, value in outcome.__dict__.items() if key not in _ARRAYS}
    with replacing(path, force=True) as partial, partial.open("wb") as stream:
        np.savez(stream, facts=np.array(json.dumps(facts)), **{key: getattr(outcome, key) for key in _ARRAYS})


def _load(path: Path) -> Outcome:
    with np.load(path) as stored:
        return Outcome(**json.loads(str(stored["facts"])), **{key: stored[key] for key in _ARRAYS})


def to_common_energy(first: Outcome, second: Outcome) -> tuple[tuple[int, float], tuple[int, float]] | None:
    """Iterations and CPU seconds of both runs down to the lowest energy that both reach; None if one has no map.

    Their own stopping rules end them at different places: only this compares work for work.

    >>> def course(*energies):
    ...     e = np.array(energies, dtype=float)
    ...     return Outcome("", 0.0, energies=e, clock=np.arange(len(e)) / 10)
    >>> to_common_energy(course(9, 5, 4, 3), course(9, 8, 7, 6, 5, 4.5))
    ((2, 0.2), (5, 0.5))
    """
    if not len(first.energies) or not len(second.energies):
        return None
    target = max(first.energies.min(), second.energies.min()) * (1 + _REACHED)
    return first.reach(target), second.reach(target)
