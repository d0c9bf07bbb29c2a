"""Certificates and distortion, by code that imports no solver."""
