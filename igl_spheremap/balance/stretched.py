"""A start with room for limbs: Newton steps can't move faces whose images are as small as rounding."""

from __future__ import annotations

import numpy as np

from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..mesh.measure import FLOAT64_LIMIT, corner_angles, log_edges
from ..untangle.blocks import VertexBlocks
from ..untangle.deep_limbs import floors, shorten_limbs
from ..untangle.layout import onto_sphere, unroll
from ..untangle.local_repair import repair_locally
from ..verify.certificate import Certificate

#: No image edge of such a start is shorter than exp(-this): half of float64's digits are left to move it.
_FLOOR = floors(np.float32)[0]


def stretched(mesh: Mesh, x: FloatArray) -> FloatArray:
    """A map without foldings itself, or, if its shortest edges are rounding, one laid out anew with room for limbs."""
    if log_edges(x, mesh.f).min() > np.log(FLOAT64_LIMIT):
        return x
    laid_out = unroll(mesh, x, VertexBlocks(mesh.f))
    if laid_out is None:
        return x
    y = onto_sphere(laid_out, shorten_limbs(laid_out, corner_angles(mesh.v, mesh.f), _FLOOR).z)
    return y if Certificate.of(y, mesh.f).folding_free else repair_locally(mesh, y)
