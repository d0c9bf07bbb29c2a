"""Rotations of functions on the sphere, exactly, degree by degree; best agreement of two functions; frames."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh_tridiagonal
from scipy.spatial.transform import Rotation

from ...mesh.arrays import TINY, ComplexArray, FloatArray, own_unit
from .basis import degree_of, rows_of

_FLIPS = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])  # of axes, of determinant 1


class RotationCandidate(NamedTuple):
    """A rotation R that makes source(R^-1 x) like target(x), and the correlation there.

    Attributes
    ----------
    rotation : (3, 3) float64 array
        Takes x on the source's sphere to R x.
    correlation : float
        Of all features together, at most 1.
    """

    rotation: FloatArray
    correlation: float

    def __repr__(self) -> str:
        return f"RotationCandidate(by {rotation_angle(self.rotation):.1f} degrees, correlation {self.correlation:.3f})"


def to_complex(rows: FloatArray) -> ComplexArray:
    """One degree's real coefficients (2 l + 1, k) in the complex basis of physics, with the phase (-1)^m."""
    ell = len(rows) // 2
    sign = (-1.0) ** np.arange(1, ell + 1)[:, None]
    positive = sign * (rows[ell + 1 :] - 1j * rows[:ell][::-1]) / np.sqrt(2)
    return np.concatenate(((sign * positive.conj())[::-1], rows[ell : ell + 1], positive))


def from_complex(rows: ComplexArray) -> FloatArray:
    """The inverse of `to_complex`."""
    ell = len(rows) // 2
    positive = (-1.0) ** np.arange(1, ell + 1)[:, None] * rows[ell + 1 :] * np.sqrt(2)
    return np.concatenate((-positive.imag[::-1], rows[ell : ell + 1].real, positive.real))


def ladder(ell: int) -> FloatArray:
    """Return the entries beside the diagonal of J_x in degree l; above the diagonal they are those of -i J_y."""
    m = np.arange(-ell, ell)
    return 0.5 * np.sqrt(ell * (ell + 1) - m * (m + 1))


@lru_cache(maxsize=256)  # degrees: each is needed several times in a run
def spin(ell: int) -> FloatArray:
    """Compute the eigenvectors of J_x, in columns by eigenvalue -l ... l."""
    if ell == 0:
        return np.ones((1, 1))
    return eigh_tridiagonal(np.zeros(2 * ell + 1), ladder(ell))[1]


def spin_phase(ell: int) -> ComplexArray:
    """Return (-i)^m for m = -l ... l, the diagonal matrix that turns J_x into J_y."""
    return np.asarray((-1j) ** (np.arange(-ell, ell + 1) % 4))


def angular_momentum(rows: ComplexArray, steps: FloatArray) -> ComplexArray:
    """Apply J_x, J_y and J_z to complex coefficients (..., 2 l + 1, k), stacked in front; `steps` is `ladder`."""
    ell = rows.shape[-2] // 2
    raised, lowered = np.zeros_like(rows), np.zeros_like(rows)
    raised[..., 1:, :] = steps[..., None] * rows[..., :-1, :]
    lowered[..., :-1, :] = steps[..., None] * rows[..., 1:, :]
    return np.stack(
        (lowered + raised, 1j * (lowered - raised), np.arange(-ell, ell + 1)[:, None] * rows)
    )


def rotate_complex(rows: ComplexArray, R: FloatArray, U: FloatArray) -> ComplexArray:
    """Complex coefficients (..., 2 l + 1, k) of x -> f(R^-1 x): Wigner's D times `rows`; U holds the `spin`."""
    ell = rows.shape[-2] // 2
    alpha, beta, gamma = euler_angles(R)
    turn = -1j * np.arange(-ell, ell + 1)[:, None]
    phase = spin_phase(ell)[:, None]
    rows = np.swapaxes(U, -1, -2) @ (phase.conj() * np.exp(gamma * turn) * rows)
    # shapes (5)
    return np.exp(alpha * turn) * phase * (U @ (np.exp(beta * turn) * rows))


