"""Triangle meshes: check, repair, edges and measures."""

#: Largest tolerance of welding, in diagonals: the pairs within it still fit into memory, some 150 a vertex if a million
#: vertices of a sphere lay on open edges.
LARGEST_WELD = 0.01
