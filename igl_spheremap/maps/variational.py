"""The paper's further problems by its own solver: p-harmonic maps, and harmonic maps with landmarks."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..descent.algorithm_1 import CayleyBB
from ..descent.iterate import Iterate, Listener
from ..descent.minimize import minimize
from ..descent.p_harmonic import p_harmonic_problem
from ..descent.problem import Problem, harmonic_problem
from ..descent.smooth_problem import smooth_problem
from ..mesh.check import Mesh, check_mesh
from ..untangle.algorithm_2 import record_round
from ..verify.certificate import certify_checked
from .landmarks import check_landmarks, match_landmarks
from .methods import Draft
from .sphere_map import SphereMap
from .spherical_conformal_map import Recorder, check_start, finish, spherical_conformal_map

FloatArray = NDArray[np.float64]


def p_harmonic_map(
    v: ArrayLike,
    f: ArrayLike,
    p: float,
    x0: ArrayLike | None = None,
    *,
    confine: bool = True,
    tolerance: float = 1e-3,
    max_iterations: int = 5000,
    plateau: float = 5e-7,
    listener: Listener | None = None,
) -> SphereMap:
    """Minimise the p-harmonic energy of eq. (8) by Algorithm 1.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions.
    f : (m, 3) array_like
        Faces as 0-based vertex indices.
    p : float
        Exponent above 1. At 2 the map is the harmonic one. Larger exponents punish stretching where it is
        largest: limbs gain room, and angles are lost. Up to 2 the Moebius gauge is fixed as for harmonic
        maps; above, the energy itself keeps the map spread out.
    x0 : (n, 3) array_like, optional
        Start; rows are scaled to unit length. The conformal map by default.
    confine : bool
        Whether a start without foldings is kept so, by refusing steps that would fold.
    tolerance : float
        L2 norm of the tangential gradient at which the run ends, the source having unit area.
    max_iterations : int
        Iterations at the most.
    plateau : float
        The run ends, too, when the lowest energy fell by less than this share over 100 iterations.
    listener : callable, optional
        Called with every `Iterate`, whose energy is the p-harmonic one.

    Returns
    -------
    SphereMap
        Its ``energy`` is the harmonic one; ``history`` has the p-harmonic energies; ``rounds`` tells the
        foldings before and after.

    Raises
    ------
    MeshError
        If the mesh is invalid or `x0` has not one finite, nonzero row per vertex.
    ValueError
        If p is not above 1.

    References
    ----------
    Lai et al., Remark 1 and eq. (8).

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=500)
    >>> result = ism.p_harmonic_map(v, f, 4)
    >>> bool(result.conformal_factor().std() < ism.spherical_conformal_map(v, f).conformal_factor().std())
    True
    """
    began = time.perf_counter()
    mesh = check_mesh(v, f)
    problem = p_harmonic_problem(mesh, p)
    start, x = _start(mesh, x0)
    recorder = Recorder(listener)
    knobs = {"tolerance": tolerance, "max_iterations": max_iterations, "plateau": plateau}
    draft = _descend(mesh, problem, start, x, confine, recorder, knobs)
    return finish(mesh, draft, recorder, "p-harmonic", {"p": p, "confine": confine, **knobs}, began)


def landmark_map(
    v: ArrayLike,
    f: ArrayLike,
    landmarks: ArrayLike,
    targets: ArrayLike,
    weights: ArrayLike = 100.0,
    x0: ArrayLike | None = None,
    *,
    confine: bool = True,
    tolerance: float = 1e-3,
    max_iterations: int = 500,
    plateau: float = 1e-6,
    listener: Listener | None = None,
) -> SphereMap:
    """Minimise the harmonic energy plus a penalty on how far landmarks are from their targets.

    The penalty is half the weighted sum of squared chords. The solver is Algorithm 1, in a metric of smooth
    fields: in the L2 metric the penalty's gradient sits on single vertices, which fold their neighbourhood at
    once.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions.
    f : (m, 3) array_like
        Faces as 0-based vertex indices.
    landmarks : (k,) array_like
        Vertex indices.
    targets : (k, 3) array_like
        Where they ought to go, as directions.
    weights : float or (k,) array_like
        Of the squared chords, against an energy of about 4 pi; 100 leaves misses of some thousandths.
    x0 : (n, 3) array_like, optional
        Start; rows are scaled to unit length. By default the conformal map, moved by the Moebius map that
        brings the landmarks closest.
    confine : bool
        Whether a start without foldings is kept so, by refusing steps that would fold. Without it the map
        folds near landmarks: points have no capacity in the plane, and the energy is lowest where it is
        pulled out like tents.
    tolerance : float
        Norm of the gradient, in the metric of smooth fields, at which the run ends.
    max_iterations : int
        Iterations at the most.
    plateau : float
        The run ends, too, when the lowest energy fell by less than this share over 100 iterations.
    listener : callable, optional
        Called with every `Iterate`, whose energy includes the penalty.

    Returns
    -------
    SphereMap
        In the frame of the targets. Its ``energy`` is the harmonic one; ``history`` has the sums; ``rounds``
        tells the foldings before and after.

    Raises
    ------
    MeshError
        If the mesh, `x0` or a landmark is invalid.

    References
    ----------
    Lai et al., sections 1 and 6: harmonic energy with landmark matching (their references [3, 19]).

    Examples
    --------
    >>> import numpy as np
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("sphere", n_vertices=600)
    >>> target = v[[0, 100, 200, 300]] @ [[0, 1, 0], [-1, 0, 0], [0, 0, 1]] + [0.1, 0, 0]
    >>> result = ism.landmark_map(v, f, [0, 100, 200, 300], target)
    >>> bool(np.abs(result.sphere[[0, 100, 200, 300]] - target).max() < 0.15), result.certificate.folding_free
    (True, True)
    """
    began = time.perf_counter()
    mesh = check_mesh(v, f)
    penalty = check_landmarks(len(mesh.v), landmarks, targets, weights)
    start, x = _start(mesh, x0)
    if x0 is None:
        x = match_landmarks(x, penalty)
    problem = smooth_problem(mesh, (penalty,), x)
    recorder = Recorder(listener)
    knobs = {"tolerance": tolerance, "max_iterations": max_iterations, "plateau": plateau}
    draft = _descend(mesh, problem, start, x, confine, recorder, knobs)
    return finish(mesh, draft, recorder, "landmarks", {"confine": confine, **knobs}, began)


def _start(mesh: Mesh, x0: ArrayLike | None) -> tuple[str, FloatArray]:
    """Name and map to start from."""
    if x0 is None:
        return "conformal map", spherical_conformal_map(mesh.vertices, mesh.f).sphere
    return "given map", check_start(x0, len(mesh.v))


def _descend(
    mesh: Mesh,
    problem: Problem,
    name: str,
    x: FloatArray,
    confine: bool,
    recorder: Recorder,
    knobs: dict[str, Any],
) -> Draft:
    """Algorithm 1 on a problem; the draft in its own gauge unless the problem leaves it open."""
    began = time.perf_counter()
    solver = CayleyBB(confine_to=mesh.f if confine else None)
    minimum = minimize(solver.iterates(problem, x), listener=recorder, **knobs)
    x1 = minimum.last.x
    start = Iterate(name, 0, 0, x, problem.energy.evaluate(x)[0])
    done = record_round(mesh, start, minimum, time.perf_counter() - began)
    energy = harmonic_problem(mesh).energy.evaluate(x1)[0]
    certificate = None if problem.gauge else certify_checked(x1, mesh.f)  # in a gauge of its own: not to be moved
    return Draft(x1, energy, minimum.status, (done,), certificate=certificate)
