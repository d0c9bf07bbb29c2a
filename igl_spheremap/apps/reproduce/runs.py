"""Runs of methods on surfaces, kept in files, from which an interrupted command continues."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ..._version import __version__
from ...descent.iterate import Iterate, Listener
from ...errors import FactorisationFailed, FileError, MapError
from ...io.replacing import replacing
from ...maps.options import Auto, GuYau, Lai2014, Method, Stereographic
from ...maps.spherical_conformal_map import spherical_conformal_map
from ...mesh.arrays import FloatArray, IntArray
from .surfaces import Surface, load_surface

#: What is run, by the name that tables give it.
METHODS: dict[str, Method] = {
    "Algorithm 1": Lai2014(rounds=0),
    "Algorithm 2": Lai2014(),
    "Delaunay weights": Lai2014(weights="delaunay"),
    "Gu-Yau": GuYau(tutte=False),
    "Gu-Yau after Tutte": GuYau(),
    "stereographic": Stereographic(),
    "conformal equivalence": Stereographic(plane="conformal-equivalence"),
    "fast": Auto(),
}

#: Stages of iterates that only start a minimisation, whose own first iterate follows.
_STARTS = ("gauss map", "star map")


@dataclass(frozen=True, eq=False)
class Outcome:
    """The outcome of a run.

    `rounds` holds the fields of each `Round`, its status by name; `seconds` is CPU time; `foldings` is -1 where
    there is no map, and `status` then the error's message. `energies` and `clock`, CPU seconds, are (k,) over all
    iterates of minimisations, which belong to the rounds `of_round`. `maps` (r, n, 3) are the rounds' last iterates.
    """

    rounds: list[dict[str, Any]]
    iterations: int
    seconds: float
    energy: float
    foldings: int
    status: str
    energies: FloatArray
    clock: FloatArray
    of_round: IntArray
    maps: FloatArray
    sphere: FloatArray


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
        self.of_round: list[int] = []
        self.maps: dict[int, FloatArray] = {}
        self._began = time.process_time()

    def __call__(self, iterate: Iterate) -> None:
        if iterate.stage not in _STARTS:
            self.energies.append(iterate.energy)
            self.clock.append(time.process_time() - self._began)
            self.of_round.append(iterate.round)
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
        nothing = np.empty(0)
        return Outcome(
            [],
            0,
            time.process_time() - began,
            np.nan,
            -1,
            str(error),
            nothing,
            nothing,
            nothing.astype(np.int64),
            np.empty((0, n, 3)),
            np.full((n, 3), np.nan),
        )
    rounds = [asdict(entry) | {"status": entry.status.name} for entry in result.rounds]
    maps = np.array([watch.maps[k] for k in sorted(watch.maps)]).reshape(-1, n, 3)
    return Outcome(
        rounds,
        result.iterations,
        time.process_time() - began,
        result.energy,
        result.certificate.foldings,
        result.status.name,
        np.array(watch.energies),
        np.array(watch.clock),
        np.array(watch.of_round, dtype=np.int64),
        maps,
        result.sphere,
    )


_ARRAYS = ("energies", "clock", "of_round", "maps", "sphere")


def _save(path: Path, outcome: Outcome) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(f"can't write {path.parent}: {error.strerror or error}") from error
    facts = {key: value for key, value in outcome.__dict__.items() if key not in _ARRAYS}
    with replacing(path, force=True) as partial, partial.open("wb") as stream:
        np.savez(stream, facts=np.array(json.dumps(facts)), **{key: getattr(outcome, key) for key in _ARRAYS})


def _load(path: Path) -> Outcome:
    with np.load(path) as stored:
        return Outcome(**json.loads(str(stored["facts"])), **{key: stored[key] for key in _ARRAYS})
