"""The mark of a result: one line of ASCII with its source, method and options, which is the same for every run."""

from __future__ import annotations

import gzip
import hashlib
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from .._version import __version__
from ..errors import MeshError
from ..mesh.arrays import FloatArray, IntArray
from ..result.sphere_map import SphereMap
from .reading import reading
from .records import PathLike

_LONGEST = 80  # bytes of an STL header; FreeSurfer's programs take 199 of a comment
_HEAD = 4096  # every writer puts the mark within so many bytes
_MARK = re.compile(rb"igl_spheremap( [!-~]+){3} [0-9a-f]{24}")


def make_mark(v: FloatArray, f: IntArray, method: str, options: Mapping[str, Any]) -> str:
    """The mark of the map of this mesh: program, version, method, options, and a digest of the mesh.

    Options that do not fit are replaced by their digest.

    Examples
    --------
    >>> make_mark(np.zeros((3, 3)), np.arange(3)[None], "auto", {"polish": "angles"}).split()[2:]
    ['auto', 'polish=angles', '47ae891934ca4ae3d3970f3e']
    """
    positions, faces = np.asarray(v, dtype="<f8"), np.asarray(f, dtype="<i8")
    digest = _digest(b"%d " % len(positions) + positions.tobytes() + faces.tobytes())
    asked = ",".join(f"{key}={_text(value)}" for key, value in sorted(options.items())) or "-"
    line = f"igl_spheremap {__version__} {method} {asked} {digest}"
    if len(line) <= _LONGEST and re.fullmatch(r"[\w.,=+-]+", asked, re.ASCII):
        return line
    return f"igl_spheremap {__version__} {method} {_digest(asked.encode())[:16]} {digest}"


def mark_of(result: SphereMap) -> str:
    """The mark of a result."""
    return make_mark(result.vertices, result.faces, result.method, result.settings)


def read_mark(path: PathLike) -> str | None:
    """The mark of a file that this package wrote; None if it has none.

    Parameters
    ----------
    path : str or path-like
        A file of any format that `write_map` writes.

    Returns
    -------
    str or None
        ``igl_spheremap VERSION METHOD OPTIONS DIGEST``, the last of the source's positions and faces.

    Raises
    ------
    FileError
        If the file can't be opened.

    Examples
    --------
    >>> import tempfile
    >>> import igl_spheremap as ism
    >>> from igl_spheremap.io import read_mark
    >>> result = ism.spherical_conformal_map(*ism.samples.make("spheroid", n_vertices=300))
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     check = ism.write_map(f"{folder}/sphere.obj", result)
    ...     mark = read_mark(f"{folder}/sphere.obj")
    >>> mark.split()[2]
    'auto'
    """
    path = Path(path)
    try:
        with reading(path), path.open("rb") as file:
            head = file.read(_HEAD)
            if head.startswith(b"\x1f\x8b"):
                file.seek(0)
                head = gzip.GzipFile(fileobj=file).read(_HEAD)
    except MeshError:  # damaged
        return None
    found = _MARK.search(head)
    return found[0].decode() if found else None


def _text(value: object) -> str:
    """A value of an option; of an array its digest."""
    return _digest(value.tobytes()) if isinstance(value, np.ndarray) else str(value)


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:24]
