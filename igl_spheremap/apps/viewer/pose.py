"""How a surface stands before the camera."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

#: Directions that may be up, by the names that users give.
UPS = {"x": (1, 0, 0), "-x": (-1, 0, 0), "y": (0, 1, 0), "-y": (0, -1, 0), "z": (0, 0, 1), "-z": (0, 0, -1)}
_Y_UP = (".obj", ".glb", ".gltf")
_AZIMUTH, _ELEVATION = np.radians(28), np.radians(16)


def guess_up(name: str) -> str:
    """Which way is up in a file, by its format's custom.

    Parameters
    ----------
    name : str
        Of the file or sample.

    Returns
    -------
    str
        "y" for Wavefront OBJ and glTF, "z" else: anatomy, engineering and the samples.

    Examples
    --------
    >>> guess_up("bunny.obj"), guess_up("lh.pial"), guess_up("sample:dino")
    ('y', 'z', 'z')
    """
    return "y" if name.lower().endswith(_Y_UP) else "z"


def pose(v: FloatArray, up: str = "z") -> FloatArray:
    """Rotation to the viewer's axes: the broad side to the front, seen a little from above and aside.

    Parameters
    ----------
    v : (n, 3) float64 array
        Positions.
    up : str
        One of `UPS`.

    Returns
    -------
    (3, 3) float64 array
        Rows are the viewer's axes: right, up, and towards the viewer.

    Examples
    --------
    >>> import numpy as np
    >>> box = np.array([[0.0, 0, 0], [9, 0, 0], [9, 2, 0], [9, 2, 5]])
    >>> rotation = pose(box, "z")
    >>> bool(rotation[0] @ [1, 0, 0] > 0.8), bool(rotation[1] @ [0, 0, 1] > 0.9)
    (True, True)
    """
    vertical = np.array(UPS[up], dtype=np.float64)
    level = np.flatnonzero(vertical == 0)
    extent = np.ptp(v, axis=0)
    right = np.zeros(3)
    right[level[int(np.argmax(extent[level] * [1.0001, 1.0]))]] = 1.0  # of equal extents the first
    front = np.cross(right, vertical)
    axes = np.vstack((right, vertical, front))
    a, e = _AZIMUTH, _ELEVATION
    aside = np.array([[np.cos(a), 0, np.sin(a)], [0, 1, 0], [-np.sin(a), 0, np.cos(a)]])
    above = np.array([[1, 0, 0], [0, np.cos(e), -np.sin(e)], [0, np.sin(e), np.cos(e)]])
    return above @ aside @ axes


def fit(v: FloatArray, rotation: FloatArray) -> FloatArray:
    """Turn a surface and fit it into the unit ball.

    Parameters
    ----------
    v : (n, 3) float64 array
        Positions.
    rotation : (3, 3) float64 array
        From `pose`.

    Returns
    -------
    (n, 3) float64 array
        Centred at the middle of its bounding box; the farthest vertex has length 1.
    """
    w = v @ rotation.T
    w = w - (w.max(axis=0) + w.min(axis=0)) / 2
    return np.asarray(w / max(float(np.linalg.norm(w, axis=1).max()), 1e-300))
