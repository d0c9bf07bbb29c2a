"""Conformal map of a punctured surface to the plane by one Laplace-Beltrami solve: the field of a dipole."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..mesh.check import Mesh
from ..operators.factor import refined_solve
from ..operators.operators import Operators

ComplexArray = NDArray[np.complex128]

#: Of the solve, where the factor is only approximate.
_ACCURACY = 1e-8


def dipole_map(mesh: Mesh, operators: Operators, face: int) -> ComplexArray:
    """Map a mesh to the plane with a pole inside one face.

    With a local coordinate w about the puncture, z = 1 / w solves ``Laplace z = 2 pi (d/dx - i d/dy) delta``.
    Tested with the hat function of a corner, the right-hand side is that function's gradient in the face.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    operators : Operators
        Its factorised Laplacian.
    face : int
        The punctured face.

    Returns
    -------
    (n,) complex128 array
        Positions, up to a similarity; orientation is kept, as seen from outside.

    References
    ----------
    Angenent, Haker, Tannenbaum, Kikinis 1999, *On the Laplace-Beltrami operator and brain surface flattening*
    (reference [11] of Lai et al.).
    """
    corners = mesh.f[face]
    w = _in_its_plane(mesh.v[corners])
    opposite = np.roll(w, -2) - np.roll(w, -1)
    gradients = 1j * opposite / (2 * _area(w))  # of the hat functions: opposite edge, turned inwards
    load = np.zeros((len(mesh.v), 2))
    load[corners] = np.column_stack((gradients.real, -gradients.imag))
    z = refined_solve(operators.P, operators.factor, load, _ACCURACY)
    return np.asarray(z[:, 0] + 1j * z[:, 1])


def _in_its_plane(corners: NDArray[np.float64]) -> ComplexArray:
    """A triangle in its own plane, as seen from outside."""
    p, q = corners[1] - corners[0], corners[2] - corners[0]
    side = np.linalg.norm(p)
    along = p @ q / side
    return np.array([0, side, along + 1j * np.sqrt(max(q @ q - along**2, 0.0))])


def _area(w: ComplexArray) -> float:
    return float(((w[1] - w[0]).conj() * (w[2] - w[0])).imag / 2)
