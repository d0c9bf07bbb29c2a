"""The base of all results: certificate, record of the run, and the way to another balance."""

from __future__ import annotations

from operator import attrgetter
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..errors import check_number
from ..gate import gate
from ..mesh.arrays import FloatArray, IntArray
from ..mesh.check import Mesh
from ..mesh.disk import Disk
from ..timings import timed
from ..verify.certificate import Certificate
from .findings import Finding, as_factor
from .run import Listener, Round, Run, Status, Step, iterations_in

R = TypeVar("R", bound="Result")


def _of_run(name: str, doc: str) -> Any:
    """A property of results that reads the attribute of this name from the run."""
    return property(attrgetter(f"run.{name}"), doc=doc)


class Result:
    """A map with its certificate and the record of its run.

    Attributes
    ----------
    certificate : Certificate
        Of the map's positions, in exact arithmetic.
    run : Run
        How the map came about. The result has its attributes, too: ``result.energy`` is ``result.run.energy``.
    """

    if TYPE_CHECKING:  # fields of the records, or properties

        @property
        def certificate(self) -> Certificate: ...
        @property
        def run(self) -> Run: ...
        @property
        def mesh(self) -> Mesh | Disk: ...
        @property
        def _images(self) -> FloatArray: ...

    @property
    def vertices(self) -> FloatArray:
        """The source as it was given, (n, 3) float64."""
        return self.mesh.v

    @property
    def faces(self) -> IntArray:
        """The input's faces, (m, 3) int64; outward on the sphere, counterclockwise in the plane."""
        return self.mesh.f

    energy: float = _of_run(
        "energy", "Harmonic energy, eq. (6), about 4 pi; in the plane what was lowered."
    )
    status: Status = _of_run("status", "How the last minimisation ended.")
    iterations: int = _of_run("iterations", "Iterations of all stages together.")
    seconds: float = _of_run("seconds", "Wall seconds from arrays to result.")
    timings: dict[str, float] = _of_run("timings", "Wall seconds by phase.")
    method: str = _of_run("method", "The method's name.")
    settings: dict[str, Any] = _of_run(
        "settings", "The method's options that are not at their defaults."
    )
    history: tuple[Step, ...] = _of_run("history", "Every iterate of every stage.")
    rounds: tuple[Round, ...] = _of_run(
        "rounds", "Foldings before and after each round of folding removal."
    )
    backend: str = _of_run("backend", "The factorisation that was used; empty where none was.")
    notes: tuple[str, ...] = _of_run(
        "notes", "Remarks on the run, and reasons to doubt the result."
    )
    gauge: str = _of_run("gauge", "Where the map lies among its Moebius images: see `Run`.")
    stretch: float = _of_run(
        "stretch", "Factor by which limbs too deep for float64 are shortened; 1 if there is none."
    )
    balance: float = _of_run("balance", "0 for a conformal map, 1 for an area-preserving one.")

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        """The images of the vertices, for numpy."""
        if copy is None:  # copy if needed: before numpy 2 np.array cannot say so
            return np.asarray(self._images, dtype=dtype)
        return np.array(self._images, dtype=dtype, copy=copy)

    def explain(self) -> str:
        """Say which decisions led to the map, and why.

        Returns
        -------
        str
            The method, and the plan of the repair if there was one; a line for each map on the way, with its folded
            faces and its mean angle difference in degrees; of another balance its steps, costs and gains; and the
            notes.

        Examples
        --------
        >>> import igl_spheremap as ism
        >>> result = ism.spherical_conformal_map(*ism.samples.make("pear", n_vertices=500))
        >>> print(result.rebalance(1).explain())
        auto: no face folds, and steps on angles are predicted to gain less than 3 percent; so the map stays as it is
        auto, balance 1: 4 iterations; angles are 4.81 degrees off in the mean, not 0.895, and areas by a factor of
        1.01, not 1.24; the stopping rule was met
        """
        before: Any = self._conformal_one()
        if before is self:
            decided = self.run.plan
            if not decided:
                decided = self.status.value
            return "\n".join((f"{self.method}: {decided}", *map(str, self.rounds), *self.notes))
        own, notes = (
            self.iterations - before.iterations,
            [note for note in self.notes if note not in before.notes],
        )
        angles = [f"{_angles_off(each):.3g}" for each in (self, before)]
        areas = [as_factor(_areas_off(each)) for each in (self, before)]
        line = (
            f"{self.method}, balance {self.balance:g}: {iterations_in(own)}; angles are {angles[0]} degrees off in "
            f"the mean, not {angles[1]}, and areas by a factor of {areas[0]}, not {areas[1]}; {self.status.value}"
        )
        return "\n".join((before.explain(), line, *notes))

    @gate
    @timed()
    def rebalance(self: R, balance: float, *, listener: Listener | None = None) -> R:
        """Take the map to another balance of the same surface, as a slider does.

        Parameters
        ----------
        balance : float
            0 is conformal, 1 preserves areas, as of the function that made the map. Closer balances of two maps to the
            sphere or the disk take fewer steps.
        listener : callable, optional
            Called with every `Iterate`; may raise StopIteration to stop with the current map.

        Returns
        -------
        SphereMap, DiskMap or FlatMap
            Of the same kind. At 0, maps to the sphere and to the disk return their conformal map.

        Raises
        ------
        ValueError
            If `balance` is not in [0, 1].
        TypeError
            If it is not a number, or the result is not the map of one surface that has a balance: maps between
            surfaces, and maps to the plane from files.
        FoldingsRemain
            If the map has foldings; `igl_spheremap.repair_foldings` removes them from maps to the sphere.

        Examples
        --------
        >>> import igl_spheremap as ism
        >>> result = ism.balanced_spherical_map(*ism.samples.make("spheroid", n_vertices=1000), balance=0.5)
        >>> result.rebalance(0.6).certificate.folding_free
        True
        """
        return self._rebalanced(check_number(balance, "balance", most=1), listener)

    def _conformal_one(self: R) -> R:
        """The conformal map that a balanced one started from, or else the map itself."""
        started_from: R | None = getattr(self, "conformal", None)
        if started_from is None:
            return self
        return started_from

    def _rebalanced(self: R, balance: float, listener: Listener | None) -> R:
        """The map at another balance, which is in range."""
        raise TypeError(
            f"a {type(self).__name__} can't be rebalanced; make another one, from maps of balance "
            f"{balance:g} or by a function that takes balance={balance:g}"
        )

    def _size(self) -> str:
        """The source's size in words."""
        return f"{len(self.vertices):,} vertices, {len(self.faces):,} faces"

    def __repr__(self) -> str:
        outcome = f"{self.certificate.foldings} foldings"
        if self.certificate.folding_free:
            outcome = "folding-free"
        if self.balance:
            outcome = f"balance={self.balance:g}, {outcome}"
        return (
            f"{type(self).__name__}({self._size()}, method={self.method!r}, {outcome}, "
            f"energy={self.energy:.6f}, {self.status.name}, {iterations_in(self.iterations)}, "
            f"{self.seconds:.2f} s)"
        )


