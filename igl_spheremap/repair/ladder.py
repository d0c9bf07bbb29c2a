"""Which remedy is taken when: from a map with foldings to one that is certified to have none.

1. *map*: free of foldings, it is returned as it is, and only the certificate was paid for.
2. *delaunay*: with more than a few foldings, the map of the intrinsic Delaunay weights, which are not negative.
3. *limbs*: with more than a few foldings left, and edges so short that the solver's absolute error folds them, the
   deep limbs are solved again in nested frames, drawn out where float64 ends; first with the Delaunay weights, then
   with those of the mesh's own edges made positive, which suit limbs of few vertices around.
4. *embedding*: what is left is mended by progressive embedding, which always works, and relaxed. The map with the
   fewest foldings and the one with the least angle differences are both tried, and the better result is kept.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..certify import Certificate, certify_checked
from ..distortion import mesh_angle_differences
from ..fast import fast_map
from ..gauge import fix_gauge
from ..iterate import Iterate, Listener, Status
from ..laplacian import laplacian
from ..mesh import Mesh
from ..metric import Metric, build_metric
from ..sphere_map import Round
from .depth import predicted_log_edges
from .embedding import dilate, progressive_embedding
from .nested import solve_limbs
from .relax import AngleLoss, descend

FloatArray = NDArray[np.float64]

#: Foldings, as a share of the faces and as a number, that are mended without looking for a better map first.
_FEW_SHARE = 2e-4
_FEW = 20
#: Limbs are deep if an image edge is predicted to be shorter than exp(-this).
_DEEP = 20.0
#: Rings around what embedding moved that are relaxed with it.
_RELAXED_RINGS = 2


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
        The rungs that were taken.
    stretch : float
        How far limbs beyond the reach of float64 had to be drawn out, as a ratio of lengths; 1 if none had to.
    """

    x: FloatArray
    certificate: Certificate
    rounds: tuple[Round, ...] = ()
    stretch: float = 1.0


@dataclass(frozen=True, eq=False)
class _Candidate:
    """A map that may be the one, and what was done to get it."""

    name: str
    x: FloatArray
    certificate: Certificate
    angles: float
    stretch: float = 1.0


def climb(mesh: Mesh, metric: Metric, x: FloatArray, listener: Listener | None = None) -> Mended:
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

    Returns
    -------
    Mended
        With `x` itself if that is free of foldings.
    """
    climber = _Climber(mesh, listener)
    start = climber.tell("map", x)
    if start.certificate.folding_free:
        return Mended(x, start.certificate)
    tried = [start]
    others = _other_maps(mesh, metric, x)
    while not _nearly(tried[-1].certificate, mesh) and (other := next(others, None)) is not None:
        tried.append(climber.tell(*other))
    free = [candidate for candidate in tried if candidate.certificate.folding_free]
    if not free:  # the last rung
        fewest = min(tried, key=lambda candidate: candidate.certificate.foldings)
        nearest = min(tried, key=lambda candidate: candidate.angles)
        for candidate in {id(c): c for c in (fewest, nearest)}.values():
            free.append(climber.tell("embedding", mend_locally(mesh, candidate.x), candidate.stretch))
    best = min(free, key=lambda candidate: (not candidate.certificate.folding_free, candidate.angles))
    return Mended(best.x, best.certificate, tuple(climber.rounds), best.stretch)


def _nearly(certificate: Certificate, mesh: Mesh) -> bool:
    """Whether so few foldings are left that they are mended where they are."""
    return certificate.degree == 1 and certificate.foldings <= max(_FEW, _FEW_SHARE * len(mesh.f))


def mend_locally(mesh: Mesh, x: FloatArray) -> FloatArray:
    """Embed what is folded, and relax it with its surroundings.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    x : (n, 3) float64 array
        Unit rows.

    Returns
    -------
    (n, 3) float64 array
        Unit rows, certified free of foldings.
    """
    y = progressive_embedding(x, mesh.f)
    moved = dilate(mesh.f, (y != x).any(axis=1), _RELAXED_RINGS)
    around = mesh.f[moved[mesh.f].any(axis=1)]
    return descend(y, around, AngleLoss.of(mesh.v, around), moved, sweeps=30)


def _other_maps(mesh: Mesh, metric: Metric, x: FloatArray) -> Iterator[tuple[str, FloatArray, float]]:
    """Maps by other weights, in the gauge of the first, and how far their limbs were drawn out."""
    if metric.weights != "delaunay":
        metric = build_metric(mesh, metric.factor.backend, "delaunay")
        x = fix_gauge(mesh, fast_map(mesh, metric).last.x, metric.A)
        yield "delaunay", x, 1.0
    depth = -predicted_log_edges(mesh.v, mesh.f, x, metric.factor, metric.A)
    if depth.max() > _DEEP:
        for weights in (metric.L, laplacian(mesh.v, mesh.f, "mollified")):
            limbs = solve_limbs(x, weights, depth, metric.A)
            yield "limbs", limbs.onto_sphere(x), limbs.stretch


class _Climber:
    """Certifies and measures each rung's map, tells the listener, and keeps the record."""

    def __init__(self, mesh: Mesh, listener: Listener | None) -> None:
        self.rounds: list[Round] = []
        self._mesh, self._listener = mesh, listener
        self._foldings, self._began = 0, time.perf_counter()

    def tell(self, name: str, x: FloatArray, stretch: float = 1.0) -> _Candidate:
        """Judge a map."""
        certificate = certify_checked(x, self._mesh.f)
        angles = float("nan")
        if self.rounds or not certificate.folding_free:
            angles = float(np.abs(mesh_angle_differences(self._mesh, x)).mean())
            self._record(name, x, certificate.foldings, angles)
        return _Candidate(name, x, certificate, angles, stretch)

    def _record(self, name: str, x: FloatArray, foldings: int, angles: float) -> None:
        k, now = len(self.rounds), time.perf_counter()
        before = self._foldings if k else foldings
        self.rounds.append(Round(k, name, before, foldings, 0, float("nan"), angles, Status.CONVERGED,
                                 now - self._began))
        self._foldings, self._began = foldings, now
        if self._listener is not None:
            self._listener(Iterate("repair", k, 0, x, float("nan"), float(foldings), details={"rung": name}))
