"""Algorithm 1 on further energies: p-harmonic, Remark 1 and eq. (8), and harmonic with fidelity terms, section 6."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from ..descent.energies import Energy, HarmonicEnergy, LandmarkEnergy, OwnEnergy, SumEnergy
from ..descent.minimize import minimize_round
from ..descent.problem import Problem, SobolevH2, p_harmonic_problem
from ..errors import MeshError
from ..gate import takes_mesh
from ..mesh.arrays import TINY, FloatArray, check_directions, plain_array, real_array
from ..mesh.check import Mesh, check_mesh
from ..paper.algorithm_1 import cayley_bb
from ..paper.settings import PaperGauge
from ..result.method import Method
from ..result.run import History, Listener, Round, Run, Stage, Status
from ..sphere.moebius import best_rotation, moebius
from ..sphere.rows import unit_rows
from ..timings import timed
from ..verify.signs import folded_faces
from .methods import auto, check_start, in_gauge
from .options import Auto
from .repair_last import repair_last
from .safeguards import Confined
from .sphere_map import SphereMap


@dataclass(frozen=True)
class Variational(Method):
    """Options of Algorithm 1 for other energies than the harmonic one."""

    may_fold: bool = False
    max_iterations: int = 5000
    plateau: float = 5e-7


@dataclass(frozen=True)
class PHarmonic(Variational):
    """The options of `igl_spheremap.p_harmonic_map`."""

    name: ClassVar[str] = "p-harmonic"
    gradient_tolerance: float = 1e-3
    p: float = 2.0


@dataclass(frozen=True)
class Landmarks(Variational):
    """The options of `igl_spheremap.landmark_map`."""

    name: ClassVar[str] = "landmarks"
    max_iterations: int = 500
    plateau: float = 1e-6
    sobolev_gradient_tolerance: float = 1e-3


@dataclass(frozen=True)
class Fidelity(Landmarks):
    """The options of `igl_spheremap.fidelity_map`."""

    name: ClassVar[str] = "fidelity"
    gauge: PaperGauge = "free"


@takes_mesh
@timed()
def p_harmonic_map(
    v: ArrayLike,
    f: ArrayLike,
    p: float,
    *,
    start: ArrayLike | None = None,
    may_fold: bool = False,
    gradient_tolerance: float = 1e-3,
    max_iterations: int = 5000,
    plateau: float = 5e-7,
    caps: ArrayLike | None = None,
    listener: Listener | None = None,
) -> SphereMap:
    """Minimise the p-harmonic energy of equation (8) by Algorithm 1.

    Parameters
    ----------
    v, f : (n, 3) and (m, 3) array_like
        The mesh, as of `check_mesh`.
    p : float
        Exponent above 1. At 2 the map is the harmonic one. Larger exponents punish stretching where it is
        largest: limbs gain room, and angles are lost. Up to 2 the Moebius gauge is fixed as for harmonic
        maps; above, the energy itself keeps the map spread out.
    start : (n, 3) array_like, optional
        Start; rows are scaled to unit length. The conformal map by default.
    may_fold, caps
        As of `fidelity_map`.
    gradient_tolerance : float
        L2 norm of the tangential gradient at which the run ends, the source having unit area; 1e-3 by default.
    max_iterations : int
        Maximum number of iterations, 5000 by default.
    plateau : float
        The run ends, too, when the lowest energy fell by less than this share, 5e-7 by default, over 100 iterations.
    listener : callable, optional
        Called with every `Iterate`, whose energy is the p-harmonic one.

    Returns
    -------
    SphereMap
        Its ``energy`` is the harmonic one; ``history`` has the p-harmonic energies; ``rounds`` has the
        foldings before and after.

    Raises
    ------
    MeshError
        If the mesh is invalid or `start` has not one finite, nonzero row per vertex.
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
    options = PHarmonic(
        may_fold=may_fold,
        max_iterations=max_iterations,
        plateau=plateau,
        gradient_tolerance=gradient_tolerance,
        p=p,
    )
    history = History(listener)
    mesh = check_mesh(v, f, caps=caps)
    problem = p_harmonic_problem(mesh, p)
    gauge: PaperGauge = "free"
    if problem.fixes_gauge:
        gauge = "centred"
    return descend(
        mesh, problem, *start_of(mesh, start), options, gradient_tolerance, gauge, history
    )


