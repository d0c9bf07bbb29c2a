"""Local repair of foldings, at a cost that depends on their surroundings only."""

from __future__ import annotations

import numpy as np

from ..mesh.arrays import FloatArray, IntArray
from ..mesh.check import Mesh
from ..mesh.measure import surface_area
from ..sphere.gauge import fix_gauge
from ..sphere.rows import weighted_sum
from ..start.punctured import is_coarse
from ..verify.certificate import Certificate, certify_checked
from ..verify.distortion import mean_angle_difference
from .embedding import Watch, dilate, fix_orientation, progressive_embedding
from .nudge import nudge
from .relax import AngleLoss, descend

#: Share of the faces up to which foldings are undone where they are. Measured: with 1 percent folded that leads to
#: maps as good as from angles at a quarter of the cost, with 2 percent (hairy sphere) to 3.3 degrees instead of 1.1.
FEW = 0.01
#: Rings around what embedding moved that are relaxed with it.
RELAXED_RINGS = 2
#: If the centroid is farther than this from the origin, the map is centred even where rounding then folds faces.
_OFF_CENTRE = 1e-3
#: A repair is rejected if the mean angle difference grows by more than this factor.
WORSE = 1.05


def has_few_foldings(certificate: Certificate, f: IntArray) -> bool:
    """True if the foldings are to be undone locally: at most one percent of the faces, and degree 1."""
    return certificate.foldings <= max(1.0, FEW * len(f)) and certificate.degree == 1


def repair_locally(mesh: Mesh, x: FloatArray, watch: Watch | None = None) -> FloatArray:
    """Unfold faces by small moves, embed the vertices of those that are left, and relax what moved: free of foldings.

    `watch` is called with the map after each round of small moves, and after each batch of embedded vertices.
    """
    x = fix_orientation(x, mesh.f)
    y = progressive_embedding(nudge(x, mesh.f, watch), mesh.f, watch)
    moved = dilate(mesh.f, (y != x).any(axis=1), RELAXED_RINGS)
    around = mesh.f[moved[mesh.f].any(axis=1)]
    return descend(y, around, AngleLoss.of(mesh.v, around), moved, sweeps=30, tolerance=0.01)


def restore_gauge(mesh: Mesh, x: FloatArray) -> FloatArray:
    """Put a certified map back into the package's gauge, which the repair has left, and certify it again.

    Returns `x` itself where the Moebius map would fold it although its centroid is nearly at the origin, or would spoil
    the angles of huge faces.
    """
    y = fix_gauge(mesh, x)
    free = certify_checked(y, mesh.f).folding_free
    if free and not is_coarse(surface_area(x, mesh.f)):
        return y
    if not free:
        if not is_off_centre(mesh, x):
            return x
        y = repair_locally(mesh, y)
    worth = mean_angle_difference(mesh, y) < WORSE * mean_angle_difference(mesh, x)
    return y if worth and certify_checked(y, mesh.f).folding_free else x


def is_off_centre(mesh: Mesh, x: FloatArray) -> bool:
    """True if the centroid of the source's area is more than 1e-3 from the origin."""
    return float(np.linalg.norm(weighted_sum(mesh.A, x))) > _OFF_CENTRE
