"""Repair of meshes: their faults and topology, and the steps that make them fit to be mapped."""

from typing import Any

#: Largest tolerance of welding, in diagonals: the pairs within it still fit into memory, some 150 a vertex if a million
#: vertices of a sphere lay on open edges.
LARGEST_WELD = 0.01
#: Relative differences below this are rounding of files, which keep six digits.
SIX_DIGITS = 1e-6
#: Options of repairs and their defaults, in the order in which these are made; a mesh has the first four.
REPAIRS: dict[str, Any] = {
    "weld": 0.0,
    "keep_largest": False,
    "holes": "refuse",
    "handles": "refuse",
    "rim": None,
    "cut": None,
}
