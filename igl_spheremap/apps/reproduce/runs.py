"""Runs of methods on surfaces, kept in files."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from ..._version import __version__
from ...io.npz import arrays_of, map_of, read_arrays, write_arrays
from ...io.replacing import replacing
from ...maps.options import Auto, GuYau, Lai2014, Method
from ...maps.sphere_map import SphereMap
from ...maps.spherical_conformal_map import spherical_conformal_map
from ...mesh.arrays import FloatArray
from ...result.run import Iterate, Stage
from .surfaces import PaperSurface, load_surface

#: Runs by their names in tables.
METHODS: dict[str, Method] = {
    "Algorithm 1": Lai2014(rounds=0),
    "Algorithm 1 as printed": Lai2014.as_printed(rounds=0),
    "Algorithm 1 as programmed": Lai2014.as_programmed(rounds=0),
    "Algorithm 2": Lai2014(),
    "Algorithm 2 as printed": Lai2014.as_printed(),
    "Algorithm 2 as printed, 1,000 iterations": Lai2014.as_printed(max_iterations=1000),
    "Algorithm 2 as programmed": Lai2014.as_programmed(),
    "Gu-Yau": GuYau(tutte=False),
    "auto": Auto(),
}

#: Data of a run to keep beside its result.
_MORE = ("seconds", "starts", "ends")


@dataclass(frozen=True, eq=False)
class PaperRun:
    """A map that a method made, the CPU seconds that it took, and the maps (r, n, 3) that rounds start and end with."""

    result: SphereMap
    seconds: float
    starts: FloatArray
    ends: FloatArray


class Runs:
    """All runs, made at first use and kept in a folder: a file for each mesh, method, cap of iterations and version.

    `meshes` is a folder of counterparts of the paper's surfaces. `report` takes a line on each run.
    """

    def __init__(
        self,
        folder: Path,
        meshes: Path | None = None,
        max_iterations: int | None = None,
        report: Callable[[str], None] = lambda line: None,
    ) -> None:
        self._folder, self._meshes, self._cap, self._report = folder, meshes, max_iterations, report
        self._surfaces: dict[str, PaperSurface] = {}

    def surface(self, name: str) -> PaperSurface:
        """The surface that stands for one of the paper's."""
        if name not in self._surfaces:
            self._surfaces[name] = load_surface(name, self._meshes)
        return self._surfaces[name]

    def get(self, surface: PaperSurface, name: str) -> PaperRun:
        """The run of one of `METHODS`."""
        method = METHODS[name]
        # those that take thousands of iterations
        if self._cap is not None and isinstance(method, Lai2014 | GuYau):
            method = replace(method, max_iterations=self._cap)
        key = json.dumps([surface.digest, method.name, asdict(method), __version__], sort_keys=True)
        path = self._folder / f"{hashlib.sha256(key.encode()).hexdigest()[:20]}.npz"
        if path.is_file():
            kept = read_arrays(path)
            return PaperRun(map_of(kept), float(kept["seconds"]), kept["starts"], kept["ends"])
        self._report(f"{name} on {surface.title} ...")
        made = run(surface, method)
        with replacing(path, force=True) as partial:
            write_arrays(
                partial, arrays_of(made.result) | {name: getattr(made, name) for name in _MORE}
            )
        self._report(
            f"    {made.result.iterations:,} iterations, {made.seconds:.1f} s, "
            f"{made.result.certificate.foldings:,} foldings"
        )
        return made


def run(surface: PaperSurface, method: Method) -> PaperRun:
    """Map a surface, and keep the first and last map of each round."""
    starts: dict[int, FloatArray] = {}
    ends: dict[int, FloatArray] = {}

    def listen(iterate: Iterate) -> None:
        if iterate.stage in (Stage.GAUSS_MAP, Stage.STAR_MAP):
            starts[iterate.round] = iterate.x
        else:
            ends[iterate.round] = iterate.x

    began = time.process_time()
    result = spherical_conformal_map(surface.v, surface.f, method=method, listener=listen)
    seconds = time.process_time() - began
    return PaperRun(result, seconds, *(np.array(list(found.values())) for found in (starts, ends)))
