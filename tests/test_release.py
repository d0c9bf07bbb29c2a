"""What files beside the package say of it: bounds, versions, and types that reach a user."""

import re
import sys
from pathlib import Path

import pytest
import typed_client

from igl_spheremap import __version__

tomllib = pytest.importorskip("tomllib") if sys.version_info >= (3, 11) else pytest.importorskip("tomli")
ROOT = Path(__file__).parent.parent
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
PROJECT = PYPROJECT["project"]
#: Of the linters, of what draws pages and of the peers any version will do that can be had.
UNPINNED = {"ruff", "mypy", "sphinx", "numpydoc", "furo", "myst-parser", "sphinx-gallery", "imageio-ffmpeg", "dask",
            "distributed", "ktch", "mne", "neuromaps", "nilearn", "nitransforms", "pyvista", "vtk"}


def pins(name):
    """Versions of a constraints file by project."""
    lines = [line for line in (ROOT / ".ci" / name).read_text("utf-8").splitlines() if not line.startswith("#")]
    return dict(line.split("==") for line in lines)


def parts(version):
    """A version as numbers, without zeros at its end."""
    return tuple(map(int, re.sub(r"(\.0)+$", "", version).split(".")))


def bounds():
    """The lower bounds of all dependencies and extras."""
    groups = [PROJECT["dependencies"], *PROJECT["optional-dependencies"].values()]
    found = [re.fullmatch(r"([\w.-]+)>=([\d.]+)(;.*)?", line) for group in groups for line in group if "[" not in line]
    assert all(found), "a dependency without a lower bound"
    return {match[1]: match[2] for match in found}


def test_each_lower_bound_is_the_oldest_version_that_is_tried():
    oldest = pins("oldest.txt")
    tried = {name: parts(version) for name, version in bounds().items() if name not in UNPINNED}
    assert tried == {name: parts(version) for name, version in oldest.items()}
    assert all(parts(pins("newest.txt")[name]) >= version for name, version in tried.items())


def test_citation_and_changelog_are_of_this_version():
    version = __version__.removesuffix(".dev0")
    citation, changelog = ((ROOT / name).read_text("utf-8") for name in ("CITATION.cff", "CHANGELOG.md"))
    newest, day = re.search(r"^## ([\d.]+) \((.+)\)", changelog, re.M).groups()
    assert newest == version
    assert f"\nversion: {version}\n" in citation
    assert (day == "unreleased") == (version != __version__)
    assert day == "unreleased" or f"\ndate-released: {day}\n" in citation


@pytest.mark.parametrize("address", [None, "https://address.example"])
def test_no_link_of_the_long_description_is_relative(address):
    rule = PYPROJECT["tool"]["hatch"]["metadata"]["hooks"]["fancy-pypi-readme"]["substitutions"][0]
    replacement = rf"\1[\2]({address}/\3)" if address else rule["replacement"]
    text = re.sub(rule["pattern"], replacement, (ROOT / "README.md").read_text("utf-8"))
    links = re.findall(r"\]\(([^)]*)\)", text)
    assert links
    assert [link for link in links if not link.startswith("https://")] == []
    assert "docs/images/dino.png" in text


def test_a_typed_client_runs():
    assert typed_client.main() == "folding-free"
