"""Surfaces that the reader of a page can turn: WebGL inside the page, without any download."""

from __future__ import annotations

import base64
import json
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files

import numpy as np
from numpy.typing import NDArray

from ..mesh.arrays import FloatArray, IntArray

#: More faces than this would make the page larger than 20 MB.
MOST_FACES = 150_000


@dataclass(frozen=True, eq=False)
class View:
    """A surface inside the unit ball, (n, 3), its face colours (m, 3) between 0 and 1, and a caption.

    A sphere can be magnified by a Moebius map.
    """

    caption: str
    x: FloatArray
    colours: FloatArray
    sphere: bool = False


def scene(f: IntArray, views: Sequence[View]) -> str:
    """HTML with views of the same faces side by side."""
    content = {
        "faces": _base64(f.astype("<u4")),
        "views": [
            {
                "caption": view.caption,
                "sphere": view.sphere,
                "positions": _base64(view.x.astype("<f4")),
                "colours": _base64(np.rint(255 * view.colours).astype(np.uint8)),
            }
            for view in views
        ],
    }
    code = files(__package__).joinpath("scene.js").read_text(encoding="utf-8")
    return f'<div class="scene" data-scene="{escape(json.dumps(content))}"></div><script>{code}</script>'


def _base64(array: NDArray[np.generic]) -> str:
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode("ascii")
