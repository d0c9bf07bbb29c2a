"""The harmonic energy of eq. (6)."""

from __future__ import annotations

from dataclasses import dataclass

import scipy.sparse as sp
from numpy.typing import ArrayLike

from ...errors import own_errstate
from ...mesh.arrays import FloatArray, check_rows
from ...mesh.check import Mesh, check_mesh
from ...operators.laplacian import Weights, apply, usable_laplacian
from ...sphere.rows import inner


@dataclass(frozen=True, eq=False)
class HarmonicEnergy:
    """The harmonic (Dirichlet) energy: half the sum of x_k . L x_k over the three coordinates."""

    L: sp.csr_matrix

    @classmethod
    def of(cls, mesh: Mesh, weights: Weights = "cotangent") -> HarmonicEnergy:
        """The energy of a mesh, with mollified weights where those are unusable."""
        return cls(usable_laplacian(mesh, weights))

    def evaluate(self, x: FloatArray) -> tuple[float, FloatArray]:
        """Value and derivatives, L x."""
        gradient = apply(self.L, x)
        return 0.5 * inner(x, gradient), gradient  # eq. (6)


@own_errstate
def harmonic_energy(v: ArrayLike, f: ArrayLike, x: ArrayLike) -> float:
    """Harmonic energy of a map, equation (6).

    Parameters
    ----------
    v : (n, 3) array_like
        Source positions; the energy does not depend on their scale.
    f : (m, 3) array_like
        Faces as 0-based vertex indices.
    x : (n, 3) array_like
        Images of the vertices.

    Returns
    -------
    float
        4 pi for a smooth conformal map; at least the flat area of the image, with equality face by face where
        angles are kept.

    Raises
    ------
    MeshError
        If `v, f` is no closed genus-0 mesh or `x` has not one row per vertex.

    References
    ----------
    Lai et al., eq. (6).

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> x = [[1, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]]
    >>> f = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
    >>> round(ism.harmonic_energy(x, f, x) - 4 * 3**0.5, 12)  # the area, for the identity
    0.0
    """
    mesh = check_mesh(v, f)
    return HarmonicEnergy.of(mesh).evaluate(check_rows(x, len(mesh.v), "images"))[0]
