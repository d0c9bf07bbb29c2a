"""The gate, and what is measured on a surface."""
