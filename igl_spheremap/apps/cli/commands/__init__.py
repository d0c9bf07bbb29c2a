"""The work of each command; `parser` has the table."""
