"""The record of a run, and the iterates that listeners get."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Any, NamedTuple

import numpy as np

from ..errors import OfListener
from ..mesh.arrays import FloatArray
from ..timings import timings


class Status(Enum):
    """How a run ended; the value is a sentence.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> ism.Status.CONVERGED.value
    'the stopping rule was met'
    """

    CONVERGED = "the stopping rule was met"
    PLATEAU = "the energy hardly fell any more, before the stopping rule was met"
    MAX_ITERATIONS = "the iteration limit was reached first"
    DONE = "no stopping rule was needed"
    SHORT = "areas or lengths stopped short of what was asked"
    COLLAPSED = "the degree is 0: the map shrank to a point or a curve, or as much of it is inside out as is not"
    STALLED = (
        "no acceptable step was found: the energy is at its rounding, or every step would fold"
    )
    STOPPED = "a listener asked to stop"


class Stage(str, Enum):
    """The step of a run that made an iterate. A stage equals its text: ``iterate.stage == "star map"``.

    Attributes
    ----------
    label : str
        Its name for people.
    has_own_energy : bool
        True if it minimises another energy than the harmonic one.

    Examples
    --------
    >>> from igl_spheremap.result.run import Stage
    >>> Stage("harmonic").label, Stage.BALANCE.has_own_energy
    ('Algorithm 1', True)
    """

    label: str
    has_own_energy: bool

    def __new__(cls, text: str, label: str = "", has_own_energy: bool = False) -> Stage:
        stage = str.__new__(cls, text)
        stage._value_ = text
        stage.label = label
        if not label:
            stage.label = text[0].upper() + text[1:]
        stage.has_own_energy = has_own_energy
        return stage

    # starts
    GAUSS_MAP = "gauss map"
    GIVEN_MAP = "given map"
    STAR_MAP = "star map"
    # solvers
    ALGORITHM_1 = "harmonic", "Algorithm 1"
    PRECONDITIONED = "sobolev", "Preconditioned Cayley steps"
    TUTTE = "tutte", "Tutte energy"
    STEREOGRAPHIC = "stereographic"
    # the repair; and of that of a given map, start and end
    REPAIR = "repair"
    MAP = "map"
    REPAIRED = "repaired"
    # wings
    OPENING = "opening", "", True
    BALANCE = "balance", "", True
    UNROLLED = "unrolled"
    MATCH = "match"
    ROTATION = "rotation"
    MOEBIUS = "moebius"
    ELASTIC = "elastic"
    RESULT = "result"

    def __str__(self) -> str:
        return self.value

    def __repr__(self) -> str:
        return repr(self.value)


@dataclass(frozen=True, eq=False)
class Iterate:
    """A map on the way of a run, as listeners get it.

    Attributes
    ----------
    stage : Stage
        The step of the run that made it: "gauss map", "harmonic", "star map", "repair", ...
    round : int
        Number of its entry in `Run.rounds`, 0 without one: a round of Algorithm 2, or a map that the repair has tried.
    iteration : int
        Count within the stage; 0 for its start.
    x : (n, 3) float64 array
        The map, unit rows. Read-only.
    energy : float
        Harmonic energy, or the objective that is minimised.
    residual : float
        The figure that ends the stage below the tolerance, in its units; NaN if there is none.
    tau : float
        Step size that led here; 0 for a start.
    details : dict
        Further results of a stage, such as the eigenfunctions of a star map. Arrays are read-only.
    safeguards : dict
        How often each of `SAFEGUARDS` acted since the last iterate; None if none did.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> iterates: list[ism.Iterate] = []
    >>> result = ism.spherical_conformal_map(*ism.samples.sphere(162), listener=iterates.append)
    >>> iterates[0].x.shape, iterates[0].iteration
    ((162, 3), 0)
    """

    stage: Stage
    round: int
    iteration: int
    x: FloatArray
    energy: float
    residual: float = float("nan")
    tau: float = 0.0
    details: dict[str, Any] | None = None
    safeguards: dict[str, int] | None = None

    def __post_init__(self) -> None:
        """Make the arrays read-only views: a listener must not change the run that it watches."""
        object.__setattr__(self, "x", _read_only(self.x))
        if self.details is not None:
            object.__setattr__(
                self, "details", {key: _read_only(value) for key, value in self.details.items()}
            )

    def __repr__(self) -> str:
        return f"Iterate({title_of(self)!r}, {len(self.x)} vertices, energy={self.energy:.6f})"

    @property
    def step(self) -> Step:
        """The iterate without its positions."""
        return Step(
            self.stage,
            self.round,
            self.iteration,
            self.energy,
            self.residual,
            self.tau,
            self.safeguards,
        )


def _read_only(value: Any) -> Any:
    """A view of an array that can't be written to; anything else as it is."""
    if isinstance(value, np.ndarray):
        value = value.view()
        value.flags.writeable = False
    return value


