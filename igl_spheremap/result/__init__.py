"""Results: the map with its certificate, and the record of its run."""
