"""Maps of one surface from any start, with any vertex weights, by one factorisation of its Laplacian."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError, own_errstate
from ..mesh.arrays import FloatArray, count, examples, plain_array
from ..mesh.check import check_mesh, move_mesh
from ..mesh.objects import MeshLike
from ..mesh.timings import timed
from ..operators.laplacian import build_operators
from ..result.run import History, Listener
from .methods import auto, check_start
from .options import Auto, method_of
from .sphere_map import SphereMap


class SphereMapper:
    """Map one surface repeatedly: its check and its factorisation are kept between calls.

    It serves one call at a time: give each thread a mapper of its own.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions, any units. Never mutated.
    f : (m, 3) array_like
        Faces as 0-based vertex indices: closed, oriented, connected, genus 0. A mesh object may stand for both.
    method : Auto
        Options of all maps, the factorisation among them.
    caps : (m,) array_like of bool, optional
        As of `check_mesh`.

    Attributes
    ----------
    mesh : Mesh
        The checked source.
    operators : Operators
        Its factorised Laplacian.

    Raises
    ------
    MeshError
        If `v, f` is not a closed, oriented, connected genus-0 mesh.
    ValueError
        If the backend is unknown or not installed.
    TypeError
        If `method` is not a record of `Auto`.
    RuntimeError
        From `move` and `map`: if another call is at work, of another thread or of a listener's.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> mapper = ism.SphereMapper(*ism.samples.make("spheroid", n_vertices=1000))
    >>> mapper.map().certificate.folding_free
    True
    """

    @own_errstate
    def __init__(
        self,
        v: ArrayLike | MeshLike,
        f: ArrayLike | None = None,
        *,
        method: Auto = Auto(),  # noqa: B008 - it is frozen
        caps: ArrayLike | None = None,
    ) -> None:
        method_of(method, Auto)
        self._lock = threading.Lock()
        mesh: tuple[Any, ...] = (v,) if f is None else (v, f)
        self.mesh = check_mesh(*mesh, **({} if caps is None else {"caps": caps}))  # a mesh object may bring its own
        self.method = method
        self.operators = build_operators(self.mesh, method.backend)

    def __repr__(self) -> str:
        return f"SphereMapper({len(self.mesh.v)} vertices, {len(self.mesh.f)} faces, {self.method})"

    @own_errstate
    def move(self, v: ArrayLike) -> None:
        """Replace the positions and keep the faces, as in a sequence, or in a population on one template.

        The check of the faces, the order of elimination and its analysis are kept, so that a map takes half of the time
        of the first. Maps equal those of a new mapper bit for bit.

        Parameters
        ----------
        v : (n, 3) array_like
            Vertex positions, any units. Never mutated.

        Raises
        ------
        MeshError
            If there is not one finite position for each vertex, or all are at one point; the mapper is as before.

        Examples
        --------
        >>> import igl_spheremap as ism
        >>> v, f = ism.samples.make("spheroid", n_vertices=1000)
        >>> mapper = ism.SphereMapper(v, f)
        >>> mapper.move(v * [1, 1, 2])
        >>> bool((mapper.map().sphere == ism.spherical_conformal_map(v * [1, 1, 2], f).sphere).all())
        True
        """
        with self._alone():
            mesh = move_mesh(self.mesh, v)
            self.operators = build_operators(mesh, self.method.backend, reuse=self.operators)
            self.mesh = mesh

    @contextmanager
    def _alone(self) -> Iterator[None]:
        """Refuse a call while another one uses the mesh and its operators, which belong together."""
        if not self._lock.acquire(blocking=False):
            raise RuntimeError("this mapper is at work for another thread, or for the run whose listener calls it; "
                               "give each thread a mapper of its own")
        try:
            yield
        finally:
            self._lock.release()

    @own_errstate
    @timed()
    def map(
        self,
        *,
        start: ArrayLike | None = None,
        vertex_weights: ArrayLike | None = None,
        listener: Listener | None = None,
    ) -> SphereMap:
        """Map the surface conformally to the unit sphere, and certify the map.

        Parameters
        ----------
        start : (n, 3) array_like, optional
            Map to start from; rows are scaled to unit length. The punctured harmonic map by default.
        vertex_weights : (n,) array_like, optional
            Non-negative weights of the vertices that are balanced on the sphere: their barycentre is at its
            centre, and the rotation agrees best with the Gauss map in them. The source's vertex areas by default.
            More weight gives a region more room.
        listener : callable, optional
            Called with every `Iterate`; may raise StopIteration to stop with the current map.

        Returns
        -------
        SphereMap
            That of ``spherical_conformal_map(v, f, method=method)``, bit for bit, unless a start or vertex weights are
            given. Its ``seconds`` are those of this call, without the factorisation.

        Raises
        ------
        MeshError
            If `start` has not one finite, nonzero row per vertex, or `vertex_weights` can't be balanced.
        """
        with self._alone():
            history, n = History(listener), len(self.mesh.v)
            x = None if start is None else check_start(start, n)
            mesh = self.mesh if vertex_weights is None else replace(self.mesh, A=_shares(vertex_weights, n))
            found = auto(mesh, self.method, history, self.operators, x)
            run = history.complete(found.run, self.method.name, self.method.settings())
            return replace(found, mesh=self.mesh, run=run)


def _shares(weights: ArrayLike, n: int) -> FloatArray:
    """Weights of sum 1; a MeshError where no Moebius map balances them."""
    w = plain_array(weights, "weights").astype(np.float64)
    if w.shape != (n,):
        raise MeshError(f"weights have shape {w.shape} but the mesh has {n} vertices; give one number each")
    bad = np.flatnonzero(~np.isfinite(w) | (w < 0))
    if len(bad):
        raise MeshError(f"weights are negative or not finite at {count(bad, 'vertex', 'vertices')}, {examples(bad)}; "
                        "give finite weights of at least 0")
    if not 2 * w.max() < w.sum():
        raise MeshError(f"vertex {w.argmax()} has half of all weight or more, so that nothing balances it; "
                        "spread the weights")
    return w / w.sum()
