"""Maps of `v, f` to the sphere: the methods, their options, and the certified `SphereMap` that they return."""
