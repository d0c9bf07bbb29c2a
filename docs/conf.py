"""Sphinx configuration: `sphinx-build -W -b html docs OUT`, without network."""

import logging
import shutil
from pathlib import Path

from sphinx_gallery.scrapers import figure_rst

from igl_spheremap import __version__

# Names that are gone shall leave no page behind.
shutil.rmtree(Path(__file__).parent / "reference" / "generated", ignore_errors=True)

# One of the packages of the theme prints whatever is logged, and examples log their phases.
logging.getLogger("igl_spheremap").setLevel(logging.WARNING)

project = "igl_spheremap"
author = "the igl_spheremap authors"
copyright = f"2026, {author}"
release = version = __version__

extensions = [
    "myst_nb",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "sphinx.ext.viewcode",
    "sphinx_gallery.gen_gallery",
]
templates_path = ["_templates"]
exclude_patterns = ["_build", "examples", "reproduction/*", "gallery/*.ipynb"]  # the gallery's are for download
default_role = "py:obj"

autosummary_generate = True
autodoc_typehints = "none"  # numpydoc's Parameters hold types and shapes
autodoc_member_order = "bysource"
numpydoc_show_class_members = False  # the template of classes lists them
numpydoc_xref_param_type = False

myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 4
nb_execution_mode = "off"  # the notebooks hold their outputs, which a test compares with a run


def figures(block, block_vars, gallery_conf):
    """The picture of a block of an example: its `figure`, which is drawn without pyplot."""
    figure = block_vars["example_globals"].pop("figure", None)
    if figure is None:
        return ""
    path = next(block_vars["image_path_iterator"])
    figure.savefig(path, dpi=150)
    return figure_rst([path], gallery_conf["src_dir"])


sphinx_gallery_conf = {
    "examples_dirs": "examples",
    "gallery_dirs": "gallery",
    "filename_pattern": "plot_",
    "ignore_pattern": "side_by_side",
    "image_scrapers": (figures,),
    "capture_repr": (),
    "reset_modules": (),  # no example changes matplotlib's state
    "within_subsection_order": "FileNameSortKey",
    "write_computation_times": False,
    "abort_on_example_error": True,
}

# The scraper is a function of this file, which each build reads anew; pages of the API list no examples.
suppress_warnings = ["config.cache", "sphinx_gallery.config"]

html_theme = "furo"
html_title = f"igl_spheremap {release}"
html_copy_source = False
