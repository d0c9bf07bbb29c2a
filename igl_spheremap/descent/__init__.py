"""Minimisation of an energy: one loop, with any energy, metric and solver."""
