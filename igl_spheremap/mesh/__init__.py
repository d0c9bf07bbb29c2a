"""Triangle meshes: check, repair, edges and measures."""

#: Largest tolerance of welding, in diagonals: the pairs within it still fit into memory, some 150 a vertex if a million
#: vertices of a sphere lay on open edges.
LARGEST_WELD = 0.01
#: Vertices of a sample at most: a number with too many zeros ends in an error, and not in the swap file.
MOST_VERTICES = 1e9
