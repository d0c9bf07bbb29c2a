"""Programs for people: commands, windows, reports, reproductions."""
