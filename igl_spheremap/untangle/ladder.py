"""Which remedy is taken when: from a map with foldings to one that is certified to have none.

1. *map*: free of foldings, it is returned as it is, and only the certificate was paid for.
2. *delaunay*: with more than a handful of foldings, the map of the intrinsic Delaunay weights: none is negative.
3. *limbs*: with more than a few left, and edges so short that the solver's absolute error folds them, the deep limbs
   are solved again in nested frames, drawn out where float64 ends; first with the Delaunay weights, then with those
   of the mesh's own edges made positive, which suit limbs of few vertices around.
4. *middle*: if even then much is folded, the body may be so long that the end away from the puncture is beyond what
   floating point tells. Its map is made anew, punctured halfway between its deepest tips, and so are its limbs.
5. *embedding*: what is left is set upright by small moves, or else mended by progressive embedding, which always works,
   and relaxed: of all maps so far the one with the least angle differences, and the one with the fewest foldings if
   its angles may yet be better.
6. *angles*: a mended map that is off by more than a few degrees on average is brought nearer to the mesh's own angles
   by a sweep over its vertices. One that is hardly conformal even so, or coarse, takes Newton steps too, while they
   gain much; and so does such a map that has no foldings, whose triangles are too thin or too large for the harmonic
   energy to tell.
7. *poles*: only if asked for, and where edges end below float64: the two deepest tips are put at the poles.
"""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..descent.energies.harmonic import HarmonicEnergy
from ..descent.iterate import Iterate, Listener, Round, Status
from ..descent.preconditioned import harmonic_map
from ..errors import FactorisationFailed
from ..mesh.check import Mesh
from ..mesh.measure import corner_angles
from ..operators.laplacian import laplacian
from ..operators.operators import Operators, build_operators
from ..sphere.gauge import fix_gauge
from ..start.punctured import is_coarse, punctured_start
from ..verify.certificate import Certificate, certify_checked
from ..verify.distortion import mean_angle_difference, mean_difference
from .candidate import Candidate
from .depth import log_edges, middle_face, predicted_log_edges
from .mend import mend_locally, relax_some, restore_gauge
from .nested import solve_limbs
from .poles import poles_limbs
from .polish import match_angles
from .relax import AngleLoss, descend

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

#: Foldings, as a number and as a share of the faces, that are mended in the first map, in a later one, and in the last.
_HANDFUL = (2, 4e-5)
_FEW = (20, 5e-3)
_MANY = (20, 0.05)
#: Limbs are solved again if an image edge is predicted to be shorter than exp(-this).
_DEEP = 20.0
#: Image edges shorter than exp(-this) suffer from the rounding of positions.
_ROUNDED = 28.0
#: Mean angle difference, in degrees, beyond which a mended map is brought nearer to the mesh's angles by a sweep, and
#: beyond which any map is by Newton steps.
_POOR = 2.5
_HARDLY_CONFORMAL = 7.0
#: Rounds of Newton steps at the most; they end when one gains less than this share.
_ROUNDS = 8
_LEAST_GAIN = 0.1
#: A map that needed no mending is changed for nothing less than this share.
_MUCH = 0.15
#: Faces looked at to tell whether a map is hardly conformal.
_SAMPLE = 1000


