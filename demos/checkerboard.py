"""A checkerboard by a conformal chart of the sphere, whose squares are squares: Mercator's, with poles anywhere."""

from __future__ import annotations

import numpy as np

from igl_spheremap import Mesh
from igl_spheremap.apps.viewer.body import Body
from igl_spheremap.apps.viewer.window import linear
from igl_spheremap.mesh.arrays import FloatArray, IntArray
from igl_spheremap.sphere.rows import INFINITE, to_chart
from igl_spheremap.verify.distortion import mesh_conformal_factor

COLOURS = ((0.13, 0.32, 0.52), (0.95, 0.93, 0.86))

#: Cosine of the least angle between two poles that are chosen.
_APART = 0.5


def deepest_tips(mesh: Mesh, x: FloatArray) -> FloatArray:
    """Images (2, 3) of the tips of the two limbs that a map shrinks most, at least 60 degrees apart if possible.

    A chart with its poles there gives limbs squares down to the tip.
    """
    factor = mesh_conformal_factor(mesh, x)
    first = x[int(np.argmin(factor))]
    far = x @ first < _APART
    second = x[int(np.argmin(np.where(far, factor, np.inf)))] if far.any() else -first
    return np.vstack((first, second))


def mercator_corners(y: FloatArray, f: IntArray, poles: FloatArray) -> FloatArray:
    """Longitude and Mercator latitude (3 m, 2) of each corner of each face, in turns around the poles (2, 3).

    The north pole is first; the two need not be opposite to one another. A face across the date line has longitudes
    beyond it: there is no jump inside a face. A vertex at a pole has the latitude of the one next to it.

    >>> import numpy as np
    >>> y = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0.6, 0.8]])
    >>> poles = np.array([[0.0, 0, 1], [0, 0, -1]])
    >>> turns = mercator_corners(y, np.array([[0, 1, 2]]), poles)
    >>> float(turns[1, 0] - turns[0, 0]), bool(np.isclose(turns[2, 1], np.arctanh(0.8) / (2 * np.pi)))
    (0.25, True)
    """
    north, south = poles
    z = to_chart(y, -south[None, :]) - to_chart(north[None, :], -south[None, :])
    radius = np.abs(z) / 2  # cotangent of half the angle from the south, where the poles are opposite
    proper = (radius > 0) & (radius < INFINITE / 2)  # of vertices that lie at no pole
    radius = np.clip(radius, radius[proper].min(), radius[proper].max())
    longitude = (np.angle(z) / (2 * np.pi))[f]
    longitude = longitude - np.rint(longitude - longitude[:, :1])
    latitude = -np.log(radius) / (2 * np.pi)
    return np.column_stack((longitude.ravel(), latitude[f].ravel()))


def show_squares(body: Body, corners: FloatArray) -> None:
    """Show a checkerboard of unit squares in place of colours, by coordinates (3 m, 2) of the corners of faces."""
    body.mesh.add_parameterization_quantity(
        "checks",
        corners,
        defined_on="corners",
        viz_style="checker",
        checker_size=1.0,
        checker_colors=tuple(tuple(linear(np.array(colour))) for colour in COLOURS),
        enabled=True,
    )
    body.version += 1
