"""Sphinx configuration: `sphinx-build -W -b html docs OUT`, without network."""

import shutil
from pathlib import Path

from igl_spheremap import __version__

# Names that are gone shall leave no page behind.
shutil.rmtree(Path(__file__).parent / "reference" / "generated", ignore_errors=True)

project = "igl_spheremap"
author = "the igl_spheremap authors"
copyright = f"2026, {author}"
release = version = __version__

extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx.ext.viewcode",
]
templates_path = ["_templates"]
exclude_patterns = ["_build"]
default_role = "py:obj"

autosummary_generate = True
autodoc_typehints = "none"  # numpydoc's Parameters hold types and shapes
autodoc_member_order = "bysource"
numpydoc_show_class_members = False  # the template of classes lists them
numpydoc_xref_param_type = False

myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 4

html_theme = "furo"
html_title = f"igl_spheremap {release}"
html_copy_source = False