def _angles_off(result: Any) -> float:
    return float(np.abs(result.angle_differences()).mean())


def _areas_off(result: Any) -> float:
    return float(np.abs(result.log_area_ratios()).mean())


def run_findings(result: Result) -> list[Finding]:
    """How a map was made: the method's line, and the notes."""
    options = ", ".join(f"{key} = {value}" for key, value in result.settings.items())
    made = result.method
    if options:
        made += f" ({options})"
    if result.backend:
        made += f", {result.backend}"
    text = (
        f"{made}: {iterations_in(result.iterations)}, {result.seconds:.2f} s; {result.status.value}"
    )
    run = {
        "method": result.method, "settings": result.settings, "backend": result.backend, "timings": result.timings,
        "iterations": result.iterations, "seconds": result.seconds, "status": result.status.name,
        "rounds": [entry.__dict__ | {"status": entry.status.name} for entry in result.rounds],
    }  # fmt: skip
    notes = [Finding("note", note, {}) for note in result.notes]
    return [Finding("method", text, run), *notes]


def result_rows(result: Result, known: list[Finding]) -> list[tuple[str, str]]:
    """Labels and texts of a map's findings, its size and its run, the verdict first."""
    *figures, certificate = known
    size = Finding("mesh", result._size(), {})
    return [
        (found.label, found.text) for found in (certificate, size, *figures, *run_findings(result))
    ]
