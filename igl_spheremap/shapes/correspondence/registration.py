"""One mapped surface laid on another, certified."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ...draw.markup import table
from ...draw.shown import Drawing
from ...errors import check_number, own_errstate
from ...maps.given_sphere import certified
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import check_mesh
from ...mesh.measure import face_areas, weighted_quantile
from ...result.run import History, Iterate, Listener
from ...untangle.local_repair import unfolded
from ..harmonics.rotation import RotationCandidate
from . import STAGES, STIFFNESS, USUAL
from .descent import Descent, Objective, distance_between
from .features import FeaturePair
from .fits import fit_moebius
from .levels import Level
from .result import OfMap

_WIDEST = 0.7  # tells how bodies face each other: of a cortex a next rotation correlates by half of the best one
#: Points of each level, the share of the surfaces' metrics there, and what features are smoothed by.
_CHAIN = ((642, 0.5, (_WIDEST,)), (2562, 0.9, (_WIDEST, 0.35)), (2562, 0.9, (0.35, 0.12)),
          (10242, 0.9, (0.35, 0.12, 0.05)))
#: The widths in use, from the widest: without data the depth potential of each is compared.
WIDTHS = tuple(dict.fromkeys(width for _, _, each in _CHAIN for width in each))
#: Radians that surfaces are smoothed by before strain is measured: depths of folds differ between bodies.
_SMOOTHING = 0.15
_TURNS = 12  # rotations of a body whose limbs can be told apart by their places only: more than an octopus has arms
_UNSURE = 0.9  # a runner-up with this share of the best correlation is tried, and reported
_GUARD = 0.2  # weight of the strain of the source's sphere beside that from surface to surface (benchmarks/tried.md)
_STEPS = 15  # of Newton's method on each level
_SOFTEST = 1e-6  # of strains that keep faces from degenerating
_LOSS = 0.01  # of correlation in a stage is reported; less than that is due to smoothing


class Turn(NamedTuple):
    """A rotation of a surface's sphere, and how far apart it leaves the two surfaces in space, both of unit area."""

    rotation: FloatArray
    distance: float


