"""Maps of surfaces with one boundary loop to the plane: to the unit disk, and with a free boundary."""
