"""Pictures of registered hemispheres beside their templates, with the same borders."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...draw.plot import both_sides
from ...features.feature_surface import depth_potential
from ...io.files import read_sphere
from ...io.pictures import write_picture
from ...io.scalars import read_scalars
from ...maps.given_sphere import sphere_map
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray
from ...populations.page import LATERAL, Sheet, is_newer, share_certified, view_words
from ...populations.table import MAPPED, RegistrationRow
from ...resampling.transfer import transfer
from ..correspondence.registration import reflected
from .jobs import HemisphereJob
from .task import SphereRegistration
from .writer import SULC

_BORDER = (0.8, 0.15, 0.1)
_GREYS = (0.35, 0.95)  # of the deepest and the highest folds


def registration_sheet(
    rows: Sequence[RegistrationRow], jobs: Sequence[HemisphereJob], task: SphereRegistration
) -> Sheet:
    """The pictures of registrations: each surface beside the template, both with the same borders."""
    by_target = {job.target: job for job in jobs}

    def text(row: RegistrationRow) -> str:
        said = f"correlation {1 - row.unlike:.3f}, areas {row.mean_area:.3g}"
        if np.isfinite(row.unsure):
            said += f", {row.unsure:.0%} of the labels unsure"
        return said

    return Sheet(
        title="Registered surfaces",
        heading=f"{share_certified(rows)} registrations are certified free of foldings",
        nouns="registrations",
        draw=lambda row: partial(draw_registration, row, job=by_target[row.target], task=task),
        look="borders",
        legends=(("border", _BORDER), ("fold inwards", (_GREYS[0],) * 3)),
        text=text,
        caption=lambda row: (
            "The surface, then the template, each from the side and from the middle, a row for each template; "
            "borders are the template's."
        ),
        command=view_words,
    )


def draw_registration(
    row: RegistrationRow, path: str, job: HemisphereJob, task: SphereRegistration
) -> bool:
    """Draw a surface beside each of its templates with the template's borders, unless the picture is newer."""
    if row.status not in MAPPED:
        return False
    if is_newer(path, task.place(row.target)):
        return True
    given, _, v = task.surface(job)
    structure, drawn = job.hemisphere.structure, []
    if task.reflect:
        structure = job.hemisphere.other
    side = LATERAL[structure].T
    for k, registered in enumerate(job.targets[: len(job.templates)]):
        own = sphere_map(v, given.f, read_sphere(task.place(registered)).v)
        if task.reflect:
            own = reflected(own)
        template = task.template(job, k)
        depth = depth_potential(template.vertices, template.faces, ell=SULC)
        regions: NDArray[Any] = depth > 0
        for atlas in job.atlases:
            if atlas.template == k:
                regions = next(iter(read_scalars(task.place(atlas.path)).values()))
                break
        regions = regions.astype(np.int64)
        pairs = ((own, transfer(template, regions, own, labels=True)), (template, regions))
        drawn.append(
            np.concatenate([_picture(surface, labels, side) for surface, labels in pairs], axis=1)
        )
    write_picture(path, np.concatenate(drawn), force=True)
    return True


def _picture(
    surface: SphereMap, labels: IntArray, view: FloatArray, size: int = 260, reach: float = 2.0
) -> NDArray[np.uint8]:
    """Draw both sides of a surface with the borders of labels, grey by its folds, `reach` standard deviations away."""
    v, f = surface.vertices, surface.faces
    depth = depth_potential(v, f, ell=SULC)
    dark, light = _GREYS
    grey = np.clip(depth[f].mean(axis=1) / (2 * reach * depth.std()) + 0.5, 0, 1)
    colours = np.tile((dark + (light - dark) * grey)[:, None], (1, 3))
    colours[np.ptp(labels[f], axis=1) > 0] = _BORDER
    return both_sides([v], f, colours, view, size)
