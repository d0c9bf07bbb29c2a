"""What a run gives: the map with its certificate, and the record of how it came about."""
