"""What a person starts: commands, windows, reports, reproductions."""
