"""Runs of methods on surfaces, kept in files, from which an interrupted command continues."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable
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
from ...result.run import Iterate, Listener
from ...verify.distortion import angle_differences
from .surfaces import Surface, load_surface

#: What is run, by the name that tables give it.
METHODS: dict[str, Method] = {
    "Algorithm 1": Lai2014(rounds=0),
    "Algorithm 2": Lai2014(),
    "Delaunay weights": Lai2014(weights="delaunay"),
    "Gu-Yau": GuYau(tutte=False),
    "fast": Auto(),
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
    there is no map, and `status` then the error's message. `energies` and `clock`, CPU seconds, are (k,) over all
    iterates of minimisations. `maps` (r, n, 3) are the rounds' last iterates.
    """

    status: str
    seconds: float
    rounds: list[dict[str, Any]] = field(default_factory=list)
    iterations: int = 0
    energy: float = float("nan")
    foldings: int = -1
    energies: FloatArray = field(default_factory=_nothing)
    clock: FloatArray = field(default_factory=_nothing)
    maps: FloatArray = field(default_factory=_nothing)
    sphere: FloatArray = field(default_factory=_nothing)

    def mean_angle(self, surface: Surface) -> float:
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
        self._folder, self._meshes, self._cap = folder, meshes, max_iterations
        self._report, self._listen = report, listen

    def surface(self, name: str, sample: bool = False) -> Surface:
        """The surface that stands for one of the paper's; a sample if asked, or where the meshes lack it."""
        return load_surface(name, None if sample else self._meshes)

    def get(self, surface: Surface, name: str) -> Outcome:
        """The outcome of a method of `METHODS` on a surface; of a failed run, the status is the error's message."""
        method = METHODS[name]
        if self._cap is not None and isinstance(method, Lai2014 | GuYau):  # those that take thousands of iterations
            method = replace(method, max_iterations=self._cap)
        key = json.dumps([surface.digest, method.name, method.settings(), __version__], sort_keys=True)
        path = self._folder / f"{hashlib.sha256(key.encode()).hexdigest()[:20]}.npz"
        if path.is_file():
            return _load(path)
        self._report(f"{name} on {surface.name} ({surface.source}, {len(surface.v)} vertices) ...")
        outcome = run(surface, method, self._listen(surface.f))
        self._report(f"    {outcome.iterations} iterations, {outcome.seconds:.1f} s, {outcome.foldings} foldings")
        _save(path, outcome)
        return outcome


class _Watch:
    """Listener that keeps energies, times and the last map of each round, and passes iterates on."""

    def __init__(self, listener: Listener | None) -> None:
        self._listener = listener
        self.energies: list[float] = []
        self.clock: list[float] = []
        self.maps: dict[int, FloatArray] = {}
        self._began = time.process_time()

    def __call__(self, iterate: Iterate) -> None:
        if iterate.stage not in _STARTS:
            self.energies.append(iterate.energy)
            self.clock.append(time.process_time() - self._began)
            self.maps[iterate.round] = iterate.x
        if self._listener is not None:
            self._listener(iterate)


def run(surface: Surface, method: Method, listener: Listener | None = None) -> Outcome:
    """Map a surface and watch; an error that the method raises is the outcome's status."""
    watch, began = _Watch(listener), time.process_time()
    n = len(surface.v)
    try:
        result = spherical_conformal_map(surface.v, surface.f, method, listener=watch)
    except (MapError, FactorisationFailed) as error:
        return Outcome(str(error), time.process_time() - began, sphere=np.full((n, 3), np.nan))
    return Outcome(
        result.status.name,
        time.process_time() - began,
        [asdict(entry) | {"status": entry.status.name} for entry in result.rounds],
        result.iterations,
        result.energy,
        result.certificate.foldings,
        np.array(watch.energies),
        np.array(watch.clock),
        np.array([watch.maps[k] for k in sorted(watch.maps)]).reshape(-1, n, 3),
        result.sphere,
    )


_ARRAYS = ("energies", "clock", "maps", "sphere")


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
