"""Bodies that stand in for cortices: their folds tell each place, and the same body comes on any mesh."""

from __future__ import annotations

import numpy as np

from igl_spheremap.io.write_mesh import write_mesh
from igl_spheremap.samples import sphere

#: Places of the bumps, which no turn and no mirror takes to each other, and their heights.
_BUMPS = np.array(
    [[0.9, 0.3, 0.3], [-0.2, 0.8, 0.6], [0.1, -0.5, 0.9], [-0.7, -0.6, 0.3], [0.4, 0.5, -0.8]]
)
_HEIGHTS = np.array([0.5, -0.35, 0.3, 0.45, -0.3])
#: What the stand-in of an atlas calls its labels.
NAMES = ("front", "back")


def body(x, scale=70.0):
    """The surface over directions x (n, 3), in mm."""
    bumps = _BUMPS / np.linalg.norm(_BUMPS, axis=1)[:, None]
    return scale * x * (1 + np.exp(-4 * (1 - x @ bumps.T)) @ _HEIGHTS)[:, None]


def turned(n):
    """Directions and faces of a mesh that shares no vertex with `sphere(n)`."""
    x, f = sphere(n)
    q, _ = np.linalg.qr([[0.3, 0.9, -0.2], [-0.5, 0.4, 0.8], [0.7, 0.1, 0.6]])
    return x @ (q * np.linalg.det(q)).T, f


def write_template(folder, size=642, hemi="lh"):
    """A template's surface, sphere and labels, on the left or mirrored; returns the value of `--to`."""
    x, f = sphere(size)
    mirror, g = (np.array([-1.0, 1, 1]), f[:, ::-1]) if hemi == "rh" else (np.ones(3), f)
    write_mesh(folder / f"{hemi}.pial", body(x) * mirror, g)
    write_mesh(folder / f"{hemi}.sphere", 100 * x * mirror, g)
    return f"mine={folder}/{{hemi}}.pial,{folder}/{{hemi}}.sphere"
