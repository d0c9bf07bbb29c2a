"""Which remedy is taken when: from a map with foldings to one that is certified to have none.

1. *map*: free of foldings, it is returned as it is, and only the certificate was paid for.
2. *delaunay*: with more than a handful of foldings, the map of the intrinsic Delaunay weights: none is negative.
3. *limbs*: with more than a few left, and edges so short that the solver's absolute error folds them, the deep limbs
   are solved again in nested frames, drawn out where float64 ends; first with the Delaunay weights, then with those
   of the mesh's own edges made positive, which suit limbs of few vertices around.
4. *embedding*: what is left is mended by progressive embedding, which always works, and relaxed. The map with the
   fewest foldings and the one with the least angle differences are both tried, and the better result is kept.
5. *mips*: what came off rungs 2 and 3 without foldings is conformal for other weights than the mesh's own: a few sweeps
   of descent on the MIPS energy of its own triangles, kept if angles gain by it.
6. *axis*: only if asked for, and where edges end below float64: the two deepest tips are put at the poles.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..certify import Certificate, certify_checked
from ..distortion import mesh_angle_differences
from ..energy import HarmonicEnergy
from ..fast import fast_map
from ..gauge import fix_gauge
from ..iterate import Iterate, Listener, Status
from ..laplacian import laplacian
from ..mesh import Mesh
from ..metric import Metric, build_metric
from ..sphere_map import Round
from .axis import axis_limbs
from .depth import log_edges, predicted_log_edges
from .embedding import Watch, dilate, progressive_embedding, upright
from .nested import solve_limbs
from .relax import AngleLoss, MipsLoss, descend

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

#: Foldings, as a number and as a share of the faces, that are mended in the first map, and in a later one.
_HANDFUL = (2, 4e-5)
_FEW = (20, 2e-4)
#: Limbs are solved again if an image edge is predicted to be shorter than exp(-this).
_DEEP = 20.0
#: Image edges shorter than exp(-this) suffer from the rounding of positions.
_ROUNDED = 28.0
#: Rings around what embedding moved that are relaxed with it.
_RELAXED_RINGS = 2
_SWEEPS = 30
_MIPS_SWEEPS = 3


@dataclass(frozen=True, eq=False)
class Mended:
    """A map after the ladder.

    Attributes
    ----------
    x : (n, 3) float64 array
        Unit rows.
    certificate : Certificate
        Of `x`.
    rounds : tuple of Round
        The rungs that were taken; none for a map that needed no repair.
    stretch : float
        How far limbs beyond the reach of float64 had to be drawn out, as a ratio of lengths; 1 if none had
        to.
    on_axis : bool
        Whether the gauge is `axis_gauge`.
    """

    x: FloatArray
    certificate: Certificate
    rounds: tuple[Round, ...] = ()
    stretch: float = 1.0
    on_axis: bool = False


def climb(mesh: Mesh, metric: Metric, x: FloatArray, listener: Listener | None = None, *,
          axis: bool = False) -> Mended:
    """Mend a map of the fast pipeline, by the cheapest rung that works.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    metric : Metric
        Its factorised Laplacian.
    x : (n, 3) float64 array
        The map, in the gauge that the result is to have.
    listener : callable, optional
        Called with every rung's map.
    axis : bool
        Whether the gauge may be changed to `axis_gauge` for bodies beyond float64.

    Returns
    -------
    Mended
        With `x` itself if that is free of foldings.
    """
    certificate = certify_checked(x, mesh.f)
    if certificate.folding_free and not axis:
        return Mended(x, certificate)
    ladder = _Ladder(mesh, metric, listener)
    ladder.add("map", x)
    if not ladder.nearly(_HANDFUL):
        ladder.delaunay()
        if not ladder.nearly(_FEW):
            ladder.limbs()
    if not ladder.free:
        ladder.embedding()
    elif len(ladder.tried) > 1:
        ladder.mips()
    if axis:
        ladder.axis()
    best = ladder.best()
    return Mended(best.x, best.certificate, tuple(ladder.rounds), best.stretch, best.name == "axis")


def mend_locally(mesh: Mesh, x: FloatArray, watch: Watch | None = None) -> FloatArray:
    """Embed what is folded, and relax it with its surroundings.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    x : (n, 3) float64 array
        Unit rows.
    watch : callable, optional
        Called with the map each time that a batch of vertices was put back.

    Returns
    -------
    (n, 3) float64 array
        Unit rows, certified free of foldings.
    """
    x = upright(x, mesh.f)
    y = progressive_embedding(x, mesh.f, watch)
    return _relaxed(mesh, y, dilate(mesh.f, (y != x).any(axis=1), _RELAXED_RINGS))


def _relaxed(mesh: Mesh, x: FloatArray, movable: BoolArray) -> FloatArray:
    """Descend on the angle differences of some vertices, at a cost that only they cause."""
    around = mesh.f[movable[mesh.f].any(axis=1)]
    return descend(x, around, AngleLoss.of(mesh.v, around), movable, sweeps=_SWEEPS) if len(around) else x


@dataclass(frozen=True, eq=False)
class _Candidate:
    """A map that may be the one."""

    name: str
    x: FloatArray
    certificate: Certificate
    angles: float
    stretch: float


class _Ladder:
    """The maps that were tried so far, and the rungs that make others."""

    def __init__(self, mesh: Mesh, metric: Metric, listener: Listener | None) -> None:
        self.mesh, self.listener = mesh, listener
        self.tried: list[_Candidate] = []
        self.rounds: list[Round] = []
        self._metric, self._began = metric, time.perf_counter()

    @property
    def free(self) -> bool:
        """Whether the last map is free of foldings."""
        return self.tried[-1].certificate.folding_free

    def nearly(self, few: tuple[int, float]) -> bool:
        """Whether the last map has so few foldings that they are mended where they are."""
        certificate = self.tried[-1].certificate
        return certificate.degree == 1 and certificate.foldings <= max(few[0], few[1] * len(self.mesh.f))

    @cached_property
    def metric(self) -> Metric:
        """Laplacian of intrinsic Delaunay weights, factorised, with the same areas to balance."""
        if self._metric.weights == "delaunay":
            return self._metric
        return replace(build_metric(self.mesh, self._metric.factor.backend, "delaunay"), A=self._metric.A)

    def delaunay(self) -> None:
        """The harmonic map of the intrinsic Delaunay weights."""
        if self._metric.weights != "delaunay":
            self.add("delaunay", fix_gauge(self.mesh, fast_map(self.mesh, self.metric).last.x, self.metric.A))

    def limbs(self) -> None:
        """The last map, its deep limbs solved again."""
        x = self.tried[-1].x
        depth = -predicted_log_edges(self.mesh.v, self.mesh.f, x, self.metric.factor, self.metric.A)
        if depth.max() < _DEEP:
            return
        for weights in ("delaunay", "mollified"):
            L = self.metric.L if weights == "delaunay" else laplacian(self.mesh.v, self.mesh.f, weights)
            limbs = solve_limbs(x, L, depth, self.metric.A)
            self.add("limbs", limbs.onto_sphere(x), limbs.stretch)
            if self.nearly(_FEW):
                break

    def embedding(self) -> None:
        """The most promising maps, mended."""
        fewest = min(self.tried, key=lambda candidate: candidate.certificate.foldings)
        nearest = min(self.tried, key=lambda candidate: candidate.angles)
        for candidate in [fewest] if fewest is nearest else [fewest, nearest]:
            self.add("embedding", mend_locally(self.mesh, candidate.x), candidate.stretch)

    def mips(self) -> None:
        """The last map, relaxed to the mesh's own triangles."""
        last = self.tried[-1]
        self.add("mips", descend(last.x, self.mesh.f, MipsLoss.of(self.mesh.v, self.mesh.f), sweeps=_MIPS_SWEEPS),
                 last.stretch)

    def axis(self) -> None:
        """The best map in the gauge that has its deepest tips at the poles."""
        best, metric = self.best(), self.metric
        if log_edges(best.x, self.mesh.f).min() > -_ROUNDED:
            return
        x, limbs = axis_limbs(self.mesh.v, self.mesh.f, best.x, metric.L, metric.factor, metric.A)
        if not certify_checked(x, self.mesh.f).folding_free:
            x = mend_locally(self.mesh, x)
        self.add("axis", x, limbs.stretch)

    def best(self) -> _Candidate:
        """The map with the least angle differences among those free of foldings."""
        return min(self.tried, key=lambda tried: (not tried.certificate.folding_free, tried.angles))

    def add(self, name: str, x: FloatArray, stretch: float = 1.0) -> None:
        """Judge a map, tell the listener, and put it on record."""
        certificate = certify_checked(x, self.mesh.f)
        if self.tried and certificate.folding_free:
            short = log_edges(x, self.mesh.f) < -_ROUNDED
            x = _relaxed(self.mesh, x, short)
            certificate = certify_checked(x, self.mesh.f) if short.any() else certificate
        angles = float(np.abs(mesh_angle_differences(self.mesh, x)).mean())
        k, now = len(self.rounds), time.perf_counter()
        before = self.rounds[-1].foldings_after if k else certificate.foldings
        energy = HarmonicEnergy(self._metric.L).evaluate(x)[0]
        self.rounds.append(Round(k, name, before, certificate.foldings, 0, energy, angles, Status.CONVERGED,
                                 now - self._began))
        self._began = now
        self.tried.append(_Candidate(name, x, certificate, angles, stretch))
        if self.listener is not None:
            self.listener(Iterate("repair", k, 0, x, energy, float(certificate.foldings),
                                  details={"rung": name, "angles": angles}))
