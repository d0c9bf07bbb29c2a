"""Maps between conformal and area-preserving."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ..balance.family import Family
from ..descent.energies import HarmonicEnergy
from ..errors import FoldingsRemain, check_number, own_errstate
from ..mesh.objects import takes_mesh
from ..mesh.timings import stage, timed
from ..result.run import History, Listener, Status
from ..result.sphere_map import SphereMap
from ..sphere.moebius import turn_to_gauss_map
from ..verify.certificate import Certificate
from .options import Method
from .spherical_conformal_map import spherical_conformal_map

#: Image areas that are off by more than this on average, in logarithms, are short of what was asked: of 43 samples and
#: meshes those of 5 at balance 1 (docs/balance_figures.md).
_SHORT = 0.3


@takes_mesh
@own_errstate
def balanced_spherical_map(
    v: ArrayLike,
    f: ArrayLike,
    balance: float = 0.75,
    *,
    method: str | Method = "auto",
    caps: ArrayLike | None = None,
    listener: Listener | None = None,
) -> SphereMap:
    """Map a closed genus-0 surface to the unit sphere, between conformal and area-preserving, and certify the map.

    It aims at image area = source area * (conformal factor)^(1 - balance), with the least angle distortion. Every
    iterate is free of foldings.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions, any units. Never mutated.
    f : (m, 3) array_like
        Faces as 0-based vertex indices: closed, oriented, connected, genus 0.
    balance : float
        0 is the conformal map, bit for bit; 1 is area-preserving; .75 by default.
    method : str or Method
        How the conformal map is made that it starts from, "auto" by default, or a record of options; see
        `spherical_conformal_map`.
    caps : (m,) array_like of bool, optional
        Faces that only close holes and cuts, see `check_mesh`: none by default.
    listener : callable, optional
        Called with every `Iterate`, those of the conformal map included; may raise StopIteration to stop with
        the current map.

    Returns
    -------
    SphereMap
        Turned to the Gauss map. Its ``conformal`` is the map that it started from. Where its ``area_ratios()`` miss
        their target by more than a factor of 1.35 on average, its ``status`` is ``SHORT``, and a note says by how much,
        and how the steps ended.

    Raises
    ------
    MeshError
        If `v, f` is no closed, oriented, connected genus-0 mesh.
    ValueError
        If `balance` is not in [0, 1].
    TypeError
        If it is no number.
    FoldingsRemain
        If the conformal map has foldings, which "auto" never leaves.

    References
    ----------
    The energy and its steps are in docs/balance.md.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=1000)
    >>> result = ism.balanced_spherical_map(v, f, balance=1)
    >>> result.certificate.folding_free, result.status.name, bool(abs(result.area_ratios()).mean() < 0.02)
    (True, 'CONVERGED', True)
    """
    check_number(balance, "balance", most=1)
    conformal = spherical_conformal_map(v, f, method, caps=caps, listener=listener)
    return balance_map(Family(conformal.mesh), conformal, balance, listener)


@own_errstate
def rebalance(result: SphereMap, balance: float, *, listener: Listener | None = None) -> SphereMap:
    """Take a map without foldings to another balance of the same surface, as a slider does.

    Parameters
    ----------
    result : SphereMap
        A conformal or a balanced map. The closer its balance, the fewer steps.
    balance : float
        As of `balanced_spherical_map`; 0 gives the conformal map back.
    listener : callable, optional
        Called with every `Iterate`; may raise StopIteration to stop with the current map.

    Returns
    -------
    SphereMap
        As from `balanced_spherical_map`.

    Raises
    ------
    ValueError
        If `balance` is not in [0, 1].
    TypeError
        If it is no number.
    FoldingsRemain
        If the map has foldings; `igl_spheremap.repair_foldings` removes them.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> result = ism.balanced_spherical_map(*ism.samples.make("spheroid", n_vertices=1000), balance=0.5)
    >>> ism.rebalance(result, 0.6).certificate.folding_free
    True
    """
    check_number(balance, "balance", most=1)
    return balance_map(Family(result.mesh), result, balance, listener)


@timed()
def balance_map(family: Family, result: SphereMap, balance: float, listener: Listener | None) -> SphereMap:
    """Take a map to a balance; the family of its mesh's balances holds what depends on the mesh alone."""
    history = History(listener)
    conformal = result.conformal or result
    if balance == 0 or conformal.status is Status.STOPPED:
        return conformal
    if not (result.certificate.folding_free and conformal.certificate.folding_free):
        raise FoldingsRemain("a map with foldings can't be balanced; remove them with repair_foldings", result)
    mesh = result.mesh
    energy = family.energy(conformal.sphere, balance)
    with stage("balance"):
        minimum = family.minimize(energy, result.sphere, history)
    short = energy.area_error(minimum.last.x)
    status, notes = minimum.status, conformal.notes
    if short > _SHORT and status is not Status.STOPPED:
        factor = np.exp(short)
        notes = (*notes, f"areas are off what balance {balance:g} aims at by a factor of {factor:.3g} on average; "
                         f"{status.value}")
        status = Status.SHORT
    x = turn_to_gauss_map(mesh, minimum.last.x)
    certificate = Certificate.of(x, mesh.f)
    if not certificate.folding_free:  # by the rounding of the rotation
        x, certificate = minimum.last.x, Certificate.of(minimum.last.x, mesh.f)
    own = history.complete(conformal.run, conformal.method, conformal.settings | {"balance": float(balance)})
    value = HarmonicEnergy.of(mesh).evaluate(x)[0]
    run = replace(own, status=status, energy=value, notes=notes, gauge="turned", rounds=conformal.rounds,
                  history=conformal.history + own.history, seconds=conformal.seconds + own.seconds)
    return SphereMap(mesh, x, certificate, run, conformal)
