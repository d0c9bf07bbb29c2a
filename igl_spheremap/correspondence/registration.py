"""One mapped surface laid on another, certified."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from ..errors import check_number, own_errstate
from ..maps.given_sphere import certified
from ..mesh.arrays import FloatArray, IntArray
from ..mesh.check import check_mesh
from ..mesh.measure import face_areas, weighted_quantile
from ..result.run import History, Iterate, Listener
from ..result.sphere_map import SphereMap
from ..shapes.features import SurfacePair
from ..shapes.rotation import RotationCandidate
from ..untangle.local_repair import unfolded
from . import STAGES
from .descent import SHARES, Descent
from .fits import fit_moebius
from .levels import Level

FIRST_WIDTH = 0.05  # radians that the features are smoothed by for rotation and Moebius map
#: The default stiffness for given features, and for those of the geometry, which differ more between bodies.
_STIFFNESS, _GEOMETRY_STIFFNESS = 0.07, 2.5
_SOFTEST = 1e-6  # of strains that keep faces from degenerating
_UNSURE = 0.9  # a runner-up with this share of the best correlation is reported
_LOSS = 0.01  # of correlation in a stage is reported; less than that is due to smoothing


@dataclass(frozen=True, eq=False)
class RegistrationStage:
    """What one stage of a registration reached.

    Attributes
    ----------
    name : str
        "start", "rotation", "moebius" or "elastic".
    correlation : (k,) float64 array
        Of each feature as it was given, over the moving surface's area.
    strain : float
        Mean of ``|log J|`` over the sphere, J the ratio of areas after and before; for "elastic" before means after the
        Moebius map, else the moving sphere as it came.
    strain_95 : float
        What 95 percent of the sphere's area is below.
    """

    name: str
    correlation: FloatArray
    strain: float
    strain_95: float


@dataclass(frozen=True, eq=False)
class Registration:
    """A moving surface's map in the frame of a fixed one.

    Attributes
    ----------
    map : SphereMap
        The moving surface (mirrored, if that was asked for) with its registered sphere, certified folding-free.
        `transfer` takes data between it and the fixed map.
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

    @property
    def rotation(self) -> FloatArray:
        """The rotation that was taken; what lay at x went to R x."""
        return self.candidates[0].rotation if self.candidates else np.eye(3)

    @property
    def margin(self) -> float:
        """How much better the rotation that was taken correlates than the next one; NaN if there is none."""
        return self.candidates[0].correlation - self.candidates[1].correlation if len(self.candidates) > 1 else np.nan


