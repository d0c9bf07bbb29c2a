"""Low-distortion maps between two surfaces, with landmarks met."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import own_errstate
from ..maps.balanced import balanced_spherical_map
from ..maps.given_sphere import certified
from ..mesh.arrays import FloatArray
from ..result.run import Listener
from ..result.sphere_map import SphereMap
from ..shapes.features import SurfacePair
from ..shapes.locate import Location
from ..untangle.local_repair import repair_locally
from ..verify.certificate import Certificate
from .fits import fit_moebius
from .registration import reflected
from .surface_map import SurfaceMap

_WIDTH = 0.05  # radians that the features are smoothed by for rotation and Moebius map


@own_errstate
def match(
    a: SphereMap | tuple[ArrayLike, ArrayLike],
    b: SphereMap | tuple[ArrayLike, ArrayLike],
    landmarks: tuple[Any, Any] | None = None,
    features: tuple[ArrayLike, ArrayLike] | None = None,
    *,
    position_weight: float = 0.0,
    soft: bool = False,
    reflect: bool = False,
    listener: Listener | None = None,
) -> SurfaceMap:
    """Map one closed genus-0 surface onto another with low distortion, bijectively.

    Parameters
    ----------
    a, b : SphereMap or (v, f)
        The surfaces with their maps, preferably area-preserving; arrays are mapped at balance 1.
    reflect : bool
        Mirror A and its map (x to -x), and reverse its faces: for left and right sides of a body.

    Returns
    -------
    SurfaceMap
        A's map in the frame of B's, certified, and what follows from it.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> a, b = (ism.samples.make("pear", n_vertices=n) for n in (500, 700))
    >>> onto = ism.match(a, b)
    >>> onto.map.certificate.folding_free, onto.positions.shape == a[0].shape
    (True, True)
    """
    a, b = (each if isinstance(each, SphereMap) else balanced_spherical_map(*each, 1.0) for each in (a, b))
    a = reflected(a) if reflect else a
    pair = SurfacePair(a, b, features, [_WIDTH])
    candidates = tuple(pair.rotations())
    x = a.sphere @ candidates[0].rotation.T
    if not Certificate.of(x, a.faces).folding_free:
        x = repair_locally(a.mesh, x)
    found = [x]

    def keep(y: FloatArray, _: float) -> None:
        found[0] = y

    fit_moebius(x, a.faces, pair.weights, pair.features[0], pair.picture(0), keep)
    nothing = Location(np.empty(0, dtype=np.int64), np.empty((0, 3)))
    return SurfaceMap(certified(a.mesh, found[0]), b, nothing.face, nothing, candidates)
