"""Results of public functions: public records that print in one line."""

import ast
import inspect
import json
import re
from dataclasses import is_dataclass
from enum import Enum
from importlib import import_module
from pathlib import Path
from typing import get_args, get_type_hints

import numpy as np
import pytest
from corpus import ROOT
from doors import PUBLIC

import igl_spheremap as ism
from igl_spheremap.maps.sphere_map import SphereMap

REFERENCE = "".join(
    path.read_text("utf-8") for path in (ROOT / "docs" / "reference").glob("api*.md")
)
V, F = ism.samples.make("spheroid", n_vertices=300)
CLASSES = [one for one in PUBLIC.values() if inspect.isclass(one)]


def own(hint):
    """Classes of the package in a type hint."""
    if inspect.isclass(hint) and hint.__module__.startswith("igl_spheremap"):
        yield hint
    for part in get_args(hint):
        yield from own(part)


def hints(name):
    """The types of a function's result, or of all that an instance of a class holds and its methods return."""
    public = PUBLIC[name]
    if inspect.isfunction(public):
        return [get_type_hints(public, localns={"SphereMap": SphereMap})["return"]]
    if not inspect.isclass(public):
        return []
    members = [
        value.fget if isinstance(value, property) else value
        for key, value in vars(public).items()
        if not key.startswith("_")
    ]
    results = [
        get_type_hints(member).get("return") for member in members if inspect.isfunction(member)
    ]
    return [*results, *get_type_hints(public).values()]


@pytest.mark.parametrize("name", PUBLIC)
def test_records_that_come_from_public_names_are_public_or_in_the_reference(name):
    documented = {
        getattr(import_module(f"{door}.{module}"), record)
        for door, listed in re.findall(r"currentmodule:: (\S+)\n(.*?)```", REFERENCE, re.DOTALL)
        for module, record in re.findall(r"^   ([\w.]+)\.([A-Z]\w+)$", listed, re.MULTILINE)
    }
    assert {one for hint in hints(name) for one in own(hint)} <= {*CLASSES, *documented}


#: Data that may be left out: faces of what has its own, the positions where no values are given, a regular sphere; and
#: the name of a structure of polyscope, which comes second there, too.
LEFT_OUT = {"f", "values", "target", "template", "name"}


def functions():
    """Public functions and methods by their names, and classes whose instances users make of data."""
    for name, public in PUBLIC.items():
        if inspect.isfunction(public):
            yield name, public
        elif inspect.isclass(public):
            if not is_dataclass(public) and not issubclass(public, Exception | Enum | tuple):
                yield name, public.__init__
            yield from (
                (f"{name}.{key}", value)
                for key, value in vars(public).items()
                if inspect.isfunction(value) and not key.startswith("_")
            )


@pytest.mark.parametrize(("name", "function"), [*functions()])
def test_options_go_by_name_after_the_data(name, function):
    parameters = inspect.signature(function).parameters.values()
    placed = {
        one.name
        for one in parameters
        if one.kind is not one.KEYWORD_ONLY and one.default is not one.empty
    }
    assert placed <= LEFT_OUT


@pytest.mark.parametrize(("name", "function"), [*functions()])
def test_roles_have_one_word_each(name, function):
    assert not {"moving", "fixed", "a", "b", "to"} & inspect.signature(function).parameters.keys()


def test_records_print_in_one_line(tmp_path):
    iterates, recording = [], ism.Recording(F)
    result = ism.spherical_conformal_map(V, F, listener=iterates.append)
    ism.spherical_conformal_map(V, F, listener=recording)
    registered = ism.shapes.register(result, result, stages=("rotation",))
    shape = ism.shapes.spherical_harmonics(result, degree=2)
    locator = ism.SphereLocator(result.sphere, F)
    ism.write_mesh(tmp_path / "a.ply", V, F)
    records = [
        result, result.run, result.mesh, result.mesh.edges, result.certificate, iterates[0], iterates[0].step,
        recording, recording.frames[0], registered, *registered.stages, *registered.candidates, shape, shape.source,
        shape.align(), ism.weighted_eigen_projection(V, F, result.sphere), locator, locator.locate(np.eye(3)),
        ism.texture_atlas(result.sphere, F), ism.resample(result, "ico:1"), ism.repair_mesh(V, F),
        ism.write_map(tmp_path / "a.npz", result), ism.read_mesh(tmp_path / "a.ply"), ism.SphereMapper(V, F),
        *(record() for record in (ism.Auto, ism.Lai2014, ism.GuYau, ism.Stereographic, ism.Effort)),
    ]  # fmt: skip
    for record in records:
        line = repr(record)
        assert line.startswith(f"{type(record).__name__}(")
        assert "\n" not in line
        assert len(line) < 250


@pytest.mark.parametrize(("door", "page"), [(ism, "api"), (ism.shapes, "api_shapes")])
def test_the_stub_has_the_order_of_the_reference(door, page):
    listed = re.findall(
        r"^   (\w+)$", (ROOT / "docs" / "reference" / f"{page}.md").read_text("utf-8"), re.MULTILINE
    )
    stub = re.findall(
        r"import (\w+) as", Path(door.__file__).with_suffix(".pyi").read_text("utf-8")
    )
    assert [name for name in stub if name in listed] == [name for name in listed if name in stub]
    assert {*stub} - {*listed} <= {"samples", "shapes"}


#: What a reader copies: demos, examples but for what draws their pictures, and the code of guides.
COPIED = [
    *(ROOT / "demos").glob("*.py"),
    *(ROOT / "docs" / "examples").glob("plot_*.py"),
    *(ROOT / "docs" / "guide").glob("*.md"),
    *(ROOT / "docs" / "use").glob("*.md"),
    *(ROOT / "docs" / "notebooks").glob("*.ipynb"),
    ROOT / "docs" / "index.md",
    ROOT / "README.md",
]


def code_of(path):
    """The Python code of a script, a page or a notebook."""
    text = path.read_text("utf-8")
    if path.suffix == ".md":
        return "\n".join(
            re.findall(r"^```python[^\n]*\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
        )
    if path.suffix == ".ipynb":
        cells = json.loads(text)["cells"]
        return "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "code")
    return text


def is_public(name):
    """Whether `igl_spheremap.NAME`, with dots in it, is promised: what it leads to beyond a public name is its own."""
    first, _, rest = name.partition(".")
    if rest and first in ("shapes", "samples"):
        return rest.partition(".")[0] in getattr(ism, first).__all__
    return first in ism.__all__ or first in ("__version__", "pyvista")


@pytest.mark.parametrize("path", COPIED, ids=lambda path: path.stem)
def test_what_a_reader_copies_has_public_names_only(path):
    used = set()
    for node in ast.walk(ast.parse(code_of(path))):
        if isinstance(node, ast.ImportFrom) and node.module:
            used |= {f"{node.module}.{alias.name}" for alias in node.names}
        elif isinstance(node, ast.Import):
            used |= {alias.name for alias in node.names}
        elif isinstance(node, ast.Attribute):
            used.add(re.sub(r"^ism\.", "igl_spheremap.", ast.unparse(node)))
    names = [
        name.partition(".")[2] for name in used if re.fullmatch(r"igl_spheremap(\.\w+)+", name)
    ]
    assert [name for name in names if not is_public(name)] == []


def test_a_private_name_would_be_noticed():
    assert is_public("shapes.match")
    assert is_public("Lai2014.as_printed")
    for name in ("apps.viewer.player", "shapes.groups", "samples.revolution", "draw"):
        assert not is_public(name)
