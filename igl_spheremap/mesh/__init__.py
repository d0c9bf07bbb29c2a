"""The check of a mesh, and what is measured on a surface."""
