"""A registration: the target's sphere, and the source's before and after."""

from __future__ import annotations

from ...draw.palette import sequential
from ...features.feature_surface import FeatureSurface
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray
from ...shapes.correspondence.registration import Registration
from .colouring import Colouring
from .compare import PartsView
from .grid import Part


def registration_view(
    source: SphereMap, target: SphereMap, result: Registration, features: tuple[FloatArray, FloatArray] | None = None,
    name: str = "depth", reach: float = 2.0, width: float = 0.12,
) -> PartsView:  # fmt: skip
    """The target's sphere, and the source's before and after, coloured by the first feature or by depth.

    Colours end `reach` standard deviations away. The depth potential has a width that shows folds and limbs alike.
    """
    surfaces = [FeatureSurface(one.mesh) for one in (source, target)]
    if features is None:
        own, other = (s.standardize(s.potential(width)[:, None])[:, 0] for s in surfaces)
    else:
        own, other = (s.standardize(each[:, 0]) for s, each in zip(surfaces, features, strict=True))
    ramp = sequential(f"{name}, in standard deviations", -reach, reach)
    first, last = (f"correlation {result.stages[k].correlation.mean():.3f}" for k in (0, -1))
    shown = (
        (f"the target's sphere\n{len(target.vertices):,} vertices", target, other, (ramp,)),
        (
            f"the source's sphere, before\n{len(source.vertices):,} vertices, {first}",
            source,
            own,
            (),
        ),
        (
            f"the source's sphere, after\n{result.map.certificate.foldings:,} folded faces, {last}",
            result.map,
            own,
            (),
        ),
    )
    return PartsView([[
        Part(caption, one.sphere, one.faces, Colouring(ramp.colours(values[one.faces].mean(axis=1))), legends=legends)
        for caption, one, values, legends in shown
    ]])  # fmt: skip
