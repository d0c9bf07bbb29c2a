"""Repair of meshes: what is wrong, what a mesh is that can't be mapped, and how it becomes one that can."""

#: Largest tolerance of welding, in diagonals: the pairs within it still fit into memory, some 150 a vertex if a million
#: vertices of a sphere lay on open edges.
LARGEST_WELD = 0.01
