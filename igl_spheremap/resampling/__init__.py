"""Where a point lies on a map, and values, meshes and pictures carried to other points."""