@own_errstate
def register(
    moving: SphereMap,
    fixed: SphereMap,
    features: tuple[ArrayLike, ArrayLike] | None = None,
    stages: Sequence[str] = STAGES,
    stiffness: float | None = None,
    reflect: bool = False,
    listener: Listener | None = None,
) -> Registration:
    """Lay one mapped surface on another so that their features agree.

    Parameters
    ----------
    moving, fixed : SphereMap
        Two surfaces with their maps. Of shapes with limbs, take area-preserving maps.
    features : (moving values, fixed values), optional
        Data over the vertices of each, (n,) or (n, k) with the same k. By default curvature and depth of each surface.
        They are smoothed on the surfaces and compared at unit variance.
    stages : sequence of str
        Which of these, by default all: "rotation" (that correlates best; before "elastic", of the four best the one
        that leads to the least energy from surface to surface, as in `match`), "moebius" (Gauss-Newton over Moebius
        maps) and "elastic" (Newton's method on the strain from one surface to the other, as in `match`, and on that of
        the moving sphere, with the features' difference).
    stiffness : float, optional
        Weight of the strains, from surface to surface and of the moving sphere alike, beside features of unit variance:
        0.07 by default for given features, 2.5 for those of the geometry. Lower values raise the correlation and not
        the precision: features differ between bodies, too.
    reflect : bool
        Mirror the moving surface and its map (x to -x), and reverse its faces: for left and right sides of a body.
    listener : callable, optional
        Called with an `Iterate` after the rotation and after every step; may raise StopIteration to stop with the
        current map.

    Returns
    -------
    Registration
        The moving surface's map in the fixed frame, certified, and how well it agrees.

    Raises
    ------
    MeshError
        If features are missing, not finite or constant, or a surface is a sphere, its own map.
    FoldingsRemain
        If a map is not certified folding-free.
    ValueError
        If there is no such stage, or `stiffness` is below 1e-6.
    TypeError
        If `stiffness` is no number, or the listener can't be called.

    Examples
    --------
    >>> import numpy as np
    >>> import igl_spheremap as ism
    >>> pear = ism.spherical_conformal_map(*ism.samples.make("pear", n_vertices=1000))
    >>> quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    >>> turned = ism.sphere_map(pear.vertices, pear.faces, pear.sphere @ quarter)
    >>> result = ism.register(turned, pear, features=(pear.sphere[:, :2], pear.sphere[:, :2]))
    >>> bool(np.abs(result.map.sphere - pear.sphere).max() < 0.01), result.map.certificate.folding_free
    (True, True)
    """
    history = History(listener)
    if stiffness is not None:
        check_number(stiffness, "stiffness", _SOFTEST)
    unknown = [stage for stage in stages if stage not in STAGES]
    if unknown:
        raise ValueError(f"unknown stage {unknown[0]!r}: choose from {', '.join(STAGES)}")
    moving = reflected(moving) if reflect else moving
    pair = SurfacePair(moving, fixed, features, [FIRST_WIDTH, *(SHARES.values() if "elastic" in stages else ())])
    descent = None
    if "elastic" in stages:
        last = stiffness if stiffness is not None else _GEOMETRY_STIFFNESS if features is None else _STIFFNESS
        descent = Descent(Level.of(moving, "moving"), Level.of(fixed, "fixed"), np.empty((0, 3)), pair,
                          (1 / last,) * 2, guard=1.0)  # `stages` report the sphere's strain
    course = _Course(moving, pair, history)
    candidates: tuple[RotationCandidate, ...] = ()
    with suppress(StopIteration):  # of a listener
        if "rotation" in stages:
            candidates = descent.start()[1] if descent else tuple(pair.rotations())
            with course.stage("rotation"):
                turned = unfolded(moving.mesh, course.x @ candidates[0].rotation.T)  # rounding may fold slivers
                course(turned, 1 - candidates[0].correlation)
        if "moebius" in stages:
            with course.stage("moebius"):
                fit_moebius(course.x, moving.faces, pair.weights, pair.features[0], pair.fixed_features(0), course)
        if descent:
            with course.stage("elastic", course.x):
                descent.run(course.x, lambda _, y, cost: course(y, cost))
    result = certified(moving.mesh, course.x)
    run = history.complete(result.run, "register")
    return Registration(replace(result, run=run), tuple(course.stages), candidates, _doubts(candidates, course.stages))


class _Course:
    """The moving sphere on its way: takes each iterate, passes it on, and reports the stages."""

    def __init__(self, moving: SphereMap, pair: SurfacePair, listener: Listener) -> None:
        self.x, self.stages = moving.sphere, [_report("start", pair, moving.faces, moving.sphere, moving.sphere)]
        self._moving, self._pair, self._listener = moving, pair, listener
        self._name, self._count = "", 0

    def __call__(self, x: FloatArray, cost: float) -> None:
        self.x = x
        self._count += 1
        self._listener(Iterate(self._name, 0, self._count, x, cost))

    @contextmanager
    def stage(self, name: str, before: FloatArray | None = None) -> Iterator[None]:
        """A stage, whose strain is measured against the map before, or as it came."""
        self._name, self._count = name, 0
        before = self._moving.sphere if before is None else before
        try:
            yield
        finally:
            self.stages.append(_report(name, self._pair, self._moving.faces, before, self.x))


def reflected(result: SphereMap) -> SphereMap:
    """The mirror image of a surface with that of its map, x to -x, and faces reversed: angles and areas stay."""
    mirror = np.array([-1.0, 1.0, 1.0])
    mesh = check_mesh(result.vertices * mirror, result.faces[:, ::-1], result.mesh.caps)
    image, *conformal = (replace(certified(mesh, each.sphere * mirror), run=each.run)
                         for each in (result, result.conformal) if each is not None)
    return replace(image, conformal=conformal[0] if conformal else None)


def _report(name: str, pair: SurfacePair, f: IntArray, before: FloatArray, x: FloatArray) -> RegistrationStage:
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
