"""Pictures of registered hemispheres beside their templates, with the same borders."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

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
from ...populations.page import LATERAL, Sheet, is_newer, share_certified
from ...populations.table import MAPPED, RegistrationRow
from ...resampling.transfer import transfer
from ..correspondence.registration import reflected
from .jobs import HemisphereJob
from .task import SphereRegistration
from .writer import SULC

#: Pixels of each view; greys of the deepest and the highest folds; the borders' colour.
_SIZE, _DARK, _LIGHT = 260, 0.35, 0.95
_BORDER = (0.8, 0.15, 0.1)
_REACH = 2.0  # standard deviations of depth to either side, where the greys end


def registration_sheet(
    rows: Sequence[RegistrationRow], jobs: Sequence[HemisphereJob], task: SphereRegistration
) -> Sheet:
    """The pictures of registrations: each surface beside the template, both with the same borders."""
    by_target = {job.target: job for job in jobs}
    return Sheet(
        "Registered surfaces", f"{share_certified(rows)} registrations are certified free of foldings", "registrations",
        lambda row: partial(draw_registration, row, job=by_target[row.target], task=task), "borders",
        (("border", _BORDER), ("fold inwards", (_DARK,) * 3)),
        lambda row: f"correlation {1 - row.unlike:.3f}, areas {row.mean_area:.3g}"
                    + (f", {row.unsure:.0%} of the labels unsure" if np.isfinite(row.unsure) else ""),
        lambda row: "The surface, then the template, each from the side and from the middle, a row for each template; "
                    "borders are the template's.",
        lambda row: ("view", row.source, row.target),
    )  # fmt: skip


def draw_registration(
    row: RegistrationRow, path: str, job: HemisphereJob, task: SphereRegistration
) -> bool:
    """Draw a surface beside each of its templates with the template's borders, unless the picture is newer."""
    if row.status not in MAPPED:
        return False
    if is_newer(path, task.place(row.target)):
        return True
    given, _, v = task.surface(job)
    side = LATERAL[job.hemisphere.other if task.reflect else job.hemisphere.structure].T
    drawn = []
    for k, registered in enumerate(job.targets[: len(job.templates)]):
        own = sphere_map(v, given.f, read_sphere(task.place(registered)).v)
        own, template = reflected(own) if task.reflect else own, task.template(job, k)
        atlas = next((atlas for atlas in job.atlases if atlas.template == k), None)
        depth = depth_potential(template.vertices, template.faces, ell=SULC)
        regions = (
            (depth > 0).astype(np.int64)
            if atlas is None
            else next(iter(read_scalars(task.place(atlas.path)).values())).astype(np.int64)
        )
        pairs = ((own, transfer(template, regions, own, labels=True)), (template, regions))
        drawn.append(
            np.concatenate([_picture(surface, labels, side) for surface, labels in pairs], axis=1)
        )
    write_picture(path, np.concatenate(drawn), force=True)
    return True


def _picture(surface: SphereMap, labels: IntArray, view: FloatArray) -> NDArray[np.uint8]:
    """Draw both sides of a surface, grey by its folds, with the borders of labels."""
    v, f = surface.vertices, surface.faces
    depth = depth_potential(v, f, ell=SULC)
    grey = np.clip(depth[f].mean(axis=1) / (2 * _REACH * depth.std()) + 0.5, 0, 1)
    colours = np.tile((_DARK + (_LIGHT - _DARK) * grey)[:, None], (1, 3))
    colours[np.ptp(labels[f], axis=1) > 0] = _BORDER
    return both_sides([v], f, colours, view, _SIZE)
