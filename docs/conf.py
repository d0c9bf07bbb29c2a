"""Sphinx configuration: `sphinx-build -W -b html docs OUT`, without network."""

import logging
import re
import shutil
from pathlib import Path

from numpydoc.xref import DEFAULT_LINKS
from sphinx_gallery.scrapers import figure_rst

from igl_spheremap import __version__

REFERENCE = Path(__file__).parent / "reference"
# Names that are gone shall leave no page behind.
shutil.rmtree(REFERENCE / "generated", ignore_errors=True)

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
# What an earlier build wrote beside its pages, and notebooks of the gallery, which are for download, are no pages.
exclude_patterns = ["_build", "jupyter_execute", "examples", "reproduction/*", "gallery/*.ipynb"]
default_role = "py:obj"

autosummary_generate = True
autodoc_typehints = "none"  # numpydoc's Parameters hold types and shapes
autodoc_member_order = "bysource"
numpydoc_show_class_members = False  # the template of classes lists them

# Names are written as users import them, or without the module that holds them; each has one page.
listed = {
    name.rpartition(".")[2]: f"{module}.{name}"
    for page in REFERENCE.glob("api*.md")
    for module, names in re.findall(
        r"currentmodule:: (\S+)\n(.*?)```", page.read_text("utf-8"), re.DOTALL
    )
    for name in re.findall(r"^   ([\w.]+)$", names, re.MULTILINE)
}
numpydoc_xref_param_type = True
# but the classes of the API: numpydoc's own links lead to pages of the network
numpydoc_xref_ignore = "all"
numpydoc_xref_aliases = {word: word for word in DEFAULT_LINKS}
numpydoc_xref_aliases |= {name: full for name, full in listed.items() if name[0].isupper()}

myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 4
nb_execution_mode = "off"  # the notebooks hold their outputs, which a test compares with a run


def link_names(app, env, node, content):
    """A name in backticks as the API has it, wherever the docstring stands that writes it."""
    head, _, member = node["reftarget"].partition(".")
    if node.get("refdomain") == "py" and head in listed:
        target = ".".join(filter(None, (listed[head], member)))
        return env.domains["py"].resolve_xref(
            env, node["refdoc"], app.builder, "obj", target, node, content
        )
    return None


def link_pages(app, what, name, obj, options, lines):
    """Pages of this documentation that docstrings name."""
    lines[:] = [re.sub(r"`*(docs/(\w+)\.md)`*", r":doc:`\1 </\2>`", line) for line in lines]


def shorten_signature(app, what, name, obj, options, signature, returns):
    """Defaults that are made anew for each record."""
    return signature and signature.replace("<factory>", "..."), returns


def setup(app):
    app.connect("missing-reference", link_names)
    app.connect("autodoc-process-docstring", link_pages, priority=900)  # after numpydoc
    app.connect("autodoc-process-signature", shorten_signature)


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
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_domain_indices = False  # of modules: names are listed without them