@dataclass(frozen=True, eq=False)
class RegistrationStage:
    """What one stage of a registration reached.

    Attributes
    ----------
    name : str
        "start", "rotation", "moebius" or "elastic".
    correlation : (k,) float64 array
        Of each feature as it was given, over the source's area.
    strain : float
        Mean of ``|log J|`` over the sphere, J the ratio of areas after and before; for "elastic" before means after the
        Moebius map, else the source's sphere as it came.
    strain_95 : float
        What 95 percent of the sphere's area is below.
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
        The source (mirrored, if that was asked for) with its registered sphere, certified folding-free. `transfer`
        takes data between it and the target's map.
    stages : tuple of RegistrationStage
        Start and every stage, in their order.
    candidates : tuple of RotationCandidate
        Rotations that were considered and their correlations, the one that was taken first; empty without that stage.
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
        return self.map._drawing()

    def _figures(self) -> str:
        stages = [(stage.name, f"{stage.correlation.mean():.3f}", f"{stage.strain:.3f}") for stage in self.stages]
        return table(stages, ("stage", "correlation", "strain")) + self.map._figures()

    @property
    def rotation(self) -> FloatArray:
        """The rotation that was taken; what lay at x went to R x."""
        return self.candidates[0].rotation if self.candidates else np.eye(3)

    @property
    def margin(self) -> float:
        """Correlation of the rotation that was taken less that of the next one; NaN if there is none."""
        return self.candidates[0].correlation - self.candidates[1].correlation if len(self.candidates) > 1 else np.nan


@own_errstate
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
        Two surfaces with their maps. Of shapes with limbs, take area-preserving maps, of cortices ``balance=0.85``.
    features : (the source's values, the target's values), optional
        Data over the vertices of each, (n,) or (n, k) with the same k. By default the depth potential of each surface,
        see `depth_potential`. Data are smoothed on the surfaces, by .7 radians at first and by .05 in the end, and
        compared at unit variance.
    stages : sequence of str
        One or more of three, by default the first and the last. "rotation" takes the rotation with the highest
        correlation; if "elastic" follows, of those with nearly the highest it takes the one that leads to the least
        energy from surface to surface. "moebius" takes Gauss-Newton steps over Moebius maps. "elastic" takes Newton
        steps on the strain from one surface to the other, the strain of the source's sphere and the features'
        difference, on up to 10,242 points of the sphere, which carry the vertices.
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
        The source's map in the target's frame, certified, and how well it agrees.

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
    check_number(stiffness, "stiffness", _SOFTEST)
    unknown = [stage for stage in stages if stage not in STAGES]
    if unknown:
        raise ValueError(f"unknown stage {unknown[0]!r}: choose from {', '.join(STAGES)}")
    source = reflected(source) if reflect else source
    own = Level.of(source, "the source"), Level.of(target, "the target")
    pair = FeaturePair(*own, features, WIDTHS)
    a, b = pair.smoothed(_SMOOTHING)
    first = _WIDEST if features is None else WIDTHS[-1]  # data are compared nearly as they are
    columns = pair.source([first]).shape[1]
    descent = Descent(a, b, _plan(len(a.map.sphere), stiffness, columns), pair, np.empty((0, 3)))
    course = _Course(source, pair, history)
    candidates: tuple[RotationCandidate, ...] = ()
    with suppress(StopIteration):  # of a listener
        if "rotation" in stages:
            turned, candidates = descent.start(first, moebius=False, least=_UNSURE if "elastic" in stages else 1.0)
            with course.stage("rotation"):
                course(turned, 1 - candidates[0].correlation)
        if "moebius" in stages:
            with course.stage("moebius"):
                fit_moebius(course.x, a.map.faces, pair.weights, pair.source([first]), pair.target([first]), course)
        if "elastic" in stages:
            def step(_: Objective, level: Level, y: FloatArray, energy: float) -> None:
                course(course.x if listener is None else level.carried(y, a), energy)  # the history keeps numbers only

            with course.stage("elastic", course.x):
                level, y = descent.run(course.x, step)
                course.x = level.carried(y, a)
    result = certified(source.mesh, course.x)
    run = history.complete(result.run, "register")
    return Registration(replace(result, run=run), tuple(course.stages), candidates, _doubts(candidates, course.stages))


class DepthRegistration:
    """Lays a surface on another by their depth potentials, as `register` does without features, from chosen starts.

    Maps are those of the source's vertices to the target's sphere.
    """

    def __init__(self, source: SphereMap, target: SphereMap) -> None:
        self._own = Level.of(source, "the source"), Level.of(target, "the target")
        self._pair = FeaturePair(*self._own, None, WIDTHS)
        self._source, self._target = self._pair.smoothed(_SMOOTHING)
        plan = _plan(len(source.sphere), STIFFNESS)
        _, share, widths = _CHAIN[-1]
        self._last = Objective(None, share, widths, 1 / (STIFFNESS * len(widths)), _GUARD, _STEPS)
        self._descent = Descent(self._source, self._target, plan, self._pair, np.empty((0, 3)))

    def turns(self) -> list[Turn]:
        """Rotations at which the potentials agree best locally, in the order of the surfaces' distance in space."""
        found = [Turn(each.rotation, self.apart(each.rotation)) for each in self._pair.rotations(_WIDEST, _TURNS)]
        return sorted(found, key=lambda turn: turn.distance)

    def apart(self, rotation: FloatArray) -> float:
        """Distance of the surfaces after a rotation of the source's sphere, on the coarsest level."""
        return self._descent.distance(self.turned(rotation))

    def turned(self, rotation: FloatArray) -> FloatArray:
        """The source's map after a rotation."""
        return unfolded(self._own[0].map.mesh, self._own[0].map.sphere @ rotation.T)  # rounding may fold slivers

    def outlook(self, y: FloatArray) -> float:
        """Energy times distance that a start leads to on the coarsest level; both vanish for similar bodies."""
        return self._descent.outlook(y)

    def run(self, y: FloatArray) -> FloatArray:
        """The registration that a start leads to, through all levels."""
        level, y = self._descent.run(y, lambda *_: None)
        return level.carried(y, self._source)

    def continued(self, y: FloatArray) -> FloatArray:
        """Register again, from `y`, after the target moved a little: only the last level's steps are taken."""
        return self._descent.lowered(self._source, self._target, unfolded(self._own[0].map.mesh, y), [self._last])[1]

    def distance(self, y: FloatArray) -> float:
        """Root mean square distance of corresponding points after a similarity, of surfaces of unit area."""
        return distance_between(*self._own, y)

    def correlation(self, y: FloatArray) -> float:
        """Correlation of the potentials over the source's area."""
        return float(self._pair.correlation(y).mean())


