"""docs/equations.md tells the truth: each symbol it names is there, with the comment in its margin."""

import ast
import io
import re
import textwrap
import tokenize
from functools import cache
from pathlib import Path

import pytest

import igl_spheremap

PACKAGE = Path(igl_spheremap.__file__).parent
TABLE = PACKAGE.parent / "docs" / "equations.md"

pytestmark = pytest.mark.skipif(
    not TABLE.exists(), reason="the docs are not installed with the package"
)


def rows():
    """Cells of the table's rows."""
    lines = TABLE.read_text("utf-8").splitlines() if TABLE.exists() else []
    return [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in lines
        if line.startswith("| ")
    ][1:]


def named():
    """Paper's name, file, symbol and margin of each row that names a symbol."""
    for paper, _, where, margin in rows():
        if match := re.fullmatch(r"`([\w/]+\.py): ([\w.]+)`", where):
            yield paper, *match.groups(), margin.strip("`")


def source_of(path, symbol):
    """Lines of a function, class or method, with what stands in their margin."""
    text = path.read_text("utf-8")
    body = ast.parse(text).body
    for name in symbol.split("."):
        found = [node for node in body if getattr(node, "name", None) == name]
        assert found, f"{path.name} has no {symbol}"
        body = found[0].body
    return textwrap.dedent("\n".join(text.splitlines()[found[0].lineno - 1 : found[0].end_lineno]))


def comments(source):
    return [
        t.string
        for t in tokenize.generate_tokens(io.StringIO(source).readline)
        if t.type == tokenize.COMMENT
    ]


@pytest.mark.parametrize(("paper", "file", "symbol", "margin"), list(named()))
def test_what_the_table_names_exists(paper, file, symbol, margin):
    found = comments(source_of(PACKAGE / file, symbol))
    assert not margin or any(comment.startswith(margin) for comment in found), found


def test_the_table_has_every_equation_of_the_paper():
    first = " ".join(row[0] for row in rows())
    assert {int(n) for n in re.findall(r"\((\d+)\)", first)} == set(range(1, 28))
    assert {"Theorem 1", "Theorem 2", "Definition 1", "Remark 1"} <= set(
        re.findall(r"[A-Z]\w+ \d", first)
    )


def test_margins_of_the_package_refer_to_equations_that_exist():
    """And every one of them is in the table."""
    table = {int(n) for row in rows() for n in re.findall(r"eqs?\. \((\d+)\)", row[3])} | {11}
    for path, comment in of_package():
        assert {int(n) for n in re.findall(r"eq\. \((\d+)\)", comment)} <= table, (path, comment)


@cache
def of_package():
    """All files, each with each of its comments."""
    return [
        (path, comment)
        for path in PACKAGE.rglob("*.py")
        for comment in comments(path.read_text("utf-8"))
    ]


def defined(page):
    """Numbers of the equations that a page of the docs gives a line of their own."""
    text = (TABLE.parent / f"{page}.md").read_text("utf-8")
    return [int(number) for number in re.findall(r"^\((\d+)\) ", text, re.MULTILINE)]


def cited(page):
    """Numbers of a page's equations that margins of the package name."""
    return {
        int(number)
        for _, text in of_package()
        for number in re.findall(rf"\b{page} \((\d+)\)", text)
    }


@pytest.mark.parametrize("page", ["algorithm", "balance", "shapes"])
def test_margins_name_numbered_equations_of_the_docs(page):
    numbers = defined(page)
    assert numbers == list(range(1, len(numbers) + 1))
    assert cited(page)
    assert cited(page) <= set(numbers)


@pytest.mark.parametrize("page", ["algorithm", "balance"])
def test_every_equation_of_a_map_is_in_a_margin(page):
    assert cited(page) == set(defined(page))
