"""Maps between conformal and area-preserving: the energies, and certified Newton steps."""

#: The balances with the least errors of lengths, mean |log ratio| of edges: on the sphere and the disk, for bodies and
#: cortices alike (at .85 those of 7 of 8 samples are below those at .8 and 1); and in the plane with a free boundary
#: (lengths of 14 open surfaces at .75 are off by 1 percent more, at .65 by as much).
ON_SPHERE, IN_PLANE = 0.85, 0.7
#: The ends of the scale. Functions that only map a surface keep angles by default. Functions that compare or expand
#: bodies keep areas: on conformal maps limbs have next to no room (docs/correspondence.md, docs/shapes.md).
CONFORMAL, AREA_PRESERVING = 0.0, 1.0
