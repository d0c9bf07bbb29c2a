"""A shape, or data over one, described by spherical harmonics."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from ...balance import AREA_PRESERVING
from ...balance.balanced_spherical_map import balanced_spherical_map
from ...draw.markup import table
from ...draw.palette import sequential
from ...draw.shown import Drawing, Shown, place_drawing
from ...errors import MeshError, check_number, check_whole
from ...gate import gate, takes_mesh
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import HALF_DIGITS, FloatArray, IntArray, check_rows, check_values, own_unit
from ...mesh.measure import face_areas, vertex_areas
from ...resampling.locate import locator_of
from ...resampling.transfer import check_map, sphere_mesh
from ...sphere.rows import unit_rows
from . import LARGEST_DEGREE
from .bases import Basis, in_basis
from .basis import blocks, degree_of, expand, power, synthesis, terms
from .rotation import first_order_frames, rotate, skewness


@dataclass(frozen=True, eq=False)
class Expanded:
    """Source of coefficients.

    Attributes
    ----------
    x : (n, 3) float64 array
        The vertices on the sphere, unit rows.
    values : (n, k) float64 array
        Positions or data at the vertices.
    areas : (n,) float64 array
        Of the source at the scale of ``mesh.unit``, a third of the faces around each vertex.
    """

    x: FloatArray
    values: FloatArray
    areas: FloatArray

    def __repr__(self) -> str:
        return f"Expanded({self.values.shape[1]} columns over {len(self.x)} vertices)"


@dataclass(frozen=True, eq=False)
class SphericalHarmonics(Shown):
    """Coefficients in the real orthonormal basis, and their source.

    Y_lm is P_lm(cos theta) times 1 for m = 0, sqrt(2) cos(m phi) for m > 0 and ``sqrt(2) sin(|m| phi)`` for m < 0. P_lm
    makes exp(i m phi) P_lm orthonormal on the unit sphere and carries no Condon-Shortley phase (-1)^m.

    Attributes
    ----------
    coefficients : ((L + 1)^2, k) float64 array
        Row l*l + l + m belongs to degree l and order m = -l ... l; one column for each coordinate, or each column of
        the data, in their units.
    source : Expanded or None
        The data at the mesh's vertices; None if the coefficients come from a `.coef` file.
    notes : tuple of str
        One on more coefficients than vertices; one on parts of the surface with so little room that an area-preserving
        map would need less than half of the degree.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> x, f = ism.samples.sphere(162)
    >>> shape = ism.shapes.spherical_harmonics(ism.sphere_map(x, f, x), degree=3)
    >>> shape.coefficients.shape, shape.rotated([[0, 1, 0], [-1, 0, 0], [0, 0, 1]]).degree
    ((16, 3), 3)
    """

    _in_words = "SphericalHarmonics, as shapes.spherical_harmonics makes them"

    coefficients: FloatArray
    source: Expanded | None = None
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        known = ""
        if self.source is not None:
            known = f", of {len(self.source.x)} vertices"
        return (
            f"SphericalHarmonics(degree {self.degree}, {self.coefficients.shape[1]} columns{known})"
        )

    def _drawing(self) -> Drawing:
        x, f = sphere_mesh("ico:4")
        if self.coefficients.shape[1] == 3:
            degrees = sorted({min(self.degree, 1), math.isqrt(self.degree), self.degree})
            bodies = [synthesis(self.coefficients[: (ell + 1) ** 2], x) for ell in degrees]
            return place_drawing(
                bodies[::-1],
                f,
                f"The sums up to degree {', '.join(map(str, degrees[::-1]))}. The "
                "same colour is the same point of the sphere.",
            )
        values = self.evaluate(x)[:, 0]
        ramp = sequential("", float(values.min()), float(values.max()))
        low, high = ramp.ends
        return Drawing(
            f"The first column over the sphere, from {low} where it is dark to {high}.",
            (x,),
            (np.eye(3),),
            f,
            ramp.colours(values[f].mean(axis=1)),
            np.empty(0, dtype=np.int64),
        )

    def _figures(self) -> str:
        return table(
            [
                ("degree", f"{self.degree}"),
                ("columns", f"{self.coefficients.shape[1]}"),
                *(("note", note) for note in self.notes),
            ]
        )

    @property
    def degree(self) -> int:
        """The largest degree L."""
        return degree_of(self.coefficients)

    @gate
    def in_basis(self, basis: Basis) -> FloatArray:
        """The coefficients in the order and norm of a program.

        Parameters
        ----------
        basis : {"orthonormal", "spharm-pdm", "ktch", "aics-shparam"}
            "orthonormal": `coefficients`. "spharm-pdm": rows of `.coef` files, of that shape. "ktch": flat, all of x,
            then y, then z, as its `SphericalHarmonicAnalysis` gives them without registration. "aics-shparam": (k, 2,
            L + 1, L + 1), for each column the matrices of cosines and sines.

        Returns
        -------
        float64 array
            The coefficients; a table in docs/shapes.md has the factors.

        Raises
        ------
        ValueError
            If there is no such basis.
        """
        return in_basis(self.coefficients, basis)

    @gate
    def evaluate(self, points: ArrayLike) -> FloatArray:
        """Values at points of the sphere, in the source's units and place.

        Parameters
        ----------
        points : (m, 3) array_like
            Nonzero directions; they are scaled to unit length.

        Returns
        -------
        (m, k) float64 array
            Positions, or data.
        """
        return synthesis(self.coefficients, unit_rows(check_rows(points, name="points")))

    @gate
    def surface(
        self, target: str | SphereMap | tuple[ArrayLike, ArrayLike] = "ico:5"
    ) -> tuple[FloatArray, IntArray]:
        """The surface that the coefficients describe, on a mesh of the sphere.

        Parameters
        ----------
        target : str, SphereMap or (x, f)
            ``ico:K``, an icosahedron whose edges are cut into 2^K parts (default: ``ico:5``); a map, such as the
            source's own; or any mesh of the sphere.

        Returns
        -------
        v : (n, 3) float64 array
            Points of the surface.
        f : (m, 3) int64 array
            Faces.

        Raises
        ------
        MeshError
            If the coefficients are those of data.
        """
        self._require_positions()
        x, f = sphere_mesh(target)
        return self.evaluate(x), f

    @gate
    def error(self) -> FloatArray:
        """Distance of the sum up to each degree from the source.

        Returns
        -------
        (L + 1,) float64 array
            Root mean square over the source's area, in percent of the diagonal of the values' bounding box.

        Raises
        ------
        MeshError
            If the source is not known.
        """
        if (source := self.source) is None:
            raise MeshError(
                "coefficients from a .coef file have no source to compare with; expand the surface anew"
            )
        total = np.zeros(self.degree + 1)
        values, unit = own_unit(source.values)
        coefficients = np.ldexp(self.coefficients, -unit)
        for block in blocks(len(source.x)):
            rest = values[block]
            for ell, part in enumerate(terms(coefficients, source.x[block])):
                rest = rest - part
                total[ell] += source.areas[block] @ (rest**2).sum(axis=1)
        diagonal = np.linalg.norm(np.ptp(values, axis=0))
        return 100 * np.sqrt(total / source.areas.sum()) / diagonal

    @gate
    def power(self) -> FloatArray:
        """Power of each degree, which no rotation of the sphere or of the surface about its centre changes.

        Returns
        -------
        (L + 1,) float64 array
            Sum of the squares of the degree's coefficients, over all columns.
        """
        return power(self.coefficients)

    @gate
    def rotated(self, R: ArrayLike) -> SphericalHarmonics:
        """The shape with its sphere turned; the surface stays where it is.

        Parameters
        ----------
        R : (3, 3) array_like
            A rotation: a point x of the sphere goes to R x.

        Returns
        -------
        SphericalHarmonics
            Coefficients of x -> f(R^-1 x), exactly.

        Raises
        ------
        MeshError
            If `R` is not a rotation.
        """
        R = check_rows(R, 3, "the rotation's rows")
        if not (np.abs(R @ R.T - np.eye(3)).max() < HALF_DIGITS and np.linalg.det(R) > 0):
            raise MeshError(
                "the rotation is not orthogonal with determinant 1; give a (3, 3) rotation matrix"
            )
        source = self.source
        if source is not None:
            source = replace(source, x=source.x @ R.T)
        return SphericalHarmonics(rotate(self.coefficients, R), source, self.notes)

    @gate
    def align(self, template: SphericalHarmonics | None = None) -> AlignedHarmonics:
        """Put sphere and surface into the frame of the first-order ellipsoid, its centre at the origin.

        The longest axis becomes z, the middle one x and the shortest y, on the sphere as on the surface. That leaves
        four rotations. Without a template, third moments over the source's area along the two most skewed axes are made
        positive.

        Parameters
        ----------
        template : SphericalHarmonics, optional
            An aligned shape: the rotation with the nearest coefficients is taken.

        Returns
        -------
        AlignedHarmonics
            The shape, and the accuracy of its frame.

        Raises
        ------
        MeshError
            If the coefficients are those of data or of degree 0, or neither source nor template is known.

        References
        ----------
        Brechbuehler, Gerig, Kuebler 1995, *Parametrization of Closed Surfaces for 3-D Shape Description*.
        """
        for each in filter(None, (self, template)):
            each._require_positions()
            if each.degree < 1:
                raise MeshError("degree 0 is a point and has no axes; expand to degree 1 or more")
        if template is None and self.source is None:
            raise MeshError(
                "coefficients from a .coef file have no source whose moments distinguish front from back; "
                "give a template"
            )
        axes, frames = first_order_frames(self.coefficients)
        choices = [self._in_frame(*frame) for frame in frames]
        skews = np.full((len(choices), 3), np.nan)
        for k, choice in enumerate(choices):
            if choice.source is not None:
                skews[k] = skewness(choice.source.values, choice.source.areas)
        if template is None:
            best = int(np.argmax(skews.sum(axis=1)))
        else:
            n = min(len(self.coefficients), len(template.coefficients))
            like, unit = own_unit(template.coefficients[1:n])
            off = (np.ldexp(choice.coefficients[1:n], -unit) - like for choice in choices)
            best = int(np.argmin(list(map(np.linalg.norm, off))))
        return AlignedHarmonics(choices[best], axes, skews[best], *frames[best])

    def _in_frame(self, surface: FloatArray, sphere: FloatArray) -> SphericalHarmonics:
        """The shape about its centre, surface and sphere rotated."""
        turned = self.rotated(sphere)
        centre = self.coefficients[0] * np.sqrt(0.25 / np.pi)
        coefficients = turned.coefficients @ surface.T
        coefficients[0] = 0
        source = turned.source
        if source is not None:
            source = replace(source, values=(source.values - centre) @ surface.T)
        return SphericalHarmonics(coefficients, source, self.notes)

    def _require_positions(self) -> None:
        """Raise a MeshError if the coefficients are those of data."""
        if self.coefficients.shape[1] != 3:
            raise MeshError(
                f"the coefficients have {self.coefficients.shape[1]} columns where a surface has three; "
                "expand its positions, not data over it"
            )


@dataclass(frozen=True, eq=False)
class AlignedHarmonics:
    """A shape in the frame of its first-order ellipsoid.

    Attributes
    ----------
    harmonics : SphericalHarmonics
        The shape; its degree 1 is diagonal.
    axes : (3,) float64 array
        Half axes of the ellipsoid along x, y and z. If two are almost equal, the frame is ill-determined.
    skew : (3,) float64 array
        Third moments of the source's area along x, y and z over the 3/2 power of the second; near 0 the direction of an
        axis is ill-determined, and a template decides better. NaN if the source is not known.
    surface_rotation, sphere_rotation : (3, 3) float64 arrays
        Rotations of surface (after its centre was moved to the origin) and sphere.
    """

    harmonics: SphericalHarmonics
    axes: FloatArray
    skew: FloatArray
    surface_rotation: FloatArray
    sphere_rotation: FloatArray

    def __repr__(self) -> str:
        axes = ", ".join(f"{axis:.3g}" for axis in self.axes)
        return f"AlignedHarmonics(degree {self.harmonics.degree}, half axes {axes} along x, y, z)"


def check_degree(degree: int) -> None:
    """Raise a ValueError for a degree out of range."""
    if check_whole(degree, "degree") > LARGEST_DEGREE:
        raise ValueError(f"degree is {degree}; give a whole number from 0 to {LARGEST_DEGREE}")


@gate
def spherical_harmonics(
    source: SphereMap, values: ArrayLike | None = None, *, degree: int = 15, oversampling: float = 4
) -> SphericalHarmonics:
    """Expand a mapped surface, or data over it, in spherical harmonics.

    The piecewise linear function on the sphere is sampled on a Gauss grid and integrated by a rule that is exact for
    the degrees that the grid resolves. On conformal maps limbs take next to no room, and low degrees miss them: expand
    an area-preserving map of such shapes.

    Parameters
    ----------
    source : SphereMap
        The surface and its map.
    values : (n,) or (n, k) array_like, optional
        Data at the vertices; the positions by default.
    degree : int
        The largest degree L, at most 1,000; 15 by default.
    oversampling : float
        Rows of the grid as a factor of the degree, at least 1. At 4, the default, coefficients are within some 1e-4 of
        the exact integrals of the piecewise linear function, relatively; the error falls with the square.

    Returns
    -------
    SphericalHarmonics
        Coefficients with their methods.

    Raises
    ------
    MeshError
        If there is not one finite value for each vertex.
    FoldingsRemain
        If the map is not certified folding-free.
    ValueError
        If `degree` or `oversampling` is out of range.
    TypeError
        If the source is not a map.

    References
    ----------
    Brechbuehler, Gerig, Kuebler 1995, *Parametrization of Closed Surfaces for 3-D Shape Description*.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> source = ism.spherical_conformal_map(*ism.samples.make("pear", n_vertices=1000))
    >>> shape = ism.shapes.spherical_harmonics(source, degree=8)
    >>> shape.coefficients.shape, shape.error()[[1, 2, 4, 8]].round(1).tolist()
    ((81, 3), [2.8, 2.6, 0.7, 0.1])
    """
    check_degree(degree)
    check_number(oversampling, "oversampling", 1)
    check_map(source)
    if values is None:
        values = source.vertices
    data = check_values(values, len(source.vertices))
    coefficients = expand(locator_of(source), data, int(degree), oversampling)
    areas = vertex_areas(source.mesh.unit, source.faces)
    return SphericalHarmonics(
        coefficients, Expanded(source.sphere, data, areas), _notes(source, int(degree))
    )


def _notes(source: SphereMap, degree: int, crowded: float = 4.0) -> tuple[str, ...]:
    """Notes on degrees that the vertices don't resolve, and on parts to which the map gives too little room.

    At a quarter of the area lengths are half as long, and half of the degrees are resolved.
    """
    n, notes = len(source.vertices), []
    if (degree + 1) ** 2 > n:
        notes.append(
            f"degree {degree} has {(degree + 1) ** 2} coefficients, but the mesh {n} vertices, which carry "
            f"degree {math.isqrt(n) - 1}: higher degrees describe flat faces"
        )
    areas = face_areas(source.mesh.unit, source.faces[source.mesh.surface])
    # nan: a face of area 0
    crowding = float(np.nansum(areas * np.exp(-source.log_area_ratios())) / areas.sum())
    if degree and crowding > crowded:
        notes.append(
            "the map leaves parts of the surface so little room that an area-preserving one needs less than "
            f"half of degree {degree}: expand one of balance 1"
        )
    return tuple(notes)


@takes_mesh
def coefficients_from_mesh(
    v: ArrayLike,
    f: ArrayLike,
    degree: int,
    *,
    basis: Basis = "orthonormal",
    balance: float = AREA_PRESERVING,
) -> FloatArray:
    """Map a closed surface to the sphere, certify the map, and expand the surface in spherical harmonics.

    Bodies need not be star-shaped. The notes of `spherical_harmonics` are Python warnings here.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions, any units.
    f : (m, 3) array_like
        Faces as 0-based vertex indices: closed, oriented, connected, genus 0.
    degree : int
        The largest degree L, at most 1,000.
    basis : {"orthonormal", "spharm-pdm", "ktch", "aics-shparam"}
        Order, norm and shape of the coefficients, see `SphericalHarmonics.in_basis`; by default ((L + 1)^2, 3) in
        this package's basis.
    balance : float
        Of the map, see `balanced_spherical_map`: 1, area-preserving, by default, which serves limbs; 0 is conformal.

    Returns
    -------
    float64 array
        Coefficients of the positions, in the units of `v`.

    Raises
    ------
    MeshError
        If the mesh is invalid.
    ValueError
        If `degree`, `basis` or `balance` is out of range.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> mesh = ism.samples.make("pear", n_vertices=500)
    >>> ism.shapes.coefficients_from_mesh(*mesh, 8).shape
    (81, 3)
    >>> ism.shapes.coefficients_from_mesh(*mesh, 8, basis="aics-shparam").shape  # coordinate, cosines or sines, l, m
    (3, 2, 9, 9)
    """
    in_basis(np.zeros((1, 3)), basis)  # a wrong name is refused before the work
    check_degree(degree)
    shape = spherical_harmonics(balanced_spherical_map(v, f, balance=balance), degree=degree)
    for note in shape.notes:
        warnings.warn(note, stacklevel=3)  # names the line of the caller, outside of the gate
    return shape.in_basis(basis)