def _plan(size: int, stiffness: float, columns: int = 1) -> list[Objective]:
    """The objectives of a registration, from coarse to fine."""
    return [Objective(min(points, size), share, widths, 1 / (stiffness * columns * len(widths)), _GUARD, _STEPS)
            for points, share, widths in _CHAIN]


class _Course:
    """Keeps the last iterate of the source's sphere, passes iterates on, and reports each stage."""

    def __init__(self, source: SphereMap, pair: FeaturePair, listener: Listener) -> None:
        self.x, self.stages = source.sphere, [_report("start", pair, source.faces, source.sphere, source.sphere)]
        self._source, self._pair, self._listener = source, pair, listener
        self._name, self._count = "", 0

    def __call__(self, x: FloatArray, cost: float) -> None:
        self.x = x
        self._count += 1
        self._listener(Iterate(self._name, 0, self._count, x, cost))

    @contextmanager
    def stage(self, name: str, before: FloatArray | None = None) -> Iterator[None]:
        """Run a stage, and report it at its end; its strain is measured against `before`, or the map as it came."""
        self._name, self._count = name, 0
        before = self._source.sphere if before is None else before
        try:
            yield
        finally:
            self.stages.append(_report(name, self._pair, self._source.faces, before, self.x))


def reflected(result: SphereMap) -> SphereMap:
    """Mirror a surface and its map, x to -x, and reverse its faces: angles and areas stay."""
    mirror = np.array([-1.0, 1.0, 1.0])
    mesh = check_mesh(result.vertices * mirror, result.faces[:, ::-1], caps=result.mesh.caps)
    image, *conformal = (replace(certified(mesh, each.sphere * mirror), run=each.run)
                         for each in (result, result.conformal) if each is not None)
    return replace(image, conformal=conformal[0] if conformal else None)


def _report(name: str, pair: FeaturePair, f: IntArray, before: FloatArray, x: FloatArray) -> RegistrationStage:
    areas = face_areas(before, f)
    J = np.abs(np.log(face_areas(x, f) / areas))
    mean = float(areas @ J / areas.sum())
    return RegistrationStage(name, pair.correlation(x), mean, weighted_quantile(J, areas, 0.95))


def _doubts(candidates: tuple[RotationCandidate, ...], stages: list[RegistrationStage]) -> tuple[str, ...]:
    notes = []
    if len(candidates) > 1 and candidates[1].correlation > _UNSURE * candidates[0].correlation:
        notes.append(f"the margin is small: the rotation that was taken correlates {candidates[0].correlation:.3f}, "
                     f"another one {candidates[1].correlation:.3f}")
    for before, after in pairwise(stages):
        lost = float(before.correlation.mean() - after.correlation.mean())
        if lost > _LOSS:
            notes.append(f"the stage {after.name} lowered the correlation by {lost:.3f}: parts of the surface are too "
                         "small on these maps; register area-preserving ones")
    return tuple(notes)
