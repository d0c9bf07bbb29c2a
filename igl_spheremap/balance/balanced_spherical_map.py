"""Maps between conformal and area-preserving."""

from __future__ import annotations

from numpy.typing import ArrayLike

from ..errors import check_number
from ..gate import takes_mesh
from ..maps.options import Method
from ..maps.sphere_map import SphereMap
from ..maps.spherical_conformal_map import spherical_conformal_map
from ..result.run import Listener
from . import ON_SPHERE


@takes_mesh
def balanced_spherical_map(
    v: ArrayLike,
    f: ArrayLike,
    *,
    balance: float = ON_SPHERE,
    method: str | Method = "auto",
    caps: ArrayLike | None = None,
    listener: Listener | None = None,
) -> SphereMap:
    """Map a closed genus-0 surface to the unit sphere, between conformal and area-preserving, and certify the map.

    It aims at image area = source area * (conformal factor)^(1 - balance), with the least angle distortion. Every
    iterate is free of foldings.

    Parameters
    ----------
    v, f : (n, 3) and (m, 3) array_like
        The mesh, as of `check_mesh`.
    balance : float
        0 is conformal, the map of `spherical_conformal_map` bit for bit; 1 preserves areas; at .85, the
        default, lengths are off least.
    method : str or Method
        The method of the conformal map that it starts from, "auto" by default, or a record of options; see
        `spherical_conformal_map`.
    caps : (m,) array_like of bool, optional
        As of `check_mesh`.
    listener : callable, optional
        Called with every `Iterate`, those of the conformal map included; may raise StopIteration to stop with
        the current map.

    Returns
    -------
    SphereMap
        Turned to the Gauss map. Its ``conformal`` is the map that it started from. If its ``log_area_ratios()`` miss
        their target by more than a factor of 1.35 on average, its ``status`` is ``SHORT``; a note gives the factor and
        the end of the steps.

    Raises
    ------
    MeshError
        If `v, f` is not a closed, oriented, connected genus-0 mesh.
    ValueError
        If `balance` is not in [0, 1].
    TypeError
        If it is not a number.
    FoldingsRemain
        If the conformal map has foldings, which "auto" never leaves.

    See Also
    --------
    spherical_conformal_map : keeps angles.
    flatten : a surface with a boundary, to the plane.

    References
    ----------
    The energy and its steps are in docs/balance.md.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=1000)
    >>> result = ism.balanced_spherical_map(v, f, balance=1)
    >>> result.certificate.folding_free, result.status.name, bool(abs(result.log_area_ratios()).mean() < 0.02)
    (True, 'CONVERGED', True)
    """
    check_number(balance, "balance", most=1)
    conformal = spherical_conformal_map(v, f, method=method, caps=caps, listener=listener)
    return conformal.rebalance(balance, listener=listener)
