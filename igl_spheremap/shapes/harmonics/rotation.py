"""Rotations of functions on the sphere, exactly, degree by degree."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from scipy.linalg import eigh_tridiagonal

from ...mesh.arrays import ComplexArray, FloatArray
from .basis import degree_of, rows_of


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
    """Entries beside the diagonal of J_x in degree l, and of -i J_y above it."""
    m = np.arange(-ell, ell)
    return 0.5 * np.sqrt(ell * (ell + 1) - m * (m + 1))


@lru_cache(maxsize=256)  # degrees; a run asks for each of them again and again
def spin(ell: int) -> FloatArray:
    """Eigenvectors of J_x, in columns by eigenvalue -l ... l."""
    if ell == 0:
        return np.ones((1, 1))
    return np.asarray(eigh_tridiagonal(np.zeros(2 * ell + 1), ladder(ell))[1])


def spin_phase(ell: int) -> ComplexArray:
    """(-i)^m, which turns J_x into J_y."""
    return np.asarray((-1j) ** (np.arange(-ell, ell + 1) % 4))


def angular_momentum(rows: ComplexArray, beside: FloatArray) -> ComplexArray:
    """J_x, J_y and J_z times complex coefficients (..., 2 l + 1, k), `beside` the diagonal: stacked in front."""
    ell = rows.shape[-2] // 2
    raised, lowered = np.zeros_like(rows), np.zeros_like(rows)
    raised[..., 1:, :] = beside[..., None] * rows[..., :-1, :]
    lowered[..., :-1, :] = beside[..., None] * rows[..., 1:, :]
    return np.stack((lowered + raised, 1j * (lowered - raised), np.arange(-ell, ell + 1)[:, None] * rows))


def turning(c: FloatArray) -> FloatArray:
    """Coefficients (3, (L + 1)^2, k) of x cross grad f: how f changes as x turns about each axis."""
    degrees = (angular_momentum(to_complex(c[rows_of(ell)]), ladder(ell)) for ell in range(degree_of(c) + 1))
    parts = ([from_complex(1j * axis) for axis in axes] for axes in degrees)
    return np.stack([np.concatenate(axis) for axis in zip(*parts, strict=True)])


def rotate_complex(rows: ComplexArray, R: FloatArray, U: FloatArray) -> ComplexArray:
    """Complex coefficients (..., 2 l + 1, k) of x -> f(R^-1 x): Wigner's D times `rows`; U holds the `spin`."""
    ell = rows.shape[-2] // 2
    alpha, beta, gamma = euler_angles(R)
    turn = -1j * np.arange(-ell, ell + 1)[:, None]
    phase = spin_phase(ell)[:, None]
    rows = np.swapaxes(U, -1, -2) @ (phase.conj() * np.exp(gamma * turn) * rows)
    return np.asarray(np.exp(alpha * turn) * phase * (U @ (np.exp(beta * turn) * rows)))


def rotate(c: FloatArray, R: FloatArray) -> FloatArray:
    """Coefficients ((L + 1)^2, k) of x -> f(R^-1 x)."""
    turned = (rotate_complex(to_complex(c[rows_of(ell)]), R, spin(ell)) for ell in range(degree_of(c) + 1))
    return np.concatenate([from_complex(rows) for rows in turned])


def euler_rotation(alpha: float, beta: float, gamma: float) -> FloatArray:
    """R_z(alpha) R_y(beta) R_z(gamma)."""
    (ca, cb, cc), (sa, sb, sc) = np.cos([alpha, beta, gamma]), np.sin([alpha, beta, gamma])
    return np.array([
        [ca * cb * cc - sa * sc, -ca * cb * sc - sa * cc, ca * sb],
        [sa * cb * cc + ca * sc, -sa * cb * sc + ca * cc, sa * sb],
        [-sb * cc, sb * sc, cb],
    ])  # fmt: skip


def euler_angles(R: FloatArray) -> tuple[float, float, float]:
    """The angles of `euler_rotation`; alpha is 0 where the rotation keeps or reverses the z axis."""
    alpha = np.arctan2(R[1, 2], R[0, 2])
    beta = np.arctan2(np.hypot(R[0, 2], R[1, 2]), R[2, 2])
    sin_cos = np.cos(alpha) * R[1, :2] - np.sin(alpha) * R[0, :2]  # of the rest: right even where alpha is rounding
    return alpha, beta, np.arctan2(*sin_cos)
