"""Mending of foldings: progressive embedding, relaxation, and the ladder that says which is used when."""
