"""Triangle meshes: check, repair, edges and measures."""

#: Largest tolerance of welding, in diagonals: pairs within it, some hundred a vertex on the finest meshes, still fit
#: into memory.
LARGEST_WELD = 0.01
