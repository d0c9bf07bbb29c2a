"""What each command does; `parser` has the table."""
