"""One mapped surface registered to another, certified."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...draw.markup import table
from ...draw.shown import Drawing
from ...draw.sphere_map import sphere_drawing, sphere_figures
from ...errors import check_number
from ...gate import gate
from ...maps.given_sphere import certified
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import check_mesh
from ...mesh.measure import face_areas, weighted_quantile
from ...result.run import History, Iterate, Listener, Stage
from ...untangle.local_repair import unfolded
from ..harmonics.rotation import RotationCandidate
from . import STAGES, STIFFNESS, USUAL
from .descent import Descent, LevelListener, Objective, distance_between
from .features import FeaturePair
from .levels import Level
from .result import OfMap

# tells how bodies face each other
_WIDEST = 0.7
#: Points of each level, the share of the surfaces' metrics there, and the width of the features' smoothing.
_CHAIN = (
    (642, 0.5, (_WIDEST,)),
    (2562, 0.9, (_WIDEST, 0.35)),
    (2562, 0.9, (0.35, 0.12)),
    (10242, 0.9, (0.35, 0.12, 0.05)),
)
#: The widths in use, from the widest: without data the depth potential of each is compared.
WIDTHS = tuple(dict.fromkeys(width for _, _, each in _CHAIN for width in each))


class Turn(NamedTuple):
    """A rotation of a surface's sphere, and the remaining distance of the two surfaces in space, both of unit area."""

    rotation: FloatArray
    distance: float


@dataclass(frozen=True, eq=False)
class RegistrationStage:
    """Result of one stage of a registration.

    Attributes
    ----------
    name : str
        "start", "rotation", "moebius" or "elastic".
    correlation : (k,) float64 array
        Of each feature as given, over the source's area.
    strain : float
        Mean of ``|log J|`` over the sphere, J the ratio of areas after and before; for "elastic" before means after the
        Moebius map, else the source's sphere as it came.
    strain_95 : float
        95 percent of the sphere's area lie below this.
    """

    name: str
    correlation: FloatArray
    strain: float
    strain_95: float


@dataclass(frozen=True, eq=False)
class Registration(OfMap):
    """The source's map in the frame of the target's.

    Attributes
    ----------
    map : SphereMap
        The source (if asked for, mirrored) with its registered sphere, certified folding-free. `transfer` takes data
        between it and the target's map.
    stages : tuple of RegistrationStage
        Start and every stage, in their order.
    candidates : tuple of RotationCandidate
        Rotations that were considered and their correlations, the chosen one first; empty without that stage.
    notes : tuple of str
        Reasons to doubt the result.
    """

    map: SphereMap
    stages: tuple[RegistrationStage, ...]
    candidates: tuple[RotationCandidate, ...]
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        reached = ", ".join(f"{stage.name} {stage.correlation.mean():.3f}" for stage in self.stages)
        return f"Registration({len(self.map.sphere)} vertices; correlation at {reached})"

    def _drawing(self) -> Drawing:
        return sphere_drawing(self.map)

    def _figures(self) -> str:
        stages = [
            (stage.name, f"{stage.correlation.mean():.3f}", f"{stage.strain:.3f}")
            for stage in self.stages
        ]
        return table(stages, ("stage", "correlation", "strain")) + sphere_figures(self.map)

    @property
    def rotation(self) -> FloatArray:
        """The chosen rotation R; x went to R x."""
        if not self.candidates:
            return np.eye(3)
        return self.candidates[0].rotation

    @property
    def margin(self) -> float:
        """Correlation of the chosen rotation less that of the next one; NaN if there is none."""
        if len(self.candidates) < 2:
            return np.nan
        return self.candidates[0].correlation - self.candidates[1].correlation


