"""Triangle meshes: check, edges and measures."""
