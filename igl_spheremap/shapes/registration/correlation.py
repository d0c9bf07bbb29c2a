"""The rotations for which two functions on the sphere agree best, by correlation over SO(3)."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ...mesh.arrays import ComplexArray, FloatArray
from ..harmonics.basis import rows_of
from ..harmonics.rotation import angular_momentum, euler_rotation, ladder, rotate_complex, spin, spin_phase, to_complex

_APART = 15.0  # degrees between starts: more than the grid's error, less than the width of a peak
_SAME = 3.0  # degrees between refined rotations that are one peak


class Candidate(NamedTuple):
    """A rotation R for which fixed(x) is like moving(R^-1 x), and the correlation there."""

    rotation: FloatArray
    correlation: float


def best_rotations(fixed: FloatArray, moving: FloatArray, band: int, count: int = 4) -> list[Candidate]:
    """Local maxima of the correlation of two functions' coefficients ((L + 1)^2, k), degrees 1 ... band - 1, by value.

    The correlation is that of all columns together.
    """
    f, g = _padded(fixed, band), _padded(moving, band)
    size = np.sqrt(np.vdot(f, f).real * np.vdot(g, g).real)
    refined = [_refine(f, g, R) for R in _peaks(_on_grid(f, g), count)]
    refined.sort(key=lambda candidate: -candidate.correlation)
    kept: list[Candidate] = []
    for R, value in refined:
        if all(rotation_angle(R @ other.rotation.T) > _SAME for other in kept):
            kept.append(Candidate(R, value / size))
    return kept


def _padded(c: FloatArray, band: int) -> ComplexArray:
    """Complex coefficients (degrees 1 ... band - 1, orders -(band - 1) ... band - 1, k), zero where there is none."""
    rows = np.zeros((band - 1, 2 * band - 1, c.shape[1]), dtype=complex)
    for ell in range(1, band):
        rows[ell - 1, band - 1 - ell : band + ell] = to_complex(c[rows_of(ell)])
    return rows


@lru_cache(maxsize=4)
def _padded_spins(band: int) -> tuple[FloatArray, FloatArray]:
    """`spin` and `ladder` of the degrees 1 ... band - 1, laid out likewise."""
    U, beside = np.zeros((band - 1, 2 * band - 1, 2 * band - 1)), np.zeros((band - 1, 2 * band - 2))
    for ell in range(1, band):
        inside = slice(band - 1 - ell, band + ell)
        U[ell - 1, inside, inside] = spin(ell)
        beside[ell - 1, band - 1 - ell : band - 1 + ell] = ladder(ell)
    return U, beside


def rotation_angle(R: FloatArray) -> float:
    """In degrees; precise for small angles, too."""
    axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return float(np.degrees(np.arctan2(np.linalg.norm(axis), np.trace(R) - 1)))


def rotation_about(w: FloatArray) -> FloatArray:
    """Rotation by |w| about w (Rodrigues)."""
    angle = float(np.linalg.norm(w))
    K = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
    return np.eye(3) + np.sinc(angle / np.pi) * K + 0.5 * np.sinc(angle / (2 * np.pi)) ** 2 * K @ K


def _on_grid(f: ComplexArray, g: ComplexArray) -> FloatArray:
    """Correlation at euler_rotation(a, b, c), angles in steps of pi / band, by one Fourier transform.

    D is written by eigenvectors of J_x, so that its three angles are phases (Risbo 1996; Kostelec and Rockmore 2008).
    """
    band = len(f) + 1
    phase, (spins, _) = spin_phase(band - 1), _padded_spins(band)
    spectrum = np.zeros((2 * band,) * 3, dtype=complex)
    for ell in range(1, band):
        inside = slice(band - 1 - ell, band + ell)
        a, b, U = f[ell - 1, inside], g[ell - 1, inside], spins[ell - 1, inside, inside]
        pairs = (phase[inside, None] * a.conj()) @ (phase.conj()[inside, None] * b).T
        where = np.arange(-ell, ell + 1)  # negative frequencies from the end
        spectrum[np.ix_(where, where, where)] += pairs[:, None] * (U[:, :, None] * U.T)
    return np.asarray(np.fft.fftn(spectrum).real)


def _peaks(values: FloatArray, count: int) -> list[FloatArray]:
    """Rotations at the highest local maxima of the grid, `_APART` from each other."""
    band = len(values) // 2
    half = values[:, : band + 1]  # beta in [0, pi]; the rest are the same rotations again
    top = np.ones(half.shape, dtype=bool)
    for shift in np.ndindex(3, 3, 3):
        top &= half >= np.roll(values, np.subtract(shift, 1), axis=(0, 1, 2))[:, : band + 1]
    places = np.argwhere(top)
    found: list[FloatArray] = []
    for place in places[np.argsort(-half[top], kind="stable")]:
        R = euler_rotation(*(np.pi / band * place))
        if all(rotation_angle(R @ other.T) > _APART for other in found):
            found.append(R)
            if len(found) == count:
                break
    return found


def _refine(f: ComplexArray, g: ComplexArray, R: FloatArray) -> Candidate:
    """Newton's method for the maximum of sum f* D(exp(w) R) g near w = 0; the value is not normalised."""
    U, beside = _padded_spins(len(f) + 1)
    left = angular_momentum(f, beside).conj()
    for _ in range(20):
        right = angular_momentum(rotate_complex(g, R, U), beside)
        gradient = np.einsum("lmk,ilmk->i", f.conj(), right).imag
        hessian = -np.einsum("ilmk,jlmk->ij", left, right).real
        curvature, axes = np.linalg.eigh(-(hessian + hessian.T) / 2)
        curvature = np.maximum(np.abs(curvature), 1e-3 * np.abs(curvature).max())  # uphill along every axis
        step = axes @ ((axes.T @ gradient) / curvature)
        length = float(np.linalg.norm(step))
        R = rotation_about(step * min(1.0, 0.1 / max(length, 1e-300))) @ R
        if length < 1e-8:  # the error is its square
            break
    return Candidate(R, float(np.vdot(f, rotate_complex(g, R, U)).real))