@gate
def register(
    source: SphereMap,
    target: SphereMap,
    *,
    features: tuple[ArrayLike, ArrayLike] | None = None,
    stages: Sequence[str] = USUAL,
    stiffness: float = STIFFNESS,
    reflect: bool = False,
    listener: Listener | None = None,
) -> Registration:
    """Lay one mapped surface on another so that their features agree.

    Parameters
    ----------
    source, target : SphereMap
        Two surfaces with their maps. For shapes with limbs take area-preserving maps, for cortices ``balance=0.85``.
    features : (the source's values, the target's values), optional
        Data over the vertices of each, (n,) or (n, k) with the same k. By default the depth potential of each surface,
        see `depth_potential`. Data are smoothed on the surfaces, by .7 radians at first and by .05 in the end, and
        compared at unit variance.
    stages : sequence of str
        One or more of three, by default the first and the last. "rotation" takes the rotation with the highest
        correlation; if "elastic" follows, it takes, among those with nearly the highest, that of least energy from
        surface to surface. "moebius" takes Gauss-Newton steps over Moebius maps. "elastic" takes Newton steps on the
        strain from one surface to the other, the strain of the source's sphere and the features' difference, on up to
        10,242 points of the sphere, which carry the vertices.
    stiffness : float, default 0.5
        Weight of the strains beside the mean squared difference of features of unit variance. Lower values raise the
        correlation and not the precision: features differ between bodies, too.
    reflect : bool, default False
        As for `match`.
    listener : callable, optional
        Called with an `Iterate` after the rotation and after every step; may raise StopIteration to stop with the
        current map.

    Returns
    -------
    Registration
        The source's map in the target's frame, certified, and its agreement.

    Raises
    ------
    MeshError
        If features are missing, not finite or constant, or a surface is a round sphere, which has no features.
    FoldingsRemain
        If a map is not certified folding-free.
    ValueError
        If there is no such stage, or `stiffness` is below 1e-6.
    TypeError
        If `stiffness` is not a number, or the listener can't be called.

    Examples
    --------
    >>> import numpy as np
    >>> import igl_spheremap as ism
    >>> pear = ism.spherical_conformal_map(*ism.samples.make("pear", n_vertices=1000))
    >>> quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    >>> turned = ism.sphere_map(pear.vertices, pear.faces, pear.sphere @ quarter)
    >>> result = ism.shapes.register(turned, pear, features=(pear.sphere[:, :2], pear.sphere[:, :2]))
    >>> bool(np.abs(result.map.sphere - pear.sphere).max() < 0.01), result.map.certificate.folding_free
    (True, True)
    """
    history = History(listener)
    check_number(stiffness, "stiffness", 1e-6)  # strains keep faces from degenerating
    unknown = [stage for stage in stages if stage not in STAGES]
    if unknown:
        raise ValueError(f"unknown stage {unknown[0]!r}: choose from {', '.join(STAGES)}")
    if reflect:
        source = reflected(source)
    descent = RegistrationDescent(source, target, features, stiffness)
    first = WIDTHS[-1]  # data are compared nearly as they are
    if features is None:
        first = _WIDEST
    unsure = 0.9  # a runner-up with this share of the best correlation is tried, and reported
    progress = _Progress(history, {"start": source.sphere})
    candidates: tuple[RotationCandidate, ...] = ()

    def step(_: Objective, level: Level, y: FloatArray, energy: float) -> None:
        x = progress.last  # without a listener the history keeps numbers only
        if listener is not None:
            x = level.carried(y, descent.source)
        progress.take(x, energy)

    with suppress(StopIteration):  # of a listener
        if "rotation" in stages:
            least = 1.0
            if "elastic" in stages:
                least = unsure
            turned, candidates = descent.start(first, least=least)
            progress.begin("rotation")
            progress.take(turned, 1 - candidates[0].correlation)
        if "moebius" in stages:
            descent.pair.fit_moebius(progress.begin("moebius"), first, progress.take)
        if "elastic" in stages:
            progress.ends["elastic"] = descent.registered(progress.begin("elastic"), step)
    result, before, ends = certified(source.mesh, progress.last), source.sphere, []
    for stage, x in progress.ends.items():
        if stage != "elastic":
            before = source.sphere
        ends.append(_report(stage, descent.pair, source.faces, before, x))
        before = x
    run = history.complete(result.run, "register")
    return Registration(
        replace(result, run=run), tuple(ends), candidates, _doubts(candidates, ends, unsure)
    )


@dataclass(eq=False)
class _Progress:
    """Stages, each from the end of the one before: the map at the end of each, and a history of all iterates."""

    history: History
    ends: dict[str, FloatArray]
    number: int = 0

    @property
    def last(self) -> FloatArray:
        """The last map."""
        *_, x = self.ends.values()
        return x

    def begin(self, stage: str) -> FloatArray:
        """Begin a stage, and return the map there."""
        self.ends[stage], self.number = self.last, 0
        return self.last

    def take(self, x: FloatArray, cost: float) -> None:
        """Take the next iterate of the stage."""
        *_, stage = self.ends
        self.ends[stage], self.number = x, self.number + 1
        self.history(Iterate(Stage(stage), 0, self.number, x, cost))


