"""The version, in a file of its own: whatever writes it down imports nothing else."""

__version__ = "1.0.0rc2"
