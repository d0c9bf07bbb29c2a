"""One loop of minimisation, many energies and metrics."""
