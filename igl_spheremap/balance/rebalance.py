"""A map to the sphere at another balance."""

from __future__ import annotations

from dataclasses import replace

from ..maps.sphere_map import SphereMap
from ..operators.factor.factorize import available_backends
from ..result.run import History, Listener
from .family import balanced_map


def rebalanced(result: SphereMap, balance: float, listener: Listener | None) -> SphereMap:
    """A map without foldings, moved to another balance."""
    conformal = result._conformal_one()
    backend = conformal.settings.get("backend", "auto")
    if backend not in available_backends():  # of a map from a file
        backend = "auto"
    history = History(listener, conformal.run)
    x, certificate, run = balanced_map(
        result.mesh, conformal.sphere, result.sphere, balance, history, backend
    )
    run = replace(
        conformal.run,
        status=run.status,
        energy=run.energy,
        notes=(*conformal.notes, *run.notes),
        gauge=run.gauge,
    )
    run = history.complete(run, conformal.method, conformal.settings | {"balance": balance})
    return SphereMap(result.mesh, x, certificate, run, conformal)
