"""One mapped surface laid on another, certified."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...descent.iterate import Iterate, Listener
from ...maps.given_sphere import sphere_map
from ...maps.methods import METHODS
from ...maps.repair_foldings import repair_foldings
from ...maps.sphere_map import SphereMap
from ...maps.spherical_conformal_map import spherical_conformal_map
from ...mesh.measure import face_areas
from ...verify.certificate import certify_checked
from .correlation import Candidate
from .moebius_fit import fit_moebius
from .pair import Pair

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

STAGES = ("rotation", "moebius")
_FIRST_WIDTH = 0.05  # radians, of the features that rotation and Moebius map compare
_UNSURE = 0.9  # a runner-up with this share of the best correlation is named


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
        Mean of |log J| over the sphere, J the ratio of areas after and before; for "elastic" before means after the
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
    candidates : tuple of Candidate
        Rotations that were considered and their correlations, the best first; empty without that stage.
    notes : tuple of str
        What makes the result doubtful.
    """

    map: SphereMap
    stages: tuple[RegistrationStage, ...]
    candidates: tuple[Candidate, ...]
    notes: tuple[str, ...] = ()

    @property
    def rotation(self) -> FloatArray:
        """The rotation that was taken; what lay at x went to R x."""
        return self.candidates[0].rotation if self.candidates else np.eye(3)

    @property
    def margin(self) -> float:
        """How much better the best rotation correlates than the runner-up; NaN if there is none."""
        return self.candidates[0].correlation - self.candidates[1].correlation if len(self.candidates) > 1 else np.nan


def register(
    moving: SphereMap,
    fixed: SphereMap,
    features: tuple[ArrayLike, ArrayLike] | None = None,
    stages: Sequence[str] = STAGES,
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
        Which of "rotation" (correlation over all rotations) and "moebius" (Gauss-Newton over Moebius maps).
    reflect : bool
        Mirror the moving surface (x to -x), reverse its faces, and map it anew: for left and right sides of a body.
    listener : callable, optional
        Called with an `Iterate` after the rotation and after every step.

    Returns
    -------
    Registration
        The moving surface's map in the fixed frame, certified, and how well it agrees.

    Raises
    ------
    MeshError
        If features are missing, not finite or constant.
    FoldingsRemain
        If a map is not certified folding-free.
    ValueError
        If there is no such stage.

    Examples
    --------
    >>> import numpy as np
    >>> import igl_spheremap as ism
    >>> pear = ism.spherical_conformal_map(*ism.samples.make("pear", n_vertices=1000))
    >>> quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    >>> turned = ism.sphere_map(pear.vertices, pear.faces, pear.sphere @ quarter)
    >>> result = ism.register(turned, pear, features=(pear.sphere[:, :2], pear.sphere[:, :2]))
    >>> bool(np.abs(result.map.sphere - pear.sphere).max() < 1e-3)
    True
    """
    began = time.perf_counter()
    unknown = [stage for stage in stages if stage not in STAGES]
    if unknown:
        raise ValueError(f"unknown stage {unknown[0]!r}: choose from {', '.join(STAGES)}")
    moving = reflected(moving) if reflect else moving
    pair = Pair(moving, fixed, features, [_FIRST_WIDTH])
    f, x = moving.faces, moving.sphere
    log = [_stage("start", pair, f, x, x)]
    candidates: tuple[Candidate, ...] = ()
    if "rotation" in stages:
        candidates = tuple(pair.rotations())
        x = unfolded(moving, x @ candidates[0].rotation.T)
        log.append(_stage("rotation", pair, f, moving.sphere, x))
        if listener is not None:
            listener(Iterate("rotation", 0, 0, x, 1 - candidates[0].correlation))
    if "moebius" in stages:
        notify = _Notifier("moebius", listener)
        x = fit_moebius(x, f, pair.weights, pair.features[0], pair.picture(0), notify)
        log.append(_stage("moebius", pair, f, moving.sphere, x))
    result = replace(sphere_map(moving.vertices, f, x), method="register", seconds=time.perf_counter() - began)
    return Registration(result, tuple(log), candidates, _doubts(candidates))


class _Notifier:
    """Numbers the iterates of a stage and passes them on."""

    def __init__(self, stage: str, listener: Listener | None) -> None:
        self._stage, self._listener, self._count = stage, listener, 0

    def __call__(self, x: FloatArray, cost: float) -> None:
        self._count += 1
        if self._listener is not None:
            self._listener(Iterate(self._stage, 0, self._count, x, cost))


def reflected(result: SphereMap) -> SphereMap:
    """The mirror image of a surface, mapped anew by the method and options that made its map."""
    method = METHODS[result.method](**result.settings) if result.method in METHODS else "auto"
    mirrored = result.vertices * [-1.0, 1.0, 1.0]
    return spherical_conformal_map(mirrored, np.ascontiguousarray(result.faces[:, ::-1]), method)


def unfolded(result: SphereMap, x: FloatArray) -> FloatArray:
    """x, where the rounding of a rotation may have folded slivers, as a bijection."""
    if certify_checked(x, result.faces).folding_free:
        return x
    return repair_foldings(result.vertices, result.faces, x).sphere


def _stage(name: str, pair: Pair, f: IntArray, before: FloatArray, x: FloatArray) -> RegistrationStage:
    areas = face_areas(before, f)
    J = np.abs(np.log(face_areas(x, f) / areas))
    order = np.argsort(J)
    covered = np.cumsum(areas[order])
    return RegistrationStage(name, pair.correlation(x), float(areas @ J / covered[-1]),
                             float(J[order][np.searchsorted(covered, 0.95 * covered[-1])]))


def _doubts(candidates: tuple[Candidate, ...]) -> tuple[str, ...]:
    if len(candidates) > 1 and candidates[1].correlation > _UNSURE * candidates[0].correlation:
        return (f"the margin is small: the best rotation correlates {candidates[0].correlation:.3f}, "
                f"another one {candidates[1].correlation:.3f}",)
    return ()
