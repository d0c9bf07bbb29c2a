"""The conformal map of a surface: check the mesh, run a method, centre, certify."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from ..angles.effort import Effort
from ..gate import takes_mesh
from ..result.run import History, Listener
from ..timings import timed
from .options import Auto, Gauge, Method, Polish, method_of

if TYPE_CHECKING:
    from .sphere_map import SphereMap


@takes_mesh
@timed()
def spherical_conformal_map(
    v: ArrayLike,
    f: ArrayLike,
    *,
    method: str | Method = "auto",
    tolerance: float = 1e-3,
    max_iterations: int = 30,
    backend: str = "auto",
    gauge: Gauge = "poles",
    polish: Polish | None = "auto",
    effort: Effort = Effort(),  # noqa: B008 - it is frozen
    caps: ArrayLike | None = None,
    listener: Listener | None = None,
) -> SphereMap:
    """Map a closed genus-0 surface conformally to the unit sphere, and certify the map.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions, any units. Never mutated.
    f : (m, 3) array_like
        Faces as 0-based vertex indices: closed, oriented, connected, genus 0. As in all functions of `v, f`, a mesh
        object may stand for both: a result of `read_mesh` or `repair_mesh`, a mesh of trimesh, PyVista or meshio, or a
        pair. Its caps, if it has any, come with it.
    method : str or Method
        "auto" (the fast pipeline, the default), "lai2014" (the paper: Algorithm 2 around Algorithm 1, from the Gauss
        map), or a baseline that the paper compares with: "gu-yau" (gradient descent), "stereographic" (a punctured
        plane). A name runs the method with its defaults; a record, such as ``ism.Lai2014(rounds=2)``, with options:
        see `Auto`, `Lai2014`, `GuYau`, `Stereographic`.
    tolerance : float, default 1e-3
        This and the next five are options of "auto", see `Auto`; other methods take theirs by record. Steps end when
        the energy is this far above its minimum, in units of the mesh's own discretisation error.
    max_iterations : int, default 30
        Most steps to the harmonic map.
    backend : str, default "auto"
        Factorisation: "scipy", "rslab", "cvxopt", or "auto", the fastest that is installed.
    gauge : {"poles", "centred"}, default "poles"
        Treatment of limbs too deep for float64: their tips go to ends of the coordinate axes, where numbers are finer;
        or they are shortened, and the map is centred.
    polish : {"auto", "angles"} or None, default "auto"
        When Newton steps lower angle differences: if they pay, always (up to 26 times the time), never.
    effort : Effort
        Cost allowed to such steps.
    caps : (m,) array_like of bool, optional
        As of `check_mesh`.
    listener : callable, optional
        Called with every `Iterate`; may raise StopIteration to stop with the current map.

    Returns
    -------
    SphereMap
        Moebius-centred on the source's area and turned to the Gauss map, unless its ``gauge`` says otherwise.
        ``certificate.folding_free`` is True if it is proved to be a bijection.

    Raises
    ------
    MeshError
        If `v, f` is not a closed, oriented, connected genus-0 mesh: one line that names the fault, its place and the
        remedy.
    ValueError
        If the method or an option's value is unknown, or a number is negative or NaN.
    TypeError
        If options of "auto" come with another method, the method is neither a name nor a record, a value is not a
        number, or the listener can't be called.
    MapError
        From "stereographic": if the plane map is not finite. From `Lai2014` with the paper's weights: if a face has no
        area.

    See Also
    --------
    balanced_spherical_map : gives limbs more room.
    SphereMapper : maps one surface in many poses.
    map_many : maps many files.
    repair_mesh : makes a mesh that this function takes.

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
    auto = Auto(
        tolerance=tolerance,
        max_iterations=max_iterations,
        backend=backend,
        gauge=gauge,
        polish=polish,
        effort=effort,
    )
    chosen = _chosen(method, auto)
    history = History(listener)
    from ..mesh.check import check_mesh  # here, as importing the package must not load scipy
    from .methods import SOLVERS

    found = SOLVERS[type(chosen)](check_mesh(v, f, caps=caps), chosen, history)
    return replace(found, run=history.complete(found.run, chosen.name, chosen.settings()))


def _chosen(method: str | Method, auto: Auto) -> Method:
    """The record of a method's options; `auto` has the default method's, given one by one."""
    if method == auto.name:
        return auto
    if auto.settings():
        raise TypeError(
            f"{', '.join(auto.settings())}: an option of method 'auto' only; give another method its "
            "options in its record, e.g. method=Lai2014(gradient_tolerance=1e-4)"
        )
    return method_of(method)
