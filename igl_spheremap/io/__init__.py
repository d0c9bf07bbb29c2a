"""Files: meshes, maps, data, coefficients and pictures; `formats.py` lists the formats of meshes."""
