"""Runs of methods on surfaces, kept in files."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..._version import __version__
from ...errors import FactorisationFailed, MapError
from ...io.replacing import replacing
from ...maps.options import Auto, GuYau, Lai2014, Method
from ...maps.spherical_conformal_map import spherical_conformal_map
from ...mesh.arrays import FloatArray, IntArray
from ...result.recording import Recording
from ...result.run import Iterate, Listener
from ...verify.distortion import angle_differences
from .surfaces import PaperSurface, load_surface

#: What is run, by the name that tables give it.
METHODS: dict[str, Method] = {
    "Algorithm 1 as printed": Lai2014.as_printed(rounds=0),
    "Algorithm 1 made safe": Lai2014(rounds=0),
    "Algorithm 1 made safe, Laplacian's metric": Lai2014(rounds=0, metric="laplacian"),
    "Algorithm 2 as printed": Lai2014.as_printed(),
    "Algorithm 2 made safe": Lai2014(),
    "Algorithm 2 made safe, Laplacian's metric": Lai2014(metric="laplacian"),
    "Algorithm 2 made safe, Delaunay weights": Lai2014(edge_weights="delaunay"),
    "Gu-Yau": GuYau(tutte=False),
    "default": Auto(),
    "Algorithm 1 without a stopping rule": Lai2014(rounds=0, gradient_tolerance=0, plateau=0),
}
#: About how many CPU milliseconds a vertex they take: medians over the corpus.
_COSTS = {
    "Algorithm 1 as printed": 1.0,
    "Algorithm 1 made safe": 0.5,
    "Algorithm 1 made safe, Laplacian's metric": 0.2,
    "Algorithm 2 as printed": 3.5,
    "Algorithm 2 made safe": 1.5,
    "Algorithm 2 made safe, Laplacian's metric": 0.5,
    "Algorithm 2 made safe, Delaunay weights": 2.0,
    "Gu-Yau": 2.5,
    "default": 0.05,
    "Algorithm 1 without a stopping rule": 1.0,
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
    there is no map, and `status` then the error's message. `mean_angle` is the mean size of the angle differences in
    degrees. `energies`, `residuals` and `clock`, CPU seconds, are (k,) over all iterates of minimisations. `maps` (r,
    n, 3) are the rounds' last iterates.
    """

    status: str
    seconds: float
    rounds: list[dict[str, Any]] = field(default_factory=list)
    iterations: int = 0
    energy: float = float("nan")
    foldings: int = -1
    mean_angle: float = float("nan")
    energies: FloatArray = field(default_factory=_nothing)
    residuals: FloatArray = field(default_factory=_nothing)
    clock: FloatArray = field(default_factory=_nothing)
    maps: FloatArray = field(default_factory=_nothing)
    sphere: FloatArray = field(default_factory=_nothing)

    def reach(self, energy: float) -> tuple[int, float]:
        """Iterations and CPU seconds down to an energy."""
        k = int(np.argmax(self.energies <= energy))
        return k, float(self.clock[k])


@dataclass(frozen=True, eq=False)
class PaperRun:
    """A run that may be kept already: a method on a surface, or on a renumbered copy, of which only counts are kept."""

    surface: PaperSurface
    name: str
    method: Method
    copy: int = 0

    @property
    def cost(self) -> float:
        """About how many CPU seconds it takes."""
        return 1e-3 * _COSTS.get(self.name, 0.05) * len(self.surface.v)

    @property
    def title(self) -> str:
        """What it is, in words."""
        copy = f", renumbered copy {self.copy}" if self.copy else ""
        return f"{self.name} on {self.surface.name}{copy} ({self.surface.source}, {len(self.surface.v):,} vertices)"


