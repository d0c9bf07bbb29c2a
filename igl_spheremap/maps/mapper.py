"""Many maps of one surface: its Laplacian is factorised once, and each map costs a few solves."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..descent.fast import TOLERANCE
from ..descent.iterate import Listener
from ..errors import MeshError
from ..mesh.check import check_mesh
from ..operators.operators import build_operators
from ..untangle.relax import Polish
from .methods.auto import Gauge, check_choices, map_in_metric
from .sphere_map import SphereMap
from .spherical_conformal_map import Recorder, check_start, finish

FloatArray = NDArray[np.float64]


class SphereMapper:
    """The stateful twin of `spherical_conformal_map`, for many maps of one surface.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions, any units. Never mutated.
    f : (m, 3) array_like
        Faces as 0-based vertex indices: closed, oriented, connected, genus 0.
    backend : str
        Factorisation, see `igl_spheremap.operators.factor.factorize`.

    Attributes
    ----------
    mesh : Mesh
        The checked source.
    operators : Operators
        Its factorised Laplacian.

    Raises
    ------
    MeshError
        If `v, f` is no closed, oriented, connected genus-0 mesh.
    ValueError
        If `backend` is unknown or not installed.

    Notes
    -----
    A map that folds may be solved again with intrinsic Delaunay weights, which are factorised then.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> mapper = ism.SphereMapper(*ism.samples.make("spheroid", n_vertices=1000))
    >>> mapper.map().certificate.folding_free
    True
    """

    def __init__(self, v: ArrayLike, f: ArrayLike, backend: str = "auto") -> None:
        self.mesh = check_mesh(v, f)
        self.operators = build_operators(self.mesh, backend)

    def map(
        self,
        start: ArrayLike | None = None,
        weights: ArrayLike | None = None,
        *,
        gauge: Gauge = "centred",
        tolerance: float = TOLERANCE,
        max_iterations: int = 30,
        polish: Polish | None = None,
        listener: Listener | None = None,
    ) -> SphereMap:
        """Map the surface conformally to the unit sphere, and certify the map.

        Parameters
        ----------
        start : (n, 3) array_like, optional
            Map to start from; rows are scaled to unit length. The punctured harmonic map by default.
        weights : (n,) array_like, optional
            Non-negative weights of the vertices that are balanced on the sphere: their barycentre is at its
            centre, and the rotation agrees best with the Gauss map in them. The source's vertex areas by default.
            More weight gives a region more room.
        gauge, tolerance, max_iterations, polish
            As for ``spherical_conformal_map(v, f)``, which gives the same map bit for bit.
        listener : callable, optional
            Called with every `Iterate`; may raise StopIteration to end with what there is.

        Returns
        -------
        SphereMap
            Its ``seconds`` are those of this call, without the factorisation.

        Raises
        ------
        MeshError
            If `start` has not one finite, nonzero row per vertex, or `weights` can't be balanced.
        ValueError
            If `gauge` or `polish` is unknown.
        """
        began = time.perf_counter()
        check_choices(gauge, polish)
        n = len(self.mesh.v)
        x = None if start is None else check_start(start, n)
        operators = self.operators if weights is None else replace(self.operators, A=_shares(weights, n))
        recorder = Recorder(listener)
        draft = map_in_metric(self.mesh, operators, x, recorder, tolerance=tolerance, max_iterations=max_iterations,
                              gauge=gauge, polish=polish)
        options = {"gauge": gauge, "tolerance": tolerance, "max_iterations": max_iterations, "polish": polish}
        return finish(self.mesh, draft, recorder, "auto", options, began)


def _shares(weights: ArrayLike, n: int) -> FloatArray:
    """Weights of sum 1; a MeshError where no Moebius map balances them."""
    w = np.asarray(weights, dtype=np.float64)
    if w.shape != (n,):
        raise MeshError(f"weights have shape {w.shape} but the mesh has {n} vertices; give one number each")
    bad = np.flatnonzero(~np.isfinite(w) | (w < 0))
    if len(bad):
        raise MeshError(f"{len(bad)} weights are negative or not finite, e.g. {bad[:3].tolist()}; "
                        "give finite weights of at least 0")
    if not 2 * w.max() < w.sum():
        raise MeshError(f"vertex {w.argmax()} has half of all weight or more, so that nothing balances it; "
                        "spread the weights")
    return w / w.sum()
