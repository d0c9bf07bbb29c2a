"""Surfaces of revolution, with their exact conformal map to the sphere."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial

from ..errors import check_number
from ..gate import gate
from ..mesh.arrays import FloatArray, IntArray
from .icosphere import MOST_VERTICES
from .rings import loft


@dataclass(frozen=True)
class SurfaceOfRevolution:
    """The surface ``z = half_length * c``, ``r = radius(c) * sqrt(1 - c**2)``, with c from -1 to 1.

    It is smooth at its poles whenever the polynomial ``radius`` is positive. A spheroid is the case of a
    constant radius.

    Attributes
    ----------
    half_length : float
        Half the distance between the poles.
    radius : tuple of float
        Coefficients of the polynomial in c, from the constant one up.

    References
    ----------
    In isometric latitude u, du/ds = 1/r along the profile, the metric is r^2 (du^2 + dlongitude^2); that of
    the unit sphere is the same with latitude 2*atan(exp(u)) - pi/2. So keeping longitude and u is conformal.

    Examples
    --------
    >>> import numpy as np
    >>> from igl_spheremap.samples import SurfaceOfRevolution
    >>> surface = SurfaceOfRevolution(half_length=2.0)
    >>> v, f = surface.mesh(n_vertices=500)
    >>> x = surface.conformal_map(v)
    >>> bool(np.allclose(np.linalg.norm(x, axis=1), 1.0))
    True
    """

    half_length: float = 1.0
    radius: tuple[float, ...] = (1.0,)

    @gate
    def __post_init__(self) -> None:
        if not (np.isfinite(self.half_length) and self.half_length > 0.0):
            raise ValueError(f"half_length must be positive, not {self.half_length}")
        if not np.all(self._rho(np.linspace(-1.0, 1.0, 1001)) > 0.0):
            raise ValueError(
                f"the radius polynomial {self.radius} is not positive on all of [-1, 1]"
            )

    @gate
    def mesh(self, n_vertices: int = 4000) -> tuple[FloatArray, IntArray]:
        """Near-equilateral triangles with all vertices on the surface.

        Parameters
        ----------
        n_vertices : int
            Approximate number of vertices.

        Returns
        -------
        v : (n, 3) float64 ndarray
        f : (m, 3) int64 ndarray
        """
        colatitude = np.linspace(np.pi, 0.0, 20001)  # arc lengths between are right to 1e-8
        profile = self.embed(
            np.stack([np.sin(colatitude), 0.0 * colatitude, np.cos(colatitude)], axis=1)
        )
        chord = np.linalg.norm(np.diff(profile, axis=0), axis=1)
        arc = np.concatenate([[0.0], np.cumsum(chord)])
        s, angle, f = loft(lambda t: np.interp(t, arc, profile[:, 0]), arc[-1], n_vertices)
        t = np.interp(s, arc, colatitude)
        v = self.embed(
            np.stack([np.sin(t) * np.cos(angle), np.sin(t) * np.sin(angle), np.cos(t)], axis=1)
        )
        return v, f

    @gate
    def embed(self, p: FloatArray) -> FloatArray:
        """Points of the surface for (n, 3) points p of the unit sphere, the same c and longitude."""
        rho = self._rho(p[:, 2])
        return np.stack([rho * p[:, 0], rho * p[:, 1], self.half_length * p[:, 2]], axis=1)

    @gate
    def conformal_map(self, v: FloatArray) -> FloatArray:
        """Exact conformal map of points of the surface to the unit sphere.

        Parameters
        ----------
        v : (n, 3) ndarray
            Points on the surface.

        Returns
        -------
        x : (n, 3) float64 ndarray
            Unit vectors. Longitude is kept; the boost along the axis, which conformality leaves open, is such
            that the surface's area has its barycentre at the origin.
        """
        c = np.clip(v[:, 2] / self.half_length, -1.0, 1.0)
        r = np.hypot(v[:, 0], v[:, 1])
        sine = r / self._rho(c)
        # on the unit sphere exp(u) = (1 + c) / sine = sine / (1 - c): take the one without cancellation
        up, down = np.where(c > 0.0, 1.0 + c, sine), np.where(c > 0.0, sine, 1.0 - c)
        scale = np.exp(0.5 * (self._excess(c) + self._boost))
        up, down = up * scale, down / scale
        square = up * up + down * down
        flat = 2.0 * up * down / square / np.where(r > 0.0, r, 1.0)
        return np.stack([flat * v[:, 0], flat * v[:, 1], (up * up - down * down) / square], axis=1)

    def _rho(self, c: FloatArray) -> FloatArray:
        """The radius polynomial."""
        return Polynomial(self.radius)(c)

    def _stretch(self, c: FloatArray) -> FloatArray:
        """q, where ds = rho * sqrt(1 + (1 - c^2) q) dt along the profile and c = cos t."""
        slope = Polynomial(self.radius).deriv()(c) / self._rho(c)
        return (
            (self.half_length / self._rho(c)) ** 2
            - 1.0
            - 2.0 * c * slope
            + (1.0 - c * c) * slope**2
        )

    @cached_property
    def _excess(self) -> Chebyshev:
        """u(c) - atanh(c): the isometric latitude, less that of the sphere at the same c."""

        def derivative(c: FloatArray) -> FloatArray:
            q = self._stretch(c)
            return q / (1.0 + np.sqrt(1.0 + (1.0 - c * c) * q))

        series = _chebyshev(derivative)
        return series.integ(lbnd=0.0)

    @cached_property
    def _boost(self) -> float:
        """The shift of u that balances the surface's area on the sphere."""
        from scipy.optimize import brentq  # takes .2 s, which only this map needs

        c, weight = np.polynomial.legendre.leggauss(min(self._excess.degree() + 20, 400))
        area = weight * self._rho(c) ** 2 * np.sqrt(1.0 + (1.0 - c * c) * self._stretch(c))
        u = np.arctanh(c) + self._excess(c)
        reach = float(np.abs(u).max()) + 1.0
        return float(brentq(lambda b: area @ np.tanh(u + b), -reach, reach, xtol=1e-15))


