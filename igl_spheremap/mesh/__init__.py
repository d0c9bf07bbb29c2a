"""Triangle meshes: check, repair, edges and measures."""