def untangle(mesh: Mesh, operators: Operators, first: Candidate, listener: Listener | None = None, *,
             poles: bool = False) -> Candidate:
    """Repair a map that is in the gauge of the result, by the first rung that works.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    operators : Operators
        Its factorised Laplacian.
    first : Candidate
        The map, certified; handed back with its positions if it is free of foldings and no worse than hardly conformal.
    listener : callable, optional
        Called with every rung's map.
    poles : bool
        Whether the gauge may be changed to `poles_gauge` for bodies beyond float64.
    """
    x, certificate = first.x, first.certificate or certify_checked(first.x, mesh.f)
    ladder = _Ladder(mesh, operators, listener)
    if certificate.folding_free:
        y = _nearer(mesh, x)
        if y is x and not poles:
            return replace(first, certificate=certificate)
        ladder.add("map", x, certificate=certificate)
        if y is not x:
            ladder.add("angles", y)
    else:
        ladder.add("map", x, certificate=certificate)
        if not ladder.nearly(_HANDFUL):
            ladder.delaunay()
            if not ladder.nearly(_FEW):
                ladder.limbs()
                if not ladder.nearly(_MANY):
                    ladder.middle()
        ladder.embedding()
        ladder.angles()
    if poles:
        ladder.poles()
    best = ladder.best()
    x, certificate = best.x, best.certificate
    if best.name not in ("map", "poles"):
        x = restore_gauge(mesh, x, operators.A)
        certificate = certify_checked(x, mesh.f)
    energy = first.energy if x is first.x else HarmonicEnergy(operators.L).evaluate(x)[0]
    return replace(first, x=x, energy=energy, certificate=certificate, rounds=tuple(ladder.rounds),
                   stretch=best.stretch, gauge="poles" if best.name == "poles" else "centred")


