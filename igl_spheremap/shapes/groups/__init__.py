"""What many surfaces have in common: their template, their mean, their modes, and where groups of them differ."""

#: Members are left out that lie more than this many times the median distance from the mean: four standard deviations,
#: if one mode has all variance.
FARTHEST = 6.0
