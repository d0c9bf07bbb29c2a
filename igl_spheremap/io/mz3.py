"""MZ3, the surfaces of Surf Ice and NiiVue, packed or not; float32. They are read only."""

from __future__ import annotations

from pathlib import Path

from ..errors import MeshError
from .reading import Bytes, unpacked
from .records import RawMesh, of_triangles


def read(path: Path, surface: int = 0b11) -> RawMesh:
    """Triangles and positions, behind a header and the bytes that it skips; colours and data are left out.

    The bits of `surface` say that a file holds both.
    """
    file = Bytes(unpacked(path), 2)
    if file.number("<u2") & surface != surface:
        raise MeshError(
            "it holds colours or data without their surface; give the file of the surface"
        )
    m, n, skipped = file.array("<u4", 3).tolist()
    file.take(skipped)
    faces = file.array("<i4", 3 * m).reshape(-1, 3)
    return RawMesh(file.array("<f4", 3 * n).reshape(-1, 3), of_triangles(faces))