def _chebyshev(function: Callable[[FloatArray], FloatArray]) -> Chebyshev:
    """Chebyshev series on [-1, 1]; its degree is doubled until its last coefficients are at rounding level."""
    for degree in (16, 32, 64, 128, 256, 512, 1024):
        series = Chebyshev.interpolate(function, degree)
        size = np.abs(series.coef)
        if size[-degree // 8 :].max() <= 1e-14 * size.max():
            break
    return series


@gate
def spheroid(n_vertices: int = 4000, aspect: float = 2.0) -> tuple[FloatArray, IntArray]:
    """Spheroid about the z axis, ``SurfaceOfRevolution(aspect)``.

    `n_vertices` and the result are those of every sample, see `igl_spheremap.samples`.

    Parameters
    ----------
    aspect : float
        Polar radius, where the equatorial one is 1: a needle when large, a flat pillow when small; 0.02 to 50.
    """
    check_number(n_vertices, "n_vertices", 100, MOST_VERTICES)
    check_number(aspect, "aspect", 0.02, 50)
    return SurfaceOfRevolution(half_length=aspect).mesh(n_vertices)


@gate
def dumbbell(n_vertices: int = 4000, waist: float = 0.3) -> tuple[FloatArray, IntArray]:
    """Two bulbs and a neck, ``SurfaceOfRevolution(2.5, (waist, 0, 2))``.

    `n_vertices` and the result are those of every sample, see `igl_spheremap.samples`.

    Parameters
    ----------
    waist : float
        Radius of the neck, where that of the bulbs is about 0.9; 0.05 to 2.
    """
    check_number(n_vertices, "n_vertices", 300, MOST_VERTICES)
    check_number(waist, "waist", 0.05, 2)
    return SurfaceOfRevolution(half_length=2.5, radius=(waist, 0.0, 2.0)).mesh(n_vertices)


@gate
def pear(n_vertices: int = 4000) -> tuple[FloatArray, IntArray]:
    """Surface with a thick and a thin end, ``SurfaceOfRevolution(1.4, (1, -0.4, 0.1, 0.2))``.

    `n_vertices` and the result are those of every sample, see `igl_spheremap.samples`.
    """
    check_number(n_vertices, "n_vertices", 100, MOST_VERTICES)
    return SurfaceOfRevolution(half_length=1.4, radius=(1.0, -0.4, 0.1, 0.2)).mesh(n_vertices)
