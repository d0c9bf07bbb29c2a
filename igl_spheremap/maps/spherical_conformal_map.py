"""From arrays to a certified result: the package's front door."""

from __future__ import annotations

import inspect
import time
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..descent.iterate import Iterate, Listener, Step
from ..mesh.check import Mesh, check_directions, check_mesh
from ..operators.laplacian import positive_areas
from ..sphere.gauge import fix_gauge
from ..sphere.rows import unit_rows
from ..untangle.mend import mend_locally
from ..verify.certificate import certify_checked
from .methods import METHODS, Draft
from .sphere_map import SphereMap

FloatArray = NDArray[np.float64]


def spherical_conformal_map(
    v: ArrayLike,
    f: ArrayLike,
    method: str = "auto",
    *,
    listener: Listener | None = None,
    **options: Any,
) -> SphereMap:
    """Map a closed genus-0 surface conformally to the unit sphere, and certify the map.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions, any units. Never mutated.
    f : (m, 3) array_like
        Faces as 0-based vertex indices: closed, oriented, connected, genus 0.
    method : str
        "auto" (the fast pipeline, the default), "lai2014" (the paper: Algorithm 2 around Algorithm 1, from the Gauss
        map), or a baseline that the paper compares with: "gu-yau" (gradient descent), "stereographic" (a punctured
        plane).
    listener : callable, optional
        Called with every `Iterate`; may raise StopIteration to end with what there is.
    **options
        The method's own, with its own defaults: see `igl_spheremap.maps.methods`. Those of "auto" are ``backend`` (the
        factorisation), ``polish`` ("angles" or "mips"), ``gauge`` ("poles" for bodies beyond float64),
        ``tolerance`` and ``max_iterations``.

    Returns
    -------
    SphereMap
        Moebius-centred on the source's area and turned to the Gauss map. ``certificate.folding_free`` tells whether
        it is proved to be a bijection.

    Raises
    ------
    MeshError
        If `v, f` is no closed, oriented, connected genus-0 mesh: one line that says what is wrong, where, and what
        would mend it.
    ValueError
        If the method is unknown.
    TypeError
        If the method has no such option.

    References
    ----------
    Lai, Wen, Yin, Gu, Lui 2014, *Folding-Free Global Conformal Mapping for Genus-0 Surfaces by Harmonic Energy
    Minimization*.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=1000)
    >>> result = ism.spherical_conformal_map(v, f)
    >>> result.certificate.folding_free, result.status.name, result.sphere.shape == v.shape
    (True, 'CONVERGED', True)
    """
    began = time.perf_counter()
    run = _method(method, options)
    mesh = check_mesh(v, f)
    recorder = Recorder(listener)
    draft = run(mesh, recorder, **options)
    return finish(mesh, draft, recorder, method, options, began)


def minimize_harmonic_energy(v: ArrayLike, f: ArrayLike, x0: ArrayLike | None = None, *,
                             listener: Listener | None = None, **options: Any) -> SphereMap:
    """Algorithm 1: minimise the harmonic energy by Cayley updates, from any start.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions.
    f : (m, 3) array_like
        Faces as 0-based vertex indices.
    x0 : (n, 3) array_like, optional
        Start; rows are scaled to unit length. The Gauss map by default.
    listener : callable, optional
        Called with every `Iterate`.
    **options
        ``tolerance`` (1e-3: L2 norm of the tangential gradient, the source having unit area), ``max_iterations``
        (5000), ``rho`` (1e-4), ``delta`` (0.1), ``xi`` (0.85), ``bb`` ("alternating", "tau_1" or "tau_2").

    Returns
    -------
    SphereMap
        With or without foldings: its certificate tells.

    Raises
    ------
    MeshError
        If the mesh is invalid or `x0` has not one finite, nonzero row per vertex.

    References
    ----------
    Lai et al., Algorithm 1.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=500)
    >>> ism.minimize_harmonic_energy(v, f).certificate.folding_free
    True
    """
    return remove_foldings(v, f, x0, listener=listener, **{**options, "rounds": 0})