@takes_mesh
@timed()
def fidelity_map(
    v: ArrayLike,
    f: ArrayLike,
    fidelity: Callable[[FloatArray], tuple[float, ArrayLike]],
    *,
    start: ArrayLike | None = None,
    gauge: PaperGauge = "free",
    may_fold: bool = False,
    sobolev_gradient_tolerance: float = 1e-3,
    max_iterations: int = 500,
    plateau: float = 1e-6,
    caps: ArrayLike | None = None,
    listener: Listener | None = None,
) -> SphereMap:
    """Minimise the harmonic energy plus a fidelity term of your own by Algorithm 1.

    The gradient of the sum is taken in a metric of smooth fields. In the L2 metric the gradient of a term on single
    vertices, or on a curve, is zero elsewhere, and a step along it folds the faces around them at once.

    Parameters
    ----------
    v, f : (n, 3) and (m, 3) array_like
        The mesh, as of `check_mesh`.
    fidelity : callable
        Takes a map, an (n, 3) float64 array of unit rows that it can't change, and returns the term's value, beside a
        harmonic energy of about 4 pi, and the (n, 3) array of its derivatives by the coordinates. Their part normal to
        the sphere does not count. No step leads to an infinite or NaN value.
    start : (n, 3) array_like, optional
        Start; rows are scaled to unit length. The conformal map by default.
    gauge : {"free", "centred"}
        "free", the default, is for terms that select one of a map's Moebius images. "centred" is for others, such as of
        curves: then the map stays Moebius-centred on the source's area, since Moebius maps that crowd the mesh into a
        point lower the discrete harmonic energy. Neither turns the map.
    may_fold : bool
        Leave the minimiser's folds. By default they are repaired, by moves of the vertices around.
    sobolev_gradient_tolerance : float
        Norm of the gradient at which the run ends, 1e-3 by default, both in the metric of smooth fields. The
        ``gradient_tolerance`` of other methods is an L2 norm, which single vertices would dominate.
    max_iterations : int
        Maximum number of iterations, 500 by default.
    plateau : float
        The run ends, too, when the lowest energy fell by less than this share, 1e-6 by default, over 100 iterations.
    caps : (m,) array_like of bool, optional
        As of `check_mesh`.
    listener : callable, optional
        Called with every `Iterate`, whose energy includes the term.

    Returns
    -------
    SphereMap
        In the frame of the start. Its ``energy`` is the harmonic one; ``history`` has the sums; ``rounds`` has the
        foldings before and after. If the derivatives are not those of the value, its status is STALLED at the first
        iteration.

    Raises
    ------
    MeshError
        If the mesh is invalid, or `start` or the derivatives have not one row per vertex.
    ValueError
        If the gauge is unknown, a number negative or NaN, or the term not finite at the start, or its derivatives
        where its value is.
    TypeError
        If the term can't be called, or returns no number and array.

    References
    ----------
    Lai et al., section 6: "variational problem of harmonic energy with additional fidelity terms".

    Examples
    --------
    The vertices of a curve are drawn to the equator, along which they may slide:

    >>> import numpy as np
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("pear", n_vertices=600)
    >>> curve = np.flatnonzero(np.abs(v[:, 0] - 0.2 * v[:, 1]) < 0.05)
    >>> def to_equator(x, weight=10.0):
    ...     height = x[curve, 2]
    ...     derivatives = np.zeros_like(x)
    ...     derivatives[curve, 2] = weight * height
    ...     return 0.5 * weight * height @ height, derivatives
    >>> turned = ism.spherical_conformal_map(v, f).sphere @ [[0, 0, 1], [1, 0, 0], [0, 1, 0]]  # x to z
    >>> result = ism.fidelity_map(v, f, to_equator, start=turned, gauge="centred")
    >>> bool(np.abs(result.sphere[curve, 2]).max() < 0.05 < np.abs(turned[curve, 2]).max())
    True
    >>> result.certificate.folding_free
    True
    """
    options = Fidelity(
        may_fold=may_fold,
        max_iterations=max_iterations,
        plateau=plateau,
        sobolev_gradient_tolerance=sobolev_gradient_tolerance,
        gauge=gauge,
    )
    if not callable(fidelity):
        raise TypeError(
            f"fidelity is {fidelity!r}; give a function of the map that returns value and derivatives"
        )
    history = History(listener)
    mesh = check_mesh(v, f, caps=caps)
    name, x = start_of(mesh, start)
    return _with_fidelity(mesh, OwnEnergy(fidelity), name, x, options, gauge, history)


