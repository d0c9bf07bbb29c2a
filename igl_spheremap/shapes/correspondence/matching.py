"""Low-distortion maps between two surfaces, with landmarks met."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from ...balance import AREA_PRESERVING
from ...balance.balanced_spherical_map import balanced_spherical_map
from ...errors import FoldingsRemain, MapError, MeshError, Remedy, check_list, check_number, within
from ...features.feature_surface import FeatureSurface, check_varies
from ...gate import MeshLike, gate
from ...maps.given_sphere import certified
from ...maps.sphere_map import SphereMap
from ...maps.variational import check_landmarks, match_landmarks
from ...mesh.arrays import FloatArray, listed_words
from ...resampling.locate import locator_of
from ...resampling.transfer import interpolate
from ...result.run import History, Iterate, Listener, Stage
from ...sphere.rows import unit_rows
from ...timings import timed
from ...untangle.local_repair import unfolded
from .descent import Descent, Objective
from .features import FeaturePair
from .landmarks import LandmarkPairs, Points
from .levels import Level
from .registration import reflected
from .stretch import LOST, Distortion
from .surface_map import SurfaceMap

#: Shares of the surfaces' metrics, beside the spheres', in turn; each with radians that features are smoothed by.
_SHARES = {0.25: 0.5, 0.5: 0.3, 0.75: 0.2, 0.9: 0.12, 0.97: 0.07, 1.0: 0.04}
#: Width of the features' smoothing for rotations and Moebius maps.
_WIDTH = 0.05


@gate
@timed()
def match(
    source: SphereMap | MeshLike,
    target: SphereMap | MeshLike,
    *,
    landmarks: tuple[Points, Points] | None = None,
    features: tuple[ArrayLike, ArrayLike] | None = None,
    curves: Iterable[tuple[Points, Points]] = (),
    feature_weight: float = 0.4,
    soft: bool = False,
    reflect: bool = False,
    listener: Listener | None = None,
) -> SurfaceMap:
    """Map one closed genus-0 surface onto another: bijectively, with low distortion, landmarks met.

    The map goes through the sphere, and minimises the strain of the source's faces on the target: angles and areas
    alike, docs/correspondence.md. Every iterate is free of foldings, by exact signs.

    Parameters
    ----------
    source, target : SphereMap, (v, f) or another mesh object
        The surfaces with their maps, best area-preserving ones; meshes are mapped at balance 1.
    landmarks : (points of the source, points of the target), optional
        Points that belong together, the same number of either: (k,) vertex indices, or a `Location`. They are met bit
        for bit on the sphere; three and more of them decide how the surfaces face each other. At points that are not
        vertices the source's faces are divided.
    features : (the source's values, the target's values), optional
        Data over the vertices of each, (n,) or (n, k) with the same k, that are to agree. They are smoothed on the
        surfaces and compared at unit variance. Without them curvature and depth choose starts and guide the descent,
        except in its last steps on each mesh.
    curves : iterable of (curve of the source, curve of the target), optional
        Curves that belong together, such as ridges and sulci: points as for landmarks, each next to the one before it,
        two or more; the numbers may differ. Each point of the source's curve is a landmark, which goes to the point of
        the target's curve at the same share of length. Between these points the distance of the curves is at most about
        that of neighbouring points.
    feature_weight : float
        Weight of the features' squared differences beside the strain, both summed over an area of 4 pi; .4 by default.
    soft : bool
        Draw landmarks together instead of meeting them, if they may contradict each other.
    reflect : bool
        Mirror the source and its map (x to -x), and reverse its faces: for left and right sides of a body.
    listener : callable, optional
        Called with an `Iterate` after every step on the source's own mesh; may raise StopIteration to stop with the
        current map.

    Returns
    -------
    SurfaceMap
        The source's map in the frame of the target's, certified, and its consequences.

    Raises
    ------
    MeshError
        If a mesh, a landmark, a curve or a feature is invalid.
    FoldingsRemain
        If a given map is not certified folding-free.
    MapError
        If landmarks can't be met; the message names those that are furthest from their points.
    ValueError
        If the weight is negative.
    TypeError
        If the weight is not a number, or the listener can't be called.

    See Also
    --------
    register : of spheres, so that features agree.
    template : many surfaces in correspondence.
    transfer : data through two maps as they are.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> a, b = (ism.samples.make("pear", n_vertices=n) for n in (300, 420))
    >>> onto = ism.shapes.match(a, b, landmarks=([0, 100, 200], [0, 140, 280]))
    >>> onto.map.certificate.folding_free, bool(onto.landmark_errors.max() < 1e-12)
    (True, True)
    """
    history = History(listener)
    check_number(feature_weight, "feature_weight")
    source, target = _mapped(source, "the source"), _mapped(target, "the target")
    given = LandmarkPairs.of(landmarks, curves, source, target)
    if features is not None:
        of_source, of_target = check_list(features, "features", 2)
        features = given.carried(of_source, source), of_target
    divided = given.surface
    if reflect:
        divided = reflected(divided)
    goals = unit_rows(interpolate(target.sphere, target.faces, given.goals))
    own = Level.of(divided, "the source", given.vertices)
    descent = _descent(own, Level.of(target, "the target"), features, feature_weight, goals, soft)
    start = _start(own, descent, goals)
    level, x = _lowered(own, descent, start, history)
    result = certified(level.map.mesh, x)
    result = replace(result, run=history.complete(result.run, "match"))
    if not soft:
        _check_met(result, given, goals)
    onto = SurfaceMap(result, target, given.vertices, given.goals)
    return replace(onto, notes=tuple(_remarks(onto, len(source.sphere), len(divided.sphere))))


def _mapped(given: SphereMap | MeshLike, name: str) -> SphereMap:
    """The map of a surface, at balance 1 if it is a mesh; errors name the surface."""
    try:
        if not isinstance(given, SphereMap):
            return balanced_spherical_map(given, balance=AREA_PRESERVING)
        if given.certificate.folding_free:
            return given
        return certified(given.mesh, given.sphere)
    except (MeshError, FoldingsRemain, TypeError) as error:
        raise within(error, f"{name}: ") from None


def _descent(
    source: Level,
    target: Level,
    features: tuple[ArrayLike, ArrayLike] | None,
    weight: float,
    goals: FloatArray,
    soft: bool,
) -> Descent:
    """Plan the descent: from coarse levels to fine ones, on each with ever less weight of the spheres' metrics."""
    guide = last = weight
    if features is None:
        curved = [FeatureSurface(level.map.mesh).curvature_and_depth for level in (source, target)]
        for each, name in zip(curved, ("source", "target"), strict=True):
            check_varies(each, f"curvature and depth of the {name}")
        features = curved[0], curved[1]
        # strain alone pairs the folds of cortices wrongly (docs/correspondence.md)
        guide, last = 0.4, 0.0
    pair = FeaturePair(source, target, features, [_WIDTH, *_SHARES.values()])
    # The first size is fast enough for every start; from there to 10,000 and more vertices at once faces in limbs are
    # strained too much to come back.
    sizes = *(size for size in (642, 2562) if size <= len(source.map.sphere)), None
    plan = []
    for size, (share, width) in product(sizes, _SHARES.items()):
        objective = Objective(size, share, (width,), guide, guard=0.05, steps=5)
        if share == 1:  # a larger guard keeps the map off its minimum
            objective = objective._replace(weight=last, guard=0.01, steps=30)
        plan.append(objective)
    return Descent(source, target, plan, pair, goals, soft)


