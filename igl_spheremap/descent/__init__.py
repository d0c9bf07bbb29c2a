"""How an energy is minimised: one loop, with any energy, metric and solver."""