#: Anything that takes an iterate. It may raise StopIteration to end the run with the present map.
Listener = Callable[[Iterate], None]


class Step(NamedTuple):
    """One line of the history: an iterate without its positions, since those of a run would not fit in memory.

    Attributes
    ----------
    stage, round, iteration, energy, residual, tau, safeguards
        As of `Iterate`.
    """

    stage: Stage
    round: int
    iteration: int
    energy: float
    residual: float
    tau: float
    safeguards: dict[str, int] | None = None


#: Safeguards by name, each with its note for one action and for several.
SAFEGUARDS = {
    "undirected": (
        "vertex took the direction of its neighbours",
        "vertices took the direction of their neighbours",
    ),
    "floored": (
        "weight of eq. (20) was raised to its floor",
        "weights of eq. (20) were raised to their floor",
    ),
    "undefined": ("quotient of eq. (12) had no value", "quotients of eq. (12) had no value"),
    "bounded": (
        "quotient of eq. (12) was out of bounds",
        "quotients of eq. (12) were out of bounds",
    ),
    "refused": ("step that would fold was refused", "steps that would fold were refused"),
    "centred": (
        "map on the way was centred by a Moebius map",
        "maps on the way were centred by Moebius maps",
    ),
    "restarted": (
        "round began at unweighted eigenfunctions, as the map had shrunk",
        "rounds began at unweighted eigenfunctions, as the map had shrunk",
    ),
}


def safeguard_notes(steps: Iterable[Step]) -> tuple[str, ...]:
    """Notes on the safeguards that acted in some steps, in the order of `SAFEGUARDS`.

    >>> safeguard_notes([Step(Stage.ALGORITHM_1, 0, k, 12.6, 0.1, 0.5, {"refused": 3 - k}) for k in range(3)])
    ('6 steps that would fold were refused',)
    """
    total: Counter[str] = Counter()
    for step in steps:
        if step.safeguards is not None:
            total.update(step.safeguards)
    notes = []
    for name, (once, more) in SAFEGUARDS.items():
        if total[name] == 1:
            notes.append(f"1 {once}")
        elif total[name]:
            notes.append(f"{total[name]:,} {more}")
    return tuple(notes)


def title_of(step: Step | Iterate) -> str:
    """An iterate in words.

    >>> title_of(Step(Stage.ALGORITHM_1, 1, 20, 12.6, 0.1, 0.5))
    'Algorithm 1, round 1, iteration 20'
    """
    title = step.stage.label
    if step.stage is Stage.REPAIR and step.round == 0:
        return "Harmonic map"
    if step.stage in (Stage.STAR_MAP, Stage.REPAIR):
        return f"{title} {step.round}"
    if step.round:
        title += f", round {step.round}"
    return f"{title}, iteration {step.iteration}"


def iterations_in(number: int) -> str:
    """A number of iterations in words."""
    if number == 1:
        return "1 iteration"
    return f"{number:,} iterations"


@dataclass(frozen=True)
class Round:
    """One iteration of Algorithm 2, or one step of the repair.

    Attributes
    ----------
    round : int
        Its number, from 0.
    start : str
        The start of the round: "gauss map", "star map", ...
    foldings_before, foldings_after : int
        Folded faces of the start and of its result.
    iterations : int
        Iterations between the two.
    energy : float
        Harmonic energy of the map.
    mean_angle_difference : float
        Mean over all corners of the size of the angle difference, in degrees; NaN if nothing depended on it, as in a
        repair without steps.
    status : Status
        How the minimisation ended.
    seconds : float
        Wall time.
    """

    round: int
    start: str
    foldings_before: int
    foldings_after: int
    iterations: int
    energy: float
    mean_angle_difference: float
    status: Status
    seconds: float

    def __str__(self) -> str:
        """A line for people."""
        folded = f"{self.foldings_after:,} folded faces"
        if self.iterations:
            taken = iterations_in(self.iterations)
            folded = f"{self.foldings_before:,} folded faces, after {taken} {self.foldings_after:,}"
        if np.isfinite(self.mean_angle_difference):
            folded += f", {self.mean_angle_difference:.3g} degrees off"
        if self.status is Status.COLLAPSED:
            folded += f"; {self.status.value}"
        return f"{self.start}: {folded}"