def rotate(c: FloatArray, R: FloatArray) -> FloatArray:
    """Coefficients ((L + 1)^2, k) of x -> f(R^-1 x)."""
    turned = (
        rotate_complex(to_complex(c[rows_of(ell)]), R, spin(ell)) for ell in range(degree_of(c) + 1)
    )
    return np.concatenate([from_complex(rows) for rows in turned])


def euler_angles(R: FloatArray) -> tuple[float, float, float]:
    """Angles for which R is R_z(alpha) R_y(beta) R_z(gamma); if R keeps or reverses the z axis, alpha is 0.

    If beta is within 1e-7 of 0 or pi, scipy's own warn and give up gamma.
    """
    alpha = np.arctan2(R[1, 2], R[0, 2])
    beta = np.arctan2(np.hypot(R[0, 2], R[1, 2]), R[2, 2])
    # The second row of R_z(-alpha) R: if rounding decides alpha, gamma fits it.
    sin_cos = np.cos(alpha) * R[1, :2] - np.sin(alpha) * R[0, :2]
    return alpha, beta, np.arctan2(*sin_cos)


def best_rotations(
    target: FloatArray, source: FloatArray, band: int, most: int = 4, same: float = 3.0
) -> list[RotationCandidate]:
    """Local maxima of the correlation of two functions' coefficients ((L + 1)^2, k), degrees 1 ... band - 1, by value.

    The correlation is that of all columns together. An ellipsoid fits itself in four ways: as many maxima are refined.
    Up to `same` degrees from each other they are one.
    """
    f, g = padded(target, band), padded(source, band)
    size = np.sqrt(np.vdot(f, f).real * np.vdot(g, g).real)
    refined = [_refine(f, g, R) for R in _peaks(on_grid(f, g), most)]
    refined.sort(key=lambda candidate: -candidate.correlation)
    kept: list[RotationCandidate] = []
    for R, value in refined:
        if all(rotation_angle(R @ other.rotation.T) > same for other in kept):
            kept.append(RotationCandidate(R, value / size))
    return kept


def padded(c: FloatArray, band: int) -> ComplexArray:
    """Complex coefficients (degrees 1 ... band - 1, orders -(band - 1) ... band - 1, k), zero where there is none."""
    rows = np.zeros((band - 1, 2 * band - 1, c.shape[1]), dtype=complex)
    for ell in range(1, band):
        rows[ell - 1, band - 1 - ell : band + ell] = to_complex(c[rows_of(ell)])
    return rows


@lru_cache(maxsize=4)
def _padded_spins(band: int) -> tuple[FloatArray, FloatArray]:
    """Lay `spin` and `ladder` of the degrees 1 ... band - 1 out as `padded` lays coefficients out."""
    U, steps = np.zeros((band - 1, 2 * band - 1, 2 * band - 1)), np.zeros((band - 1, 2 * band - 2))
    for ell in range(1, band):
        inside = slice(band - 1 - ell, band + ell)
        U[ell - 1, inside, inside] = spin(ell)
        steps[ell - 1, band - 1 - ell : band - 1 + ell] = ladder(ell)
    return U, steps


def rotation_angle(R: FloatArray) -> float:
    """Angle of a rotation, in degrees."""
    return float(np.degrees(Rotation.from_matrix(R).magnitude()))