def _with_fidelity(
    mesh: Mesh,
    term: Energy,
    name: str,
    x: FloatArray,
    options: Landmarks,
    gauge: PaperGauge,
    history: History,
) -> SphereMap:
    """The harmonic energy plus a term, minimised in the metric of smooth fields."""
    value = term.evaluate(x)[0]
    if not np.isfinite(value):
        raise ValueError(
            f"the fidelity term is {value} at the start; give a start where it is finite"
        )
    harmonic = HarmonicEnergy.of(mesh)
    problem = Problem.of(
        mesh, SumEnergy((harmonic, term)), SobolevH2.of(harmonic.L, mesh.f, x), gauge == "centred"
    )
    return descend(
        mesh, problem, name, x, options, options.sobolev_gradient_tolerance, "free", history
    )


@takes_mesh
@timed()
def landmark_map(
    v: ArrayLike,
    f: ArrayLike,
    landmarks: ArrayLike,
    targets: ArrayLike,
    *,
    landmark_weights: ArrayLike = 100.0,
    start: ArrayLike | None = None,
    may_fold: bool = False,
    sobolev_gradient_tolerance: float = 1e-3,
    max_iterations: int = 500,
    plateau: float = 1e-6,
    caps: ArrayLike | None = None,
    listener: Listener | None = None,
) -> SphereMap:
    """Minimise the harmonic energy plus a penalty on the distances of landmarks from their targets.

    The penalty is half the weighted sum of squared chords: a fidelity term, see `fidelity_map`, whose solver and metric
    are used.

    Parameters
    ----------
    v, f : (n, 3) and (m, 3) array_like
        The mesh, as of `check_mesh`.
    landmarks : (k,) array_like
        Vertex indices.
    targets : (k, 3) array_like
        Their targets, as directions.
    landmark_weights : float or (k,) array_like
        Weights of the squared chords, beside an energy of about 4 pi; 100, the default, leaves distances of some 1e-3.
    start : (n, 3) array_like, optional
        Start; rows are scaled to unit length. By default the conformal map, moved by the Moebius map that
        brings the landmarks closest.
    may_fold : bool
        Leave the minimiser's folds. It folds near landmarks: a point has zero capacity in the plane, so the energy is
        lowest if a thin spike of the surface reaches the target. By default folds are repaired, by moves of the
        vertices around, landmarks among them.
    sobolev_gradient_tolerance, max_iterations, plateau, caps
        As of `fidelity_map`.
    listener : callable, optional
        Called with every `Iterate`, whose energy includes the penalty.

    Returns
    -------
    SphereMap
        In the frame of the targets. Its ``energy`` is the harmonic one; ``history`` has the sums; ``rounds``
        has the foldings before and after.

    Raises
    ------
    MeshError
        If the mesh, `start` or a landmark is invalid.
    ValueError
        If a number is negative or NaN.

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
    options = Landmarks(
        may_fold=may_fold,
        max_iterations=max_iterations,
        plateau=plateau,
        sobolev_gradient_tolerance=sobolev_gradient_tolerance,
    )
    history = History(listener)
    mesh = check_mesh(v, f, caps=caps)
    penalty = check_landmarks(len(mesh.v), landmarks, targets, landmark_weights)
    name, x = start_of(mesh, start)
    if start is None:
        x = match_landmarks(x, penalty)
    # landmarks fix the gauge
    return _with_fidelity(mesh, penalty, name, x, options, "free", history)


def check_landmarks(
    n: int, vertices: ArrayLike, targets: ArrayLike, weights: ArrayLike
) -> LandmarkEnergy:
    """Landmarks of a mesh of `n` vertices as a penalty; a MeshError that names a wrong one, and why.

    >>> check_landmarks(4, [0, 2], [[0, 0, 2], [1, 0, 0]], 3.0).targets
    array([[0., 0., 1.],
           [1., 0., 0.]])
    """
    index = plain_array(vertices, "landmarks")
    if index.ndim != 1 or not len(index) or index.dtype.kind not in "iu":
        raise MeshError(
            "landmarks are not a list of vertex indices; give one whole number each, at least one"
        )
    bad = np.flatnonzero((index < 0) | (index >= n))
    if len(bad):
        raise MeshError(f"landmark {bad[0]} is vertex {index[bad[0]]}; give one from 0 to {n - 1}")
    y = check_directions(targets, name="landmark targets")
    if len(y) != len(index):
        raise MeshError(f"{len(index)} landmarks have {len(y)} targets; give one row each")
    w = real_array(weights, "landmark_weights").astype(np.float64)
    if w.shape not in ((), index.shape):
        raise MeshError(
            f"landmark_weights have shape {w.shape}; give one number, or one for each of {len(index)} "
            "landmarks"
        )
    w = np.broadcast_to(w, index.shape)
    bad = np.flatnonzero(~np.isfinite(w) | (w < 0))
    if len(bad):
        raise MeshError(
            f"the weight of landmark {bad[0]} is {w[bad[0]]:g}; give a finite one, not negative"
        )
    return LandmarkEnergy(index.astype(np.int64), unit_rows(y), w)


def match_landmarks(
    x: FloatArray, landmarks: LandmarkEnergy, stiffness: float = 1e-3
) -> FloatArray:
    """Moebius map of `x` that brings landmarks closest to their targets.

    The stiffness weighs the squared length of the boost against the mean squared miss: two or three landmarks could be
    matched exactly by a boost that crowds everything else.

    >>> x = np.vstack((np.eye(3), -np.eye(3)))
    >>> goal = check_landmarks(6, np.arange(6), moebius(x, [0.1, 0.3, 0.0]), 1.0)
    >>> found = match_landmarks(x, goal, stiffness=0.0)
    >>> bool(np.allclose(found, goal.targets, atol=1e-6))
    True
    """
    from scipy.optimize import least_squares  # takes .2 s, which maps without landmarks don't need

    w = landmarks.weights + TINY
    share = np.sqrt(w / w.sum())[:, None]

    def moved(points: FloatArray, boost: FloatArray) -> FloatArray:
        size = float(np.linalg.norm(boost))
        if size:
            boost = boost * (np.tanh(size) / size)
        return moebius(points, boost * (1 - 1e-12))

    def misses(boost: FloatArray) -> FloatArray:
        y = moved(x[landmarks.vertices], boost)
        y = y @ best_rotation(y, landmarks.targets, w)
        return np.append((share * (y - landmarks.targets)).ravel(), np.sqrt(stiffness) * boost)

    boost = least_squares(misses, np.zeros(3)).x
    y = moved(x, boost)
    return unit_rows(y @ best_rotation(y[landmarks.vertices], landmarks.targets, w))


def descend(
    mesh: Mesh,
    problem: Problem,
    name: str,
    x: FloatArray,
    options: Variational,
    tolerance: float,
    gauge: PaperGauge,
    history: History,
) -> SphereMap:
    """Minimise a problem's energy by Algorithm 1, and repair its folds, unless these are allowed.

    If the map has shrunk to a point, the run begins again, and no step may fold.
    """
    rounds: list[Round] = []
    for steps_may_fold in (True, False):
        last, record = minimize_round(
            mesh,
            name,
            x,
            cayley_bb(problem, x, Confined(mesh, problem, steps_may_fold)),
            Stage.ALGORITHM_1,
            round=len(rounds),
            tolerance=tolerance,
            max_iterations=options.max_iterations,
            plateau=options.plateau,
            listener=history,
        )
        rounds.append(record)
        if options.may_fold or record.status is not Status.COLLAPSED:
            break
    y, energy = problem.centred(last.x), HarmonicEnergy.of(mesh)
    run = Run(record.status, energy.evaluate(y)[0], rounds=tuple(rounds))
    is_free, is_stopped = not folded_faces(y, mesh.f).any(), record.status is Status.STOPPED
    if is_free or is_stopped or options.may_fold:
        found = in_gauge(mesh, y, run, gauge)
    else:
        found = repair_last(mesh, y, run, energy, gauge, keeps_its_place=True)
    return replace(found, run=history.complete(found.run, options.name, options.settings()))


def start_of(mesh: Mesh, start: ArrayLike | None) -> tuple[str, FloatArray]:
    """Name and map to start from: the given one, or the conformal map."""
    if start is None:
        return "conformal map", auto(mesh, Auto()).sphere
    return "given map", check_start(start, len(mesh.v))
