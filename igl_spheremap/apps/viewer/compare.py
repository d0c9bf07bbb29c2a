"""Surfaces side by side, such as both spheres of a registration, before and after."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ...draw.palette import Colour, sequential
from ...mesh.arrays import FloatArray, IntArray
from ...result.sphere_map import SphereMap
from ...shapes.features import FeatureSurface
from ...shapes.registration import Registration
from .app import App
from .body import Body, Legend
from .stage import Stage

#: In standard deviations: the ends of the colours of a feature.
_REACH = 2.0


@dataclass(frozen=True, eq=False)
class Part:
    """A surface inside the unit ball, its face colours, its folded faces, and points with their colour and size."""

    caption: str
    x: FloatArray
    f: IntArray
    colours: FloatArray
    folded: IntArray | None = None
    dots: Mapping[str, tuple[FloatArray, Colour, float]] = field(default_factory=dict)


class RowView(App):
    """Parts in a row, which turn together; the legend stands below the first."""

    def __init__(self, parts: Sequence[Part], legend: Legend | None = None) -> None:
        self.stage = Stage(1, len(parts), panel=0)
        for k, part in enumerate(parts):
            body = self.stage.place(0, k, Body(f"part {k}", part.x, part.f, lift=part.folded is not None))
            body.paint(part.colours, part.folded)
            for label, dots in part.dots.items():
                body.dots(label, *dots)
            body.caption, body.legend = part.caption, None if k else legend


def registration_view(
    moving: SphereMap, fixed: SphereMap, result: Registration, features: tuple[FloatArray, FloatArray] | None = None
) -> RowView:
    """The fixed sphere, and the moving one before and after, coloured by the first feature, or by depth."""
    surfaces = [FeatureSurface(one.mesh) for one in (moving, fixed)]
    if features is None:
        own, other = (surface.geometry[:, 1] for surface in surfaces)
    else:
        own, other = (s.standardize(each[:, 0]) for s, each in zip(surfaces, features, strict=True))
    ramp = sequential("depth" if features is None else "first feature", -_REACH, _REACH)
    first, last = (f"correlation {result.stages[k].correlation.mean():.3f}" for k in (0, -1))
    shown = (
        (f"the fixed sphere\n{len(fixed.vertices):,} vertices", fixed, other),
        (f"the moving sphere, before\n{len(moving.vertices):,} vertices, {first}", moving, own),
        (f"the moving sphere, after\n{result.map.certificate.foldings:,} folded faces, {last}", result.map, own),
    )
    return RowView(
        [Part(caption, one.sphere, one.faces, ramp.colours(values[one.faces].mean(axis=1)))
         for caption, one, values in shown], ramp)