class RegistrationDescent(Descent):
    """Registers a surface to another by features, or else by depth potentials, from chosen starts.

    Maps are those of the source's vertices to the target's sphere.
    """

    def __init__(
        self,
        source: SphereMap,
        target: SphereMap,
        features: tuple[ArrayLike, ArrayLike] | None = None,
        stiffness: float = STIFFNESS,
    ) -> None:
        pair = FeaturePair(
            Level.of(source, "the source"), Level.of(target, "the target"), features, WIDTHS
        )
        columns, plan = pair.source(WIDTHS[:1]).shape[1], []
        for points, share, widths in _CHAIN:
            weight = 1 / (stiffness * columns * len(widths))
            size = min(points, len(source.sphere))
            plan.append(Objective(size, share, widths, weight, guard=0.2, steps=15))
        a, b = pair.smoothed()
        super().__init__(a, b, plan, pair, np.empty((0, 3)))
        self._last = plan[-1]._replace(size=None)

    def turns(self, most: int = 12) -> list[Turn]:
        """Rotations of best local agreement of the features, in the order of the surfaces' distance in space.

        That is measured on the coarsest level. An octopus, whose arms their places alone tell apart, has eight.
        """
        source, target = self.coarsest()
        found = []
        for each in self.pair.rotations(_WIDEST, most):
            y = self.source.carried(self.turned(each.rotation), source)
            found.append(Turn(each.rotation, distance_between(source, target, y)))
        return sorted(found, key=lambda turn: turn.distance)

    def registered(self, y: FloatArray, listener: LevelListener = lambda *_: None) -> FloatArray:
        """The registration from a start, through all levels."""
        level, y = self.run(y, listener)
        return level.carried(y, self.source)

    def continued(self, y: FloatArray) -> FloatArray:
        """Register again, from `y`, after the target moved a little: only the last level's steps are taken."""
        return self.lowered(
            self.source, self.target, unfolded(self.source.map.mesh, y), [self._last]
        )[1]

    def distance(self, y: FloatArray) -> float:
        """Root mean square distance of corresponding points after a similarity, of surfaces of unit area."""
        return distance_between(self.source, self.target, y)

    def correlation(self, y: FloatArray) -> float:
        """Correlation of the features over the source's area."""
        return float(self.pair.correlation(y).mean())


def reflected(result: SphereMap) -> SphereMap:
    """Mirror a surface and its map, x to -x, and reverse its faces: angles and areas stay."""
    mirror = np.array([-1.0, 1.0, 1.0])
    mesh = check_mesh(result.vertices * mirror, result.faces[:, ::-1], caps=result.mesh.caps)
    image = replace(certified(mesh, result.sphere * mirror), run=result.run)
    conformal = result.conformal
    if conformal is not None:
        conformal = replace(certified(mesh, conformal.sphere * mirror), run=conformal.run)
    return replace(image, conformal=conformal)


def _report(
    name: str, pair: FeaturePair, f: IntArray, before: FloatArray, x: FloatArray
) -> RegistrationStage:
    areas = face_areas(before, f)
    J = np.abs(np.log(face_areas(x, f) / areas))
    mean = float(areas @ J / areas.sum())
    return RegistrationStage(name, pair.correlation(x), mean, weighted_quantile(J, areas, 0.95))


def _doubts(
    candidates: tuple[RotationCandidate, ...],
    stages: list[RegistrationStage],
    unsure: float,
    loss: float = 0.01,
) -> tuple[str, ...]:
    """Reasons to doubt a registration: a runner-up with the share `unsure` of the best correlation, or losses.

    Smoothing lowers the correlation by less than `loss`.
    """
    notes = []
    if len(candidates) > 1 and candidates[1].correlation > unsure * candidates[0].correlation:
        notes.append(
            f"the margin is small: the rotation that was taken correlates {candidates[0].correlation:.3f}, "
            f"another one {candidates[1].correlation:.3f}"
        )
    for before, after in pairwise(stages):
        lost = float(before.correlation.mean() - after.correlation.mean())
        if lost > loss:
            notes.append(
                f"the stage {after.name} lowered the correlation by {lost:.3f}: parts of the surface are too "
                "small on these maps; register area-preserving ones"
            )
    return tuple(notes)
