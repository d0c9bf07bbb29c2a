"""Common features of many surfaces: their template, mean and modes, and differences of groups."""
