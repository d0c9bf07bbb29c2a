"""Maps between conformal and area-preserving: the energies, and certified Newton steps."""