@dataclass(frozen=True, eq=False)
class Run:
    """How a map came about: request, events and end.

    Attributes
    ----------
    status : Status
        How the last minimisation ended.
    energy : float
        Harmonic energy of the map, eq. (6); 4 pi for a smooth conformal map.
    method : str
        The method's name.
    settings : dict
        The method's options that are not at their defaults.
    history : tuple of Step
        Every iterate of every stage.
    rounds : tuple of Round
        Foldings before and after each round of folding removal.
    seconds : float
        Wall seconds from arrays to result.
    timings : dict
        Wall seconds by phase ("check", "Laplacian", "factorisation", "solves", "start", "steps", "gauge",
        "certificate", "repair", ...), each without the phases inside it. Files don't keep them.
    backend : str
        The factorisation that was used; empty if none was.
    notes : tuple of str
        Remarks on the run, such as other edge weights in place of unusable ones.
    gauge : str
        "centred": Moebius-centred on the source's area (or on weights given to `SphereMapper.map`) and turned to the
        Gauss map. If that would fold huge faces, the map is not quite centred, and a note says so. "turned", of
        balanced maps: turned to the Gauss map only. "poles", of bodies with limbs beyond float64: the tips of the
        deepest, three at most, at ends of the axes. "given", of `sphere_map` and `repair_foldings`: as given. "free",
        of landmark maps, of p-harmonic maps with p above 2, and of `Lai2014` if asked: as the minimisation left it.
    stretch : float
        Limbs too deep for float64 are mapped as if up to this many times shorter, so that angles are off there; 1 if
        there is none.
    plan : str
        The maps that a repair was to try, and why; empty if none was asked for. Files don't keep it.
    """

    status: Status
    energy: float
    method: str = ""
    settings: dict[str, Any] = field(default_factory=dict)
    history: tuple[Step, ...] = ()
    rounds: tuple[Round, ...] = ()
    seconds: float = 0.0
    timings: dict[str, float] = field(default_factory=dict, compare=False)
    backend: str = ""
    notes: tuple[str, ...] = ()
    gauge: str = "centred"
    stretch: float = 1.0
    plan: str = field(default="", compare=False)

    @property
    def iterations(self) -> int:
        """Iterations of all stages together."""
        return sum(step.iteration > 0 for step in self.history)

    @property
    def balance(self) -> float:
        """0 for a conformal map, 1 for an area-preserving one, see `igl_spheremap.balanced_spherical_map`."""
        return float(self.settings.get("balance", 0.0))

    def __repr__(self) -> str:
        return f"Run({self.method!r}, {self.status.name}, {iterations_in(self.iterations)}, {self.seconds:.2f} s)"


class History:
    """Listener that keeps the numbers of every iterate, and passes the iterate on to the next listener.

    It is the growing `Run`: a public call makes it at its beginning, and completes it by `complete` at its end. If the
    call continues an earlier run, the history and the times of that run come first.
    """

    def __init__(self, listener: Listener | None = None, before: Run | None = None) -> None:
        self.steps: list[Step] = []
        self._listener, self._before = listener, before
        self._began = time.perf_counter()

    def __call__(self, iterate: Iterate) -> None:
        self.steps.append(iterate.step)
        if self._listener is not None:
            try:
                self._listener(iterate)
            except StopIteration:
                raise
            except Exception as error:
                raise OfListener(error) from None

    def complete(self, run: Run, method: str, settings: dict[str, Any] | None = None) -> Run:
        """The record of a run with its method, history, safeguards' actions and time."""
        if settings is None:
            settings = {}
        seconds, history, spent = time.perf_counter() - self._began, tuple(self.steps), timings()
        if (before := self._before) is not None:
            seconds, history = before.seconds + seconds, before.history + history
            spent = before.timings | {
                name: before.timings.get(name, 0.0) + spent[name] for name in spent
            }
        return replace(
            run,
            method=method,
            settings=settings,
            history=history,
            seconds=seconds,
            timings=spent,
            notes=(*run.notes, *safeguard_notes(self.steps)),
        )
