"""Files beside the package on it: bounds, versions, licences, and types that reach a user."""

import json
import re
import sys
from importlib.metadata import metadata, requires
from pathlib import Path

import pytest
import typed_client
from packaging.requirements import Requirement

from igl_spheremap import __version__

tomllib = (
    pytest.importorskip("tomllib") if sys.version_info >= (3, 11) else pytest.importorskip("tomli")
)
ROOT = Path(__file__).parent.parent
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
PROJECT = PYPROJECT["project"]
#: Of the linters, of what draws pages and of the peers any version will do that can be had.
UNPINNED = {
    "ruff",
    "mypy",
    "sphinx",
    "numpydoc",
    "furo",
    "myst-nb",
    "sphinx-gallery",
    "imageio-ffmpeg",
    "dask",
    "distributed",
    "ktch",
    "mne",
    "neuromaps",
    "nilearn",
    "nitransforms",
    "pyvista",
    "vtk",
}


def pins(name):
    """Versions of a constraints file by project."""
    lines = [
        line
        for line in (ROOT / ".ci" / name).read_text("utf-8").splitlines()
        if not line.startswith("#")
    ]
    return dict(line.split("==") for line in lines)


def parts(version):
    """A version as numbers, without zeros at its end."""
    return tuple(map(int, re.sub(r"(\.0)+$", "", version).split(".")))


def bounds():
    """The lower bounds of all dependencies and extras."""
    groups = [PROJECT["dependencies"], *PROJECT["optional-dependencies"].values()]
    found = [
        re.fullmatch(r"([\w.-]+)>=([\d.]+)(,<[\d.]+)?(;.*)?", line)
        for group in groups
        for line in group
        if "[" not in line
    ]
    assert all(found), "a dependency without a lower bound"
    return {match[1]: match[2] for match in found}


def test_each_lower_bound_is_the_oldest_version_that_is_tried():
    oldest = pins("oldest.txt")
    tried = {name: parts(version) for name, version in bounds().items() if name not in UNPINNED}
    assert tried == {name: parts(version) for name, version in oldest.items()}
    assert all(parts(pins("newest.txt")[name]) >= version for name, version in tried.items())


def test_citation_and_changelog_are_of_this_version():
    version = __version__.removesuffix(".dev0")
    citation, changelog = (
        (ROOT / name).read_text("utf-8") for name in ("CITATION.cff", "CHANGELOG.md")
    )
    newest, day = re.search(r"^## (\S+) \((.+)\)", changelog, re.M).groups()
    assert newest == version
    assert f"\nversion: {version}\n" in citation
    assert (day == "unreleased") == (version != __version__)
    assert day == "unreleased" or f"\ndate-released: {day}\n" in citation


def test_archive_and_paper_are_of_the_authors_and_the_title_of_the_citation():
    citation, deposit = (
        (ROOT / name).read_text("utf-8") for name in ("CITATION.cff", ".zenodo.json")
    )
    deposit = json.loads(deposit)
    own = citation.partition("preferred-citation")[0]
    said = pytest.importorskip("yaml").safe_load(own)["authors"]
    authors = [one.get("name") or f"{one['given-names']} {one['family-names']}" for one in said]
    assert [author["name"] for author in deposit["creators"]] == authors
    assert (
        re.findall(r"^  - name: (.+)$", (ROOT / "paper" / "paper.md").read_text("utf-8"), re.M)
        == authors
    )
    assert [author["name"] for author in PROJECT["authors"]] == authors
    assert f'\ntitle: "{deposit["title"]}"\n' in own
    assert f"\nversion: {deposit['version']}\n" in own
    assert f"\ndate-released: {deposit['publication_date']}\n" in own
    assert f"\nlicense: {deposit['license']}\n" in own
    assert PROJECT["license"] == deposit["license"]
    assert PROJECT["keywords"] == deposit["keywords"]


def test_the_conda_recipe_has_the_bounds_of_the_core():
    recipe = pytest.importorskip("yaml").safe_load(
        (ROOT / "recipe" / "recipe.yaml").read_text("utf-8")
    )
    assert recipe["context"]["version"] == __version__.removesuffix(".dev0")
    assert recipe["about"]["license"] == PROJECT["license"]
    wanted = {
        line.replace(">=", " >=").replace("libigl", "igl") for line in PROJECT["dependencies"]
    }
    assert set(recipe["requirements"]["run"]) - {"python >=${{ python_min }}"} == wanted


def test_the_workflow_runs_what_contributing_says_on_the_oldest_and_the_newest_versions():
    text = (ROOT / ".github" / "workflows" / "tests.yml").read_text("utf-8")
    jobs = pytest.importorskip("yaml").safe_load(text)["jobs"]
    contributing = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
    for command in (
        "python -m pytest",
        "ruff format --check && ruff check igl_spheremap tests demos benchmarks docs && mypy",
        "sphinx-build -W -b html docs docs/_build",
        ".ci/release",
    ):
        assert command in contributing
        assert f"- run: {command}" in text
    matrix = jobs["tests"]["strategy"]["matrix"]
    assert {name.split("-")[0] for name in matrix["system"]} == {"ubuntu", "windows", "macos"}
    assert [row["python"] for row in matrix["include"]] == matrix["python"]
    assert f">={matrix['python'][0]}" == PROJECT["requires-python"]
    assert all((ROOT / ".ci" / f"{row['versions']}.txt").exists() for row in matrix["include"])


def core(name, found):
    """Packages installed with a package, without extras."""
    if name not in found:
        found.append(name)
        for line in map(Requirement, requires(name) or []):
            if line.marker is None or line.marker.evaluate({"extra": ""}):
                core(line.name, found)
    return found


def licences(name):
    """A package's metadata; the text of a licence, which may quote others', only by its first line."""
    about = metadata(name)
    classes = [line for line in about.get_all("Classifier", []) if line.startswith("License")]
    expression = about.get("License-Expression")
    return [expression] if expression else classes or about["License"].split("\n")[:1]


def test_nothing_that_the_core_brings_is_under_the_gpl():
    names = [name for line in PROJECT["dependencies"] for name in core(Requirement(line).name, [])]
    assert {"libigl", "numpy", "scipy", "polyscope", "tqdm"} <= set(names)
    for name in names:
        said = " ".join(licences(name))
        assert said, name
        assert not re.search(r"GPL|General Public", said), (name, said)


def test_the_page_of_the_installation_lists_what_each_extra_brings():
    page = ROOT / "docs" / "guide" / "installation.md"
    rows = dict(re.findall(r"^\| `(\w+)` \| (.+) \|$", page.read_text("utf-8"), re.M))
    extras = PROJECT["optional-dependencies"]
    assert set(extras) <= set(rows)
    for extra, lines in extras.items():
        for line in map(Requirement, lines):
            for name in line.extras or {line.name}:
                assert re.search(rf"\b{name}\b", rows[extra], re.I), (extra, name)


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
