"""Hemispheres laid on a template, and its labels carried to them."""
