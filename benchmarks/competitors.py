"""What is compared: each competitor takes arrays to positions on the sphere, or to our result, which holds them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

import igl
import numpy as np
import scipy.sparse as sp

import igl_spheremap as ism
from igl_spheremap.mesh.measure import vertex_areas
from igl_spheremap.operators.factor.factorize import factorize
from igl_spheremap.operators.laplacian import laplacian

Array = np.ndarray
Competitor = Callable[[Array, Array], Array | ism.SphereMap]

#: Flow: stop when the radius varies by less than this share of it, or after so many steps.
_ROUND, _FLOW_STEPS = 1e-3, 60
#: Flow: length of a step in time, the surface being scaled to unit area.
_FLOW_TIME = 1.0


def ours(v: Array, f: Array, **options: str) -> ism.SphereMap:
    """This package, its certificate included."""
    return ism.spherical_conformal_map(v, f, **options)


def lapy(v: Array, f: Array, guarded: bool = True, use_cholmod: bool = False) -> Array:
    """LaPy's linear method (after Choi, Lam, Lui 2015), as it ships or with its refusals switched off."""
    from lapy import TriaMesh, conformal

    with np.errstate(all="ignore"):
        if guarded:
            return conformal.spherical_conformal_map(TriaMesh(v, f), use_cholmod=use_cholmod)
        with _without_refusals(conformal):
            return conformal.spherical_conformal_map(TriaMesh(v, f), use_cholmod=use_cholmod)


@contextmanager
def _without_refusals(conformal: object) -> Iterator[None]:
    """LaPy divides by what it finds, instead of refusing denominators below an absolute 1e-8."""
    names = ("_ensure_nonzero", "_ensure_nonzero_array")
    kept = {name: getattr(conformal, name) for name in names}
    for name in names:
        setattr(conformal, name, lambda *_: None)
    try:
        yield
    finally:
        for name, function in kept.items():
            setattr(conformal, name, function)


def mean_curvature_flow(v: Array, f: Array) -> Array:
    """Conformalised mean curvature flow (Kazhdan, Solomon, Ben-Chen 2012), with the fastest factorisation there is."""
    L, x = laplacian(v, f), v / np.sqrt(igl.doublearea(v, f).sum() / 2)
    for _ in range(_FLOW_STEPS):
        A = vertex_areas(x, f)  # the mass follows the surface, the stiffness stays
        x = factorize(sp.diags_array(A, format="csr") + _FLOW_TIME * L).solve(A[:, None] * x)
        x -= np.einsum("i,ij->j", A, x) / A.sum()
        x /= np.sqrt(igl.doublearea(x, f).sum() / 2)
        radius = np.linalg.norm(x, axis=1)
        if np.sqrt(A @ (radius * np.sqrt(4 * np.pi) - 1) ** 2 / A.sum()) < _ROUND:
            break
    return x / np.linalg.norm(x, axis=1)[:, None]


def factorised_matrix(v: Array, f: Array) -> sp.csr_matrix:
    """What the map factorises."""
    mesh = ism.check_mesh(v, f)
    return laplacian(mesh.v, mesh.f) + sp.diags_array(1e-9 * vertex_areas(mesh.v, mesh.f), format="csr")


#: In the order of the tables.
COMPETITORS: dict[str, Competitor] = {
    "ours, cvxopt": partial(ours, backend="cvxopt"),
    "ours, scipy": partial(ours, backend="scipy"),
    "ours, multigrid": partial(ours, backend="multigrid"),
    "LaPy": lapy,
    "LaPy, no refusals": partial(lapy, guarded=False),
    "LaPy, cholespy": partial(lapy, guarded=False, use_cholmod=True),
    "mean curvature flow": mean_curvature_flow,
    "lai2014": partial(ours, method="lai2014"),
}

#: Ordering and factorisation alone: the least that a map can cost, by backend.
FACTORS = {f"factor, {backend}": backend for backend in ("cvxopt", "scipy", "multigrid")}

#: Vertices beyond which a competitor is not tried.
LARGEST = {"lai2014": 20_000, "mean curvature flow": 300_000, "LaPy": 300_000, "LaPy, cholespy": 300_000,
           "LaPy, no refusals": 1_000_000, "ours, scipy": 1_500_000, "factor, scipy": 1_500_000}
