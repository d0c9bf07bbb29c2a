"""p-harmonic maps, Remark 1 and eq. (8)."""

from __future__ import annotations

from dataclasses import replace

from numpy.typing import ArrayLike

from ..descent.problem import p_harmonic_problem
from ..errors import own_errstate
from ..mesh.check import check_mesh
from ..mesh.timings import timed
from ..result.run import History, Listener
from ..result.sphere_map import SphereMap
from .methods import descend, start_of
from .options import PHarmonic


@own_errstate
@timed()
def p_harmonic_map(
    v: ArrayLike,
    f: ArrayLike,
    p: float,
    start: ArrayLike | None = None,
    *,
    may_fold: bool = False,
    gradient_tolerance: float = 1e-3,
    max_iterations: int = 5000,
    plateau: float = 5e-7,
    listener: Listener | None = None,
) -> SphereMap:
    """Minimise the p-harmonic energy of equation (8) by Algorithm 1.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions.
    f : (m, 3) array_like
        Faces as 0-based vertex indices.
    p : float
        Exponent above 1. At 2 the map is the harmonic one. Larger exponents punish stretching where it is
        largest: limbs gain room, and angles are lost. Up to 2 the Moebius gauge is fixed as for harmonic
        maps; above, the energy itself keeps the map spread out.
    start : (n, 3) array_like, optional
        Start; rows are scaled to unit length. The conformal map by default.
    may_fold : bool
        Take steps that fold faces, too. By default a start without foldings is kept free of them.
    gradient_tolerance : float
        L2 norm of the tangential gradient at which the run ends, the source having unit area.
    max_iterations : int
        Maximum number of iterations.
    plateau : float
        The run ends, too, when the lowest energy fell by less than this share over 100 iterations.
    listener : callable, optional
        Called with every `Iterate`, whose energy is the p-harmonic one.

    Returns
    -------
    SphereMap
        Its ``energy`` is the harmonic one; ``history`` has the p-harmonic energies; ``rounds`` has the
        foldings before and after.

    Raises
    ------
    MeshError
        If the mesh is invalid or `start` has not one finite, nonzero row per vertex.
    ValueError
        If p is not above 1.

    References
    ----------
    Lai et al., Remark 1 and eq. (8).

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=500)
    >>> result = ism.p_harmonic_map(v, f, 4)
    >>> bool(result.conformal_factor().std() < ism.spherical_conformal_map(v, f).conformal_factor().std())
    True
    """
    options = PHarmonic(may_fold, gradient_tolerance, max_iterations, plateau, p)
    history = History(listener)
    mesh = check_mesh(v, f)
    found = descend(mesh, p_harmonic_problem(mesh, p), *start_of(mesh, start), options, history)
    return replace(found, run=history.complete(found.run, options.name, options.settings()))
