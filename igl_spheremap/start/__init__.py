"""First maps, which need no iteration."""
