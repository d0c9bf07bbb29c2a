"""One mapped surface laid on another: rotation, Moebius map, elastic deformation."""

STAGES = ("rotation", "moebius", "elastic")
