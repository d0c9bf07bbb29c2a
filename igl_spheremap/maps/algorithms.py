"""The paper's Algorithms 1 and 2 by name, from any start."""

from __future__ import annotations

from dataclasses import replace

from numpy.typing import ArrayLike

from ..gate import takes_mesh
from ..mesh.check import check_mesh
from ..paper import algorithm_1 as paper
from ..paper.settings import Lai2014
from ..result.run import History, Listener, Run
from ..timings import timed
from .methods import in_gauge, lai2014, paper_setup
from .options import method_of
from .sphere_map import SphereMap


@takes_mesh
@timed()
def algorithm_1(
    v: ArrayLike,
    f: ArrayLike,
    *,
    start: ArrayLike | None = None,
    method: Lai2014 = Lai2014(),  # noqa: B008 - it is frozen
    caps: ArrayLike | None = None,
    listener: Listener | None = None,
) -> SphereMap:
    """Algorithm 1: minimise the harmonic energy by Cayley updates, from any start.

    Parameters
    ----------
    v, f, caps
        As of `check_mesh`.
    start : (n, 3) array_like, optional
        Start; rows are scaled to unit length. The Gauss map by default.
    method : Lai2014
        The options, by default those of ``Lai2014()``; `rounds` has no effect.
    listener : callable, optional
        Called with every `Iterate`; may raise StopIteration to stop with the current map.

    Returns
    -------
    SphereMap
        With or without foldings, as its certificate says.

    Raises
    ------
    MeshError
        If the mesh is invalid or `start` has not one finite, nonzero row per vertex.

    See Also
    --------
    gauss_map : its start.
    algorithm_2 : removes the foldings that it leaves.
    cayley_update : its step.

    References
    ----------
    Lai et al., Algorithm 1.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=500)
    >>> ism.algorithm_1(v, f).certificate.folding_free
    True
    """
    method_of(method, Lai2014)
    history = History(listener)
    setup, first = paper_setup(check_mesh(v, f, caps=caps), method, history, start)
    last, record = paper.algorithm_1(setup, first)
    run = Run(record.status, last.energy, rounds=(record,), notes=setup.notes)
    found = in_gauge(setup.mesh, last.x, run, method.gauge)
    return replace(found, run=history.complete(found.run, method.name, method.settings()))


@takes_mesh
@timed()
def algorithm_2(
    v: ArrayLike,
    f: ArrayLike,
    *,
    start: ArrayLike | None = None,
    method: Lai2014 = Lai2014(),  # noqa: B008 - it is frozen
    caps: ArrayLike | None = None,
    listener: Listener | None = None,
) -> SphereMap:
    """Algorithm 2: alternate Algorithm 1 and weighted eigen-projection until no folding is left.

    Parameters
    ----------
    v, f, start, method, caps
        As of `algorithm_1`; here `rounds` of the method has an effect.
    listener : callable, optional
        Called with every `Iterate`, star maps included; may raise StopIteration to stop with the current map.

    Returns
    -------
    SphereMap
        The map of the last round; ``rounds`` has the foldings before and after each.

    Raises
    ------
    MeshError
        As by `algorithm_1`.

    See Also
    --------
    algorithm_1 : its first part.
    weighted_eigen_projection : its star map.

    References
    ----------
    Lai et al., Algorithm 2.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=500)
    >>> [(r.start, r.foldings_after) for r in ism.algorithm_2(v, f).rounds]
    [('gauss map', 0)]
    """
    method_of(method, Lai2014)
    history = History(listener)
    found = lai2014(check_mesh(v, f, caps=caps), method, history, start)
    return replace(found, run=history.complete(found.run, method.name, method.settings()))
