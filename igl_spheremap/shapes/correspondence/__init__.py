"""Corresponding points of two surfaces: maps between surfaces, and registration."""

#: The stages of a registration, in their order, and those of the default.
STAGES = ("rotation", "moebius", "elastic")
USUAL = ("rotation", "elastic")
#: Weight of the strains in a registration by default: lower ones raise the correlation and not the precision.
STIFFNESS = 0.5
