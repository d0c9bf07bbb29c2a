"""The front door: from `v, f` to a certified `SphereMap`."""
