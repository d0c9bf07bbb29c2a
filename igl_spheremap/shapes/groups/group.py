"""The record of a group of surfaces: its template, mean, modes and members."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...balance import AREA_PRESERVING
from ...draw.markup import table
from ...draw.palette import round_up, sizes
from ...draw.plot import pose
from ...draw.shown import Drawing, Shown
from ...gate import gate
from ...maps.given_sphere import certified
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray, own_unit, real_array
from ...mesh.check import check_mesh
from ...resampling.transfer import check_map, resample
from .doubts import member_doubts
from .member_registration import register_with_restarts
from .modes import ModelFigures, model_figures
from .procrustes import fitted
from .sampling import at_points, carried, check_member


@dataclass(frozen=True, eq=False)
class Member:
    """A surface in a group.

    Attributes
    ----------
    name : str
        The file that it came from, or its number among the sources.
    map : SphereMap or None
        The surface with its map in the template's frame, certified free of foldings; if it lies in the folder of the
        group, None.
    correlation : float
        Of its depth potential with the template's, at corresponding points; from -1 to 1.
    size : float
        Its size over the geometric mean of all members' sizes, a ratio; if only rigid motions were taken away, 1.
    distance : float
        Root mean square distance from the mean surface at corresponding points, over the area, in the members' units.
    doubts : tuple of str
        Reasons to doubt its position, with remedies; empty for most.
    """

    name: str
    map: SphereMap | None
    correlation: float
    size: float
    distance: float
    doubts: tuple[str, ...] = ()

    def __repr__(self) -> str:
        doubtful = ""
        if self.doubts:
            doubtful = ", doubtful"
        return f"Member({self.name!r}, correlation {self.correlation:.3f}, {self.distance:.3g} from the mean{doubtful})"


@dataclass(frozen=True, eq=False)
class Group(Shown):
    """Surfaces in correspondence, their mean and modes.

    Attributes
    ----------
    vertices : (n, 3) float64 array
        The mean surface, in the members' units, mean place and mean pose.
    faces : (m, 3) int64 array
        Its faces, those of an icosphere.
    sphere : (n, 3) float64 array
        The icosphere's points: the members' maps take corresponding points there.
    shapes : (members, n, 3) float64 array
        The corresponding points of the members, after generalised Procrustes, in the members' units.
    modes : (k, n, 3) float64 array
        Principal components of the shapes: displacements of mean square 1 over the area, without unit.
    variances : (k,) float64 array
        Variances of the scores, the largest first, in the square of the members' units.
    scores : (members, k) float64 array
        Coordinate of each member in each mode, in the members' units.
    members : tuple of Member
        In the order of the sources.
    areas : (n,) float64 array
        The members' own area around each point, on average, in the square of the members' units. The mean surface has
        less: averaging smooths folds away.
    spread : (n,) float64 array
        Standard deviation of position at each point, in the members' units: the root of the variance of all three
        coordinates together.
    features : (members, n, k) float64 array
        The members' features at corresponding points, in their units; k is 0 without them.
    left_out : mapping of str to str
        Names of sources that are not in the group, and why.
    changes : tuple of float
        Movement of the mean surface in each round, as a share of its root mean square radius.
    rigid : bool
        Whether members kept their sizes.
    balance : float
        Balance of the members' maps that were made for the group: 0 is conformal, 1 preserves areas.
    feature_names : tuple of str
        Names of the features; empty if they have none.
    notes : tuple of str
        Reasons to doubt the mean: it did not settle, or the bodies are symmetric, or of two kinds.
    """

    _in_words = "a Group, as shapes.template makes one"

    vertices: FloatArray
    faces: IntArray
    sphere: FloatArray
    shapes: FloatArray
    modes: FloatArray
    variances: FloatArray
    scores: FloatArray
    members: tuple[Member, ...]
    areas: FloatArray
    spread: FloatArray
    features: FloatArray
    left_out: Mapping[str, str]
    changes: tuple[float, ...]
    rigid: bool = False
    balance: float = AREA_PRESERVING
    feature_names: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        out = ""
        if self.left_out:
            out = f", {len(self.left_out)} left out"
        return (
            f"Group({len(self.members)} members{out}, {len(self.vertices)} vertices, {len(self.modes)} modes with "
            f"{self.compactness[-1]:.0%} of the variance)"
        )

    def _drawing(self) -> Drawing:
        ramp = sizes("", round_up(float(np.percentile(self.spread, 95))))
        colours = ramp.colours(self.spread[self.faces].mean(axis=1))
        ends = 2 * np.sqrt(self.variances[:1])
        bodies, between = [self.vertices], ""
        if len(ends):
            bodies = [self.shape(-ends), self.vertices, self.shape(ends)]
            between = ", between the first mode at two standard deviations below and above"
        caption = (
            f"The mean surface{between}. Members spread least where it is yellow, {ramp.ends[1]} or more where "
            "it is blue."
        )
        return Drawing(
            caption,
            bodies,
            [pose(self.vertices)] * len(bodies),
            self.faces,
            colours,
            np.empty(0, dtype=np.int64),
        )

    def _figures(self) -> str:
        """The members, the farthest from the mean first."""
        rows = [
            (each.name, f"{each.distance:.4g}", f"{each.size:.3f}", f"{each.correlation:.3f}")
            for each in sorted(self.members, key=lambda member: -member.distance)
        ]
        return table(rows, ("member", "distance from the mean", "size", "correlation"))

    @property
    def map(self) -> SphereMap:
        """The mean surface with its sphere, as a `SphereMap`."""
        return certified(check_mesh(self.vertices, self.faces), self.sphere)

    @property
    def compactness(self) -> FloatArray:
        """Share of the variance that the first 1, 2, ... modes hold."""
        return np.cumsum(self.variances) / (self._weights @ self.spread**2)

    @property
    def feature_mean(self) -> FloatArray:
        """Mean of the members' features, (n, k)."""
        return self.features.mean(axis=0)

    @property
    def feature_sd(self) -> FloatArray:
        """Standard deviation of the members' features, (n, k)."""
        own, power = own_unit(self.features)
        return np.ldexp(own.std(axis=0, ddof=1), power)

    @property
    def _weights(self) -> FloatArray:
        return self.areas / self.areas.sum()

    def figures(self) -> ModelFigures:
        """Compactness, generalisation and specificity of the modes.

        Returns
        -------
        ModelFigures
            One figure for each number of modes. Correspondences stay as they are: only modes are computed anew.
        """
        return model_figures(self.shapes - self.vertices, self.areas, len(self.modes))

    @gate
    def shape(self, scores: ArrayLike) -> FloatArray:
        """The surface that has the given scores.

        Parameters
        ----------
        scores : (j,) array_like
            Scores of the first j modes; those of the others are 0. ``2 * np.sqrt(group.variances[:1])`` is the first
            mode at two standard deviations.

        Returns
        -------
        (n, 3) float64 array
            Vertices for the group's faces.

        Raises
        ------
        ValueError
            If there are more scores than modes.
        """
        given = real_array(scores, "scores").astype(np.float64).reshape(-1)
        if len(given) > len(self.modes):
            raise ValueError(
                f"{len(given)} scores for {len(self.modes)} modes; give at most one for each"
            )
        return self.vertices + np.tensordot(given, self.modes[: len(given)], 1)

    @gate
    def place(self, source: SphereMap) -> PlacedMember:
        """Register a new surface to the group, and compute its scores; the group stays as it is.

        Parameters
        ----------
        source : SphereMap
            The surface with its map, of the balance that the members have.

        Returns
        -------
        PlacedMember
            The member that it would be, its corresponding points, and its scores.

        Raises
        ------
        FoldingsRemain
            If the map is not certified folding-free.
        MeshError
            If its coordinates are above 1e48, or its extent is below 1e-48.
        """
        check_member(check_map(source, "source"))
        coarse = at_points(source, self.sphere, self.faces)
        found = register_with_restarts(coarse, self.map)
        onto = carried(source, coarse, found.sphere)
        points = resample(onto, (self.sphere, self.faces)).v
        size = None
        if self.rigid:
            size = 1.0
        shape, size = fitted(points, self.vertices, self.areas, size)
        away = shape - self.vertices
        scores = np.einsum("n,nd,knd->k", self._weights, away, self.modes)
        distance = float(np.sqrt(self._weights @ (away**2).sum(axis=1)))
        distances, correlations = np.array(
            [[each.distance, each.correlation] for each in self.members]
        ).T
        said = member_doubts(found, distance, distances, correlations)
        return PlacedMember(
            Member("", onto, found.correlation, size, distance, said), shape, scores
        )


@dataclass(frozen=True, eq=False)
class PlacedMember:
    """A new surface in a group that it did not take part in.

    Attributes
    ----------
    member : Member
        As those of the group.
    shape : (n, 3) float64 array
        Its points that correspond to the group's vertices, fitted to the mean surface, in the members' units.
    scores : (k,) float64 array
        Its coordinate in each mode, in the members' units.
    """

    member: Member
    shape: FloatArray
    scores: FloatArray

    def __repr__(self) -> str:
        return f"PlacedMember({self.member.distance:.3g} from the mean, {len(self.scores)} scores)"