def _start(
    source: Level, descent: Descent, goals: FloatArray, stiffness: float = 1e-2
) -> FloatArray:
    """Turn the source's sphere by features, or by three and more landmarks, which determine a Moebius map.

    The stiffness is the weight of its squared boost beside the landmarks' mean squared distance.
    """
    if len(goals) < 3:
        return descent.start(_WIDTH, moebius=True)[0]
    held = check_landmarks(len(source.map.sphere), source.landmarks, goals, 1.0)
    return match_landmarks(source.map.sphere, held, stiffness)


def _lowered(
    source: Level, descent: Descent, start: FloatArray, history: History
) -> tuple[Level, FloatArray]:
    """Run the descent until its end, or until a listener stops it; return the level and the map on it."""
    found = source, unfolded(source.map.mesh, start)

    def take(objective: Objective, level: Level, y: FloatArray, energy: float) -> None:
        nonlocal found
        if objective.size is None:
            found = level, y
            history(Iterate(Stage.MATCH, 0, len(history.steps), y, energy))

    with suppress(StopIteration):  # of a listener
        found = descent.run(found[1], take)
    return found


def _check_met(result: SphereMap, given: LandmarkPairs, goals: FloatArray, named: int = 5) -> None:
    """Raise a MapError if a landmark missed its goal; it names those that are furthest off."""
    apart = np.degrees(
        2 * np.arcsin(np.linalg.norm(result.sphere[given.vertices] - goals, axis=1) / 2)
    )
    if not apart.any():
        return
    worst = np.argsort(-apart)[:named]
    worst = worst[apart[worst] > 0]
    names = listed_words([given.names[k] for k in worst], named)
    raise MapError(
        f"{np.count_nonzero(apart)} of {len(goals)} landmarks can't be met by these triangles without a "
        f"fold; furthest off, by {apart.max():.3g} degrees, is {names}: correct it, or give "
        f"{Remedy(options={'soft': True})}",
        result,
    )


def _remarks(onto: SurfaceMap, given: int, divided: int) -> Iterator[str]:
    """Note added vertices, and surfaces of which more than a twentieth is as good as lost."""
    if divided > given:
        yield f"faces of the source are divided at landmarks: {divided - given} vertices come after its own"
    if needed := len(onto.map.sphere) - divided:
        yield f"faces of the source are split where landmarks could not be met else: {needed} vertices come last"
    back = interpolate(
        onto.map.vertices, onto.map.faces, locator_of(onto.map).locate(onto.target.sphere)
    )
    for name, one, image in (("source", onto.map, onto.positions), ("target", onto.target, back)):
        figures = Distortion.of(one.vertices, image, one.faces, one.mesh.caps).figures[
            "over_source"
        ]
        strain = figures["symmetric_dirichlet"]
        if strain["p95"] > LOST:
            yield (
                f"the match is rough: {strain['above_100']:.0%} of the {name}'s area has a symmetric Dirichlet "
                f"energy above {LOST:g}, where 4 is an isometry; give points that belong together, "
                f"{Remedy(options={'landmarks': None})}, and maps at balance 1"
            )
