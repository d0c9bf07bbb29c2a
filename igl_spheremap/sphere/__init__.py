"""Geometry of the unit sphere.

Two stereographic projections are in use. The public one, `riemann.py`, is from the north pole to the plane of the
equator: the south pole goes to 0. Inside, `rows.to_chart` projects from the point opposite a pole to the plane that
touches the sphere at the pole, so that lengths near the pole stay. `log_plane.to_ball` inverts that for the north pole,
with half of its lengths and at any depth: 0 goes to the north pole, and the unit circle is the equator.
"""
