"""The version, in its own file: programs that write it down import nothing else."""

__version__ = "1.0.0rc2"