def on_grid(f: ComplexArray, g: ComplexArray) -> FloatArray:
    """Correlation at R_z(a) R_y(b) R_z(c), angles in steps of pi / band, by one Fourier transform.

    D is written by eigenvectors of J_x, so that its three angles are phases (Risbo 1996; Kostelec and Rockmore 2008).
    """
    band = len(f) + 1
    phase, (spins, _) = spin_phase(band - 1), _padded_spins(band)
    spectrum = np.zeros((2 * band,) * 3, dtype=complex)  # frequencies from -band
    for ell in range(1, band):
        inside = slice(band - 1 - ell, band + ell)
        a, b, U = f[ell - 1, inside], g[ell - 1, inside], spins[ell - 1, inside, inside]
        pairs = (phase[inside, None] * a.conj()) @ (phase.conj()[inside, None] * b).T
        low = slice(band - ell, band + ell + 1)
        spectrum[low, low, low] += pairs[:, None] * (U[:, :, None] * U.T)  # shapes (7)
    return np.fft.fftn(np.fft.ifftshift(spectrum)).real


def _peaks(values: FloatArray, count: int, apart: float = 15.0) -> list[FloatArray]:
    """Rotations at the highest local maxima of the grid, some degrees from each other: less than a peak's width."""
    band = len(values) // 2
    half = values[:, : band + 1]  # beta in [0, pi]; the rest are the same rotations again
    top = np.ones(half.shape, dtype=bool)
    for shift in np.ndindex(3, 3, 3):
        top &= half >= np.roll(values, np.subtract(shift, 1), axis=(0, 1, 2))[:, : band + 1]
    places = np.argwhere(top)
    found: list[FloatArray] = []
    for place in places[np.argsort(-half[top], kind="stable")]:
        R = Rotation.from_euler("ZYZ", np.pi / band * place).as_matrix()
        if all(rotation_angle(R @ other.T) > apart for other in found):
            found.append(R)
            if len(found) == count:
                break
    return found


def _refine(
    f: ComplexArray,
    g: ComplexArray,
    R: FloatArray,
    *,
    steps: int = 20,
    longest: float = 0.1,
    shortest: float = 1e-8,
) -> RotationCandidate:
    """Newton's method for the maximum of sum f* D(exp(w) R) g near w = 0; the value is not normalised.

    Steps are at most as long as the grid is fine. Three to six lead to the shortest, whose square is the remaining
    error.
    """
    U, rungs = _padded_spins(len(f) + 1)
    left = angular_momentum(f, rungs).conj()
    for _ in range(steps):
        right = angular_momentum(rotate_complex(g, R, U), rungs)
        gradient = np.einsum("lmk,ilmk->i", f.conj(), right).imag
        hessian = -np.einsum("ilmk,jlmk->ij", left, right).real
        curvature, axes = np.linalg.eigh(-(hessian + hessian.T) / 2)
        # uphill along every axis, along flat ones not far
        curvature = np.maximum(np.abs(curvature), 1e-3 * np.abs(curvature).max())
        step = axes @ ((axes.T @ gradient) / curvature)
        length = float(np.linalg.norm(step))
        share = min(1.0, longest / max(length, TINY))
        R = Rotation.from_rotvec(step * share).as_matrix() @ R
        if length < shortest:
            break
    return RotationCandidate(R, float(np.vdot(f, rotate_complex(g, R, U)).real))


def first_order_frames(c: FloatArray) -> tuple[FloatArray, list[tuple[FloatArray, FloatArray]]]:
    """Half axes along x (middle), y (shortest), z (longest), and pairs of rotations of surface and sphere."""
    # the point x of the sphere goes to M x: rows are m = -1, 0, 1 (y, z, x)
    M = np.sqrt(0.75 / np.pi) * c[[3, 1, 2]].T
    U, sizes, Vt = np.linalg.svd(M)
    order = [1, 2, 0]
    surface, sphere = U.T[order], Vt[order]
    # A rotation each: of an ellipsoid turned inside out the shortest axis is mirrored.
    surface[1] *= np.linalg.det(surface)
    sphere[1] *= np.linalg.det(sphere)
    return sizes[order], [(flip[:, None] * surface, flip[:, None] * sphere) for flip in _FLIPS]


def skewness(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Third central moments of the columns over the 3/2 power of the second."""
    w = weights / weights.sum()
    offset = own_unit(values - w @ values)[0]
    return w @ offset**3 / (w @ offset**2) ** 1.5
