"""Location of points on a map, and values, meshes and pictures carried to other points."""
