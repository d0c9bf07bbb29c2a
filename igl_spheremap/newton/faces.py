"""Problems that sum an energy over faces: every step keeps the exact sign of each of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ..mesh.arrays import BoolArray, FloatArray, IntArray
from ..mesh.edges import marked, touching
from ..sphere.rows import column_axes, row_crosses, unit_rows, weighted_moment
from ..verify.signs import folded_faces
from .loop import Model, Trial


class FaceEnergy(Protocol):
    """An energy of maps of a mesh to the sphere that is a sum over its faces, infinite for a folded one."""

    @property
    def f(self) -> IntArray:
        """Faces."""

    @property
    def area(self) -> FloatArray:
        """Area of each face; the bound on the growth of its energy is in proportion to it."""

    def by_face(self, x: FloatArray, faces: IntArray | slice = slice(None)) -> FloatArray:
        """Energies of the given faces."""

    def derivatives(self, x: FloatArray, axes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gradient (2, n) and positive semidefinite blocks (6, 2, 2, m) along the vertices' axes (2, 3, n)."""


class VertexTerm(Protocol):
    """A sum over vertices of functions of the single vertex's position."""

    def value(self, x: FloatArray) -> float:
        """Its value."""

    def derivatives(self, x: FloatArray, axes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Gradient (2, n) and positive semidefinite blocks (2, 2, n) along the vertices' axes."""


class FaceProblem:
    """Lower ``energy + terms`` over maps to the sphere.

    Parameters
    ----------
    energy : FaceEnergy
        Keeps faces from folding, as it is infinite for a folded one.
    terms : sequence of VertexTerm
        Added to the energy.
    slack : (m,) float64 array, optional
        Added to each face's energy in the bound on its growth.
    turns : bool
        Whether steps keep their rotation. An energy that rotations do not change only loses by it: vertices move along
        straight lines, which strains turning faces.
    held : (n,) bool array, optional
        Vertices that stay where they are, bit for bit.
    """

    def __init__(
        self,
        energy: FaceEnergy,
        terms: Sequence[VertexTerm] = (),
        *,
        slack: FloatArray | float = 0.0,
        turns: bool = True,
        held: BoolArray | None = None,
    ) -> None:
        self.energy, self._terms, self._slack, self._turns = energy, terms, slack, turns
        self._held = held
        # the last two maps and their energies by face
        self._known: list[tuple[FloatArray, FloatArray]] = []

    def axes(self, x: FloatArray) -> FloatArray:
        """The two directions (2, d, n) in which each vertex moves."""
        return column_axes(x.T)

    def onto(self, points: FloatArray, rows: BoolArray | slice) -> FloatArray:
        """The points of the surface nearest to some rows of a map after a move."""
        return unit_rows(points)

    def folded(self, x: FloatArray, faces: IntArray | slice) -> BoolArray:
        """Whether each of some faces is folded, by exact signs; no map may have such faces."""
        return folded_faces(x, self.energy.f[faces])

    def value(self, x: FloatArray) -> float:
        """Energy and terms of a map."""
        return float(self._by_face(x).sum()) + sum(term.value(x) for term in self._terms)

    def model(self, x: FloatArray) -> Model:
        """Value, gradient and Hessian at a map."""
        axes = self.axes(x)
        at_vertices = None
        if self._held is not None:
            axes[:, :, self._held] = 0  # held vertices do not move
            at_vertices = np.where(self._held, np.eye(2)[:, :, None], 0.0)
        gradient, blocks = self.energy.derivatives(x, axes)
        for term in self._terms:
            slope, curvature = term.derivatives(x, axes)
            gradient = gradient + slope
            if at_vertices is not None:
                curvature = at_vertices + curvature
            at_vertices = curvature
        return Model(self.value(x), axes, gradient, blocks, at_vertices)

    def move(self, x: FloatArray, model: Model, step: FloatArray) -> FloatArray:
        """Displacements of a step along the axes."""
        move = np.einsum("an,ain->ni", step, model.axes)
        if self._turns:
            return move
        return _without_rotation(x, move)

    def accept(self, x: FloatArray, move: FloatArray) -> Trial:
        """The map x + move, with shorter moves of the vertices whose faces fold or gain too much energy.

        So single faces do not shorten the step of all others. If faces are refused after eight halvings of the moves,
        or refusals spread, the step is too long.
        """
        f, before = self.energy.f, self._by_face(x)
        limit = self._limit(before)
        y = self.onto(x + move, slice(None))
        after = self.energy.by_face(y)
        folded = self.folded(y, slice(None))
        refused = folded | ~(after < limit)
        share, most = np.ones(len(x)), 2 * refused.sum() + 10  # with more, refusals spread
        for _ in range(8):
            if not 0 < refused.sum() <= most:
                break
            moved = marked(f[refused], len(x))
            share[moved] /= 2
            y = y.copy()  # `_known` holds energies of the map before
            y[moved] = self.onto(x[moved] + share[moved, None] * move[moved], moved)
            near = np.flatnonzero(touching(f, moved))
            after[near] = self.energy.by_face(y, near)
            refused[near] = self.folded(y, near) | ~(after[near] < limit[near])
        if refused.any():
            return Trial(x, np.inf, folded)
        self._known = [(x, before), (y, after)]
        return Trial(y, self.value(y), folded)

    def _limit(
        self, energies: FloatArray, growth: float = 3.0, of_mean: float = 10.0
    ) -> FloatArray:
        """The energy from which on each face is refused, `growth` times its own plus `of_mean` times the mean.

        A face that is nearly folded must not fold for the gain of all others.
        """
        area, bound = self.energy.area, energies + self._slack
        return growth * bound + of_mean * area * (bound.sum() / area.sum())

    def _by_face(self, x: FloatArray) -> FloatArray:
        """Energies of a map's faces; those of the last two maps are kept."""
        for y, energies in self._known:
            if y is x:
                return energies
        self._known = [(x, self.energy.by_face(x))]
        return self._known[0][1]


def _without_rotation(x: FloatArray, move: FloatArray) -> FloatArray:
    """The move less the rotation nearest to it."""
    inertia = len(x) * np.eye(3) - weighted_moment(np.ones(len(x)), x, x)
    turn = np.linalg.solve(inertia, row_crosses(x, move).sum(axis=0))
    return np.asarray(move - row_crosses(np.broadcast_to(turn, x.shape), x))
