"""Thousands of surfaces: one job a file, on one machine or on a cluster, with a manifest, a table and a page."""