def remove_foldings(v: ArrayLike, f: ArrayLike, x0: ArrayLike | None = None, *,
                    listener: Listener | None = None, **options: Any) -> SphereMap:
    """Algorithm 2: alternate Algorithm 1 and weighted eigen-projection until no folding is left.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions.
    f : (m, 3) array_like
        Faces as 0-based vertex indices.
    x0 : (n, 3) array_like, optional
        Start; rows are scaled to unit length. The Gauss map by default.
    listener : callable, optional
        Called with every `Iterate`, star maps included.
    **options
        ``rounds`` (3, eigen-projections at the most) and the options of `minimize_harmonic_energy`.

    Returns
    -------
    SphereMap
        The map of the round with the fewest foldings; ``rounds`` tells the foldings before and after each.

    Raises
    ------
    MeshError
        If the mesh is invalid or `x0` has not one finite, nonzero row per vertex.

    References
    ----------
    Lai et al., Algorithm 2.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=500)
    >>> [(r.start, r.foldings_after) for r in ism.remove_foldings(v, f).rounds]
    [('gauss map', 0)]
    """
    began = time.perf_counter()
    run = _method("lai2014", options)
    mesh = check_mesh(v, f)
    start = None if x0 is None else check_start(x0, len(mesh.v))
    recorder = Recorder(listener)
    draft = run(mesh, recorder, x0=start, **options)
    return finish(mesh, draft, recorder, "lai2014", options, began)


def _method(name: str, options: dict[str, Any]) -> Any:
    """The method of that name, which takes these options; else a ValueError or TypeError that lists what there is."""
    if name not in METHODS:
        raise ValueError(f"unknown method {name!r}: choose one of {', '.join(METHODS)}")
    known = [p.name for p in inspect.signature(METHODS[name]).parameters.values() if p.kind is p.KEYWORD_ONLY]
    unknown = sorted(set(options) - set(known))
    if unknown:
        raise TypeError(f"method {name!r} has no option {', '.join(unknown)}; it takes {', '.join(known)}")
    return METHODS[name]


def check_start(x: ArrayLike, n: int) -> FloatArray:
    """Check a start, and scale its rows to unit length.

    Parameters
    ----------
    x : (n, 3) array_like
        One finite, nonzero row per vertex.
    n : int
        Number of vertices.

    Returns
    -------
    (n, 3) float64 array
        Unit rows.

    Raises
    ------
    MeshError
        If a row is missing, zero or not finite.
    """
    return unit_rows(check_directions(x, n, "start positions"))  # eq. (4)


class Recorder:
    """Listener that keeps the history and passes iterates on.

    Parameters
    ----------
    listener : callable, optional
        The next one.

    Attributes
    ----------
    steps : list of Step
        One for each iterate so far.
    """

    def __init__(self, listener: Listener | None) -> None:
        self.steps: list[Step] = []
        self._listener = listener

    def __call__(self, iterate: Iterate) -> None:
        self.steps.append(Step(iterate.stage, iterate.round, iterate.iteration, iterate.energy, iterate.residual,
                               iterate.tau))
        if self._listener is not None:
            self._listener(iterate)


def finish(mesh: Mesh, draft: Draft, recorder: Recorder, method: str, options: dict[str, Any],
            began: float) -> SphereMap:
    """Put the draft into the gauge, certify the very numbers that are returned, and close the record.

    Parameters
    ----------
    mesh : Mesh
        The checked source.
    draft : Draft
        What a method left.
    recorder : Recorder
        What it told.
    method : str
        Its name.
    options : dict
        What was asked of it.
    began : float
        ``time.perf_counter()`` at the beginning.

    Returns
    -------
    SphereMap
        The result.
    """
    x, certificate, notes = draft.x, draft.certificate, draft.notes
    if certificate is None:
        x = fix_gauge(mesh, draft.x, positive_areas(mesh))
        certificate = certify_checked(x, mesh.f)
        if not certificate.folding_free and certify_checked(draft.x, mesh.f).folding_free:
            x = mend_locally(mesh, x)
            certificate = certify_checked(x, mesh.f)
            notes = (*notes, "the rounding of the last rotation folded a face or two, which were mended")
    moves = sum(step.iteration > 0 for step in recorder.steps)
    return SphereMap(mesh.vertices, mesh.f, x, certificate, draft.energy, draft.status, moves,
                     time.perf_counter() - began, method, tuple(recorder.steps), draft.rounds, draft.backend,
                     notes, dict(options), draft.gauge, draft.stretch)