class Runs:
    """All runs, computed at first use and kept in a folder: a file for each mesh, method, cap and version.

    `meshes` is a folder of real counterparts of the paper's surfaces. `copies` is how many renumbered copies of a
    surface tables compare. `report` takes a line on each run, `listen` makes a listener for a run on a mesh with these
    faces.
    """

    def __init__(
        self,
        folder: Path,
        meshes: Path | None = None,
        max_iterations: int | None = None,
        copies: int = 0,
        report: Callable[[str], None] = lambda line: None,
        listen: Callable[[IntArray], Listener | None] = lambda f: None,
    ) -> None:
        self._folder, self.meshes, self.copies, self._cap = folder, meshes, copies, max_iterations
        self._report, self._listen = report, listen
        self._surfaces: dict[tuple[str, bool], PaperSurface] = {}
        self._ahead: dict[Path, float] = {}

    def surface(self, name: str, sample: bool = False) -> PaperSurface:
        """The surface that stands for one of the paper's; a sample if asked, or where the meshes lack it."""
        if (name, sample) not in self._surfaces:
            self._surfaces[name, sample] = load_surface(name, None if sample else self.meshes)
        return self._surfaces[name, sample]

    def plan(self, surface: PaperSurface, name: str, method: Method | None = None, copy: int = 0) -> PaperRun:
        """A run of a method, by default that of `METHODS`, within the cap of iterations."""
        method = method or METHODS[name]
        if self._cap is not None and isinstance(method, Lai2014 | GuYau):  # those that take thousands of iterations
            method = replace(method, max_iterations=self._cap)
        return PaperRun(surface, name, method, copy)

    def announce(self, planned: Iterable[PaperRun]) -> None:
        """Report how many of the runs are not kept yet, and about how long they take."""
        self._ahead = {self._path(one): one.cost for one in planned if not self._path(one).is_file()}
        if self._ahead:
            self._report(f"{len(self._ahead)} runs to do, {duration(sum(self._ahead.values()))} of one processor; "
                         f"finished ones are kept in {self._folder}: interrupt it when you like, and run it again")

    def get(self, surface: PaperSurface, name: str, method: Method | None = None, copy: int = 0) -> Outcome:
        """The outcome of a method, by default that of `METHODS`; of a failed run, the status is the error's message."""
        planned = self.plan(surface, name, method, copy)
        path = self._path(planned)
        if path.is_file():
            return _load(path)
        left = f"{len(self._ahead)} runs left, {duration(sum(self._ahead.values()))}: " if self._ahead else ""
        self._report(f"{left}{planned.title} ...")
        mesh = surface.renumbered(copy) if copy else surface
        outcome = run(mesh, planned.method, self._listen(mesh.f))
        self._ahead.pop(path, None)
        self._report(f"    {outcome.iterations:,} iterations, {outcome.seconds:.1f} s, {outcome.foldings:,} foldings")
        if copy:
            none = _nothing()
            outcome = replace(outcome, energies=none, residuals=none, clock=none, maps=none, sphere=none)
        _save(path, outcome)
        return outcome

    def spread(self, surface: PaperSurface, name: str) -> list[Outcome]:
        """The outcomes of a method on a surface and on its renumbered copies."""
        return [self.get(surface, name, copy=copy) for copy in range(self.copies + 1)]

    def cells(self, surface: PaperSurface, name: str, settings: Any, compute: Callable[[], list[str]]) -> list[str]:
        """Cells of a table that take long to compute and are not runs, kept as runs are."""
        path = self._file([surface.digest, name, settings, __version__], "json")
        if not path.is_file():
            self._report(f"{name} on {surface.name} ({surface.source}, {len(surface.v):,} vertices) ...")
            found = json.dumps(compute())
            with replacing(path, force=True) as partial:
                partial.write_text(found, encoding="utf-8")
        kept: list[str] = json.loads(path.read_text(encoding="utf-8"))
        return kept

    def _path(self, one: PaperRun) -> Path:
        method = one.method
        return self._file([one.surface.digest, one.copy, method.name, asdict(method), __version__, _ARRAYS], "npz")

    def _file(self, key: list[Any], suffix: str) -> Path:
        return self._folder / f"{hashlib.sha256(json.dumps(key, sort_keys=True).encode()).hexdigest()[:20]}.{suffix}"


def settings() -> str:
    """All methods with their options, as JSON: what tables were made by is known from it."""
    return json.dumps({name: asdict(method) for name, method in METHODS.items()}, indent=1, sort_keys=True) + "\n"


def duration(seconds: float) -> str:
    """About how long, in words.

    >>> duration(20), duration(130)
    ('less than a minute', 'about 3 minutes')
    """
    minutes = int(np.ceil(seconds / 60))
    return "less than a minute" if minutes <= 1 else f"about {minutes} minutes"


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
        result = spherical_conformal_map(surface.v, surface.f, method=method, listener=record)
    except (MapError, FactorisationFailed) as error:
        return Outcome(str(error), record.seconds, sphere=np.full((n, 3), np.nan))
    seconds = record.seconds
    steps = [k for k, step in enumerate(record.history) if step.stage not in _STARTS]
    maps = {frame.iterate.round: frame.iterate.x for frame in record.frames if frame.iterate.stage not in _STARTS}
    return Outcome(
        result.status.name,
        seconds,
        [asdict(entry) | {"status": entry.status.name} for entry in result.rounds],
        result.iterations,
        result.energy,
        result.certificate.foldings,
        float(np.abs(angle_differences(surface.v, surface.f, result.sphere)).mean()),
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
