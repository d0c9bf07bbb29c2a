"""Maps of one list of faces at one set of positions after the other."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from numpy.typing import ArrayLike

from ..gate import MeshLike, gate
from ..mesh.check import check_mesh, move_mesh
from ..operators.laplacian import build_operators
from ..result.run import History, Listener
from ..timings import timed
from .methods import auto
from .options import Auto, method_of
from .sphere_map import SphereMap


class SphereMapper:
    """Map one surface in many poses: data of its faces alone are computed once.

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

    @gate
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
        given: tuple[Any, ...] = (v,)
        if f is not None:
            given = (v, f)
        self.mesh = check_mesh(*given, caps=caps)
        self.method = method
        self.operators = build_operators(self.mesh, method.backend)

    def __repr__(self) -> str:
        return f"SphereMapper({len(self.mesh.v)} vertices, {len(self.mesh.f)} faces, {self.method})"

    @gate
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
            raise RuntimeError(
                "this mapper is at work for another thread, or for the run whose listener calls it; "
                "give each thread a mapper of its own"
            )
        try:
            yield
        finally:
            self._lock.release()

    @gate
    @timed()
    def map(self, *, listener: Listener | None = None) -> SphereMap:
        """Map the surface conformally to the unit sphere, and certify the map.

        Parameters
        ----------
        listener : callable, optional
            Called with every `Iterate`; may raise StopIteration to stop with the current map.

        Returns
        -------
        SphereMap
            That of ``spherical_conformal_map(v, f, method=method)``, bit for bit. Its ``seconds`` are those of this
            call, without the factorisation.
        """
        with self._alone():
            history = History(listener)
            found = auto(self.mesh, self.method, history, self.operators)
            run = history.complete(found.run, self.method.name, self.method.settings())
            return replace(found, run=run)