def _nearer(mesh: Mesh, x: FloatArray) -> FloatArray:
    """A map without foldings that is hardly conformal, or coarse, nearer to the mesh's angles if that gains much."""
    f = mesh.f[:: max(1, len(mesh.f) // _SAMPLE)]
    rough = mean_difference(corner_angles(mesh.v, f), x, f)
    if rough < _POOR or (rough < _HARDLY_CONFORMAL and not is_coarse(mesh, x)):
        return x
    y = match_angles(mesh, x, np.zeros(3), rounds=_ROUNDS, least_gain=_LEAST_GAIN)
    return y if mean_angle_difference(mesh, y) < (1 - _MUCH) * mean_angle_difference(mesh, x) else x


@dataclass(frozen=True, eq=False)
class _Candidate:
    """A map that may be the one."""

    name: str
    x: FloatArray
    certificate: Certificate
    angles: float
    stretch: float

    @property
    def free(self) -> bool:
        """Whether it is certified."""
        return self.certificate.folding_free


class _Ladder:
    """The maps that were tried so far, and the rungs that make others."""

    def __init__(self, mesh: Mesh, operators: Operators, listener: Listener | None) -> None:
        self.mesh, self.listener = mesh, listener
        self.tried: list[_Candidate] = []
        self.rounds: list[Round] = []
        self._metric, self._began = operators, time.perf_counter()

    def nearly(self, few: tuple[int, float]) -> bool:
        """Whether the last map has so few foldings that they are mended where they are."""
        certificate = self.tried[-1].certificate
        return certificate.degree == 1 and certificate.foldings <= max(few[0], few[1] * len(self.mesh.f))

    @cached_property
    def operators(self) -> Operators:
        """Laplacian of intrinsic Delaunay weights, factorised, with the same areas to balance."""
        if self._metric.weights == "delaunay":
            return self._metric
        return replace(build_operators(self.mesh, self._metric.factor.backend, "delaunay"), A=self._metric.A)

    def delaunay(self) -> None:
        """The harmonic map of the intrinsic Delaunay weights."""
        if self._metric.weights != "delaunay":
            x = fix_gauge(self.mesh, harmonic_map(self.mesh, self.operators).last.x, self.operators.A)
            self.add("delaunay", self._settled(x))

    def limbs(self) -> None:
        """The last map, its deep limbs solved again."""
        x = self.tried[-1].x
        depth = -predicted_log_edges(self.mesh.v, self.mesh.f, x, self.operators.factor, self.operators.A)
        if not _DEEP <= depth.max() < np.inf:  # nor a NaN, where positions mean nothing
            return
        for weights in ("delaunay", "mollified"):
            L = self.operators.L if weights == "delaunay" else laplacian(self.mesh.v, self.mesh.f, weights)
            with suppress(FactorisationFailed):
                limbs = solve_limbs(x, L, depth, self.operators.A)
                self.add("limbs", self._settled(limbs.onto_sphere(x)), limbs.stretch)
            if self.nearly(_FEW):
                break

    def middle(self) -> None:
        """The map punctured halfway between the deepest tips, and its deep limbs solved again."""
        face = middle_face(self.mesh.v, self.mesh.f, self.operators.factor)
        start = punctured_start(self.mesh, self.operators, [face])
        x = fix_gauge(self.mesh, harmonic_map(self.mesh, self.operators, start).last.x, self.operators.A)
        self.add("middle", self._settled(x))
        if not self.nearly(_FEW):
            self.limbs()

    def embedding(self) -> None:
        """The most promising maps, mended."""
        nearest = min(self.tried, key=lambda candidate: candidate.angles)
        fewest = min(self.tried, key=lambda candidate: candidate.certificate.foldings)
        for candidate in dict.fromkeys((nearest, fewest)):
            best = self.best()
            if not candidate.free and not (best.free and best.angles < candidate.angles):
                rounded = self._rounded(candidate.x) if candidate.angles < _POOR else None  # poor maps are swept later
                self.add("embedding", mend_locally(self.mesh, candidate.x, relaxed=rounded), candidate.stretch)

    def angles(self) -> None:
        """The best map, brought nearer to the mesh's own angles."""
        best = self.best()
        if not best.free or best.angles < _POOR:
            return
        x = self._swept(best.x)
        if self._difference(x) > (_POOR if is_coarse(self.mesh, x) else _HARDLY_CONFORMAL):
            x = match_angles(self.mesh, x, np.zeros(3), rounds=_ROUNDS, least_gain=_LEAST_GAIN)
        self.add("angles", x, best.stretch)

    def poles(self) -> None:
        """The best map in the gauge that has its deepest tips at the poles."""
        best, operators = self.best(), self.operators
        if log_edges(best.x, self.mesh.f).min() > -_ROUNDED:
            return
        try:
            x, limbs = poles_limbs(self.mesh.v, self.mesh.f, best.x, operators.L, operators.factor, operators.A)
        except FactorisationFailed:
            return
        if not certify_checked(x, self.mesh.f).folding_free:
            x = mend_locally(self.mesh, x)
        self.add("poles", self._swept(x), limbs.stretch)

    def _swept(self, x: FloatArray) -> FloatArray:
        """A map after one sweep of descent on the angle differences."""
        return descend(x, self.mesh.f, AngleLoss(self._source.T), sweeps=1)

    def best(self) -> _Candidate:
        """The map with the least angle differences among those free of foldings."""
        return min(self.tried, key=lambda tried: (not tried.free, tried.angles))

    def _settled(self, x: FloatArray) -> FloatArray:
        """A map without foldings, relaxed where rounding spoils it; any other as it is."""
        rounded = self._rounded(x)
        if not rounded.any() or not certify_checked(x, self.mesh.f).folding_free:
            return x
        return relax_some(self.mesh, x, rounded)

    def _rounded(self, x: FloatArray) -> BoolArray:
        """Vertices whose edges are so short that the rounding of positions spoils their angles."""
        return log_edges(x, self.mesh.f) < -_ROUNDED

    @cached_property
    def _source(self) -> FloatArray:
        """Corner angles of the mesh."""
        return corner_angles(self.mesh.v, self.mesh.f)

    def _difference(self, x: FloatArray) -> float:
        """Mean size of the angle differences, in degrees."""
        return mean_difference(self._source, x, self.mesh.f)

    def add(self, name: str, x: FloatArray, stretch: float = 1.0, certificate: Certificate | None = None) -> None:
        """Judge a map, tell the listener, and put it on record."""
        certificate, angles = certificate or certify_checked(x, self.mesh.f), self._difference(x)
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
