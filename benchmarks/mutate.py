"""Whether a room's tests notice that its code is wrong: seeded changes of one operator, constant or condition each.

`python -m benchmarks.mutate verify 20 --seed 1` makes 20 changes in `igl_spheremap/verify`, one at a time, runs
`tests/verify` on each in a process of its own until a test fails, and prints those that no test notices. Whether these
alter a result is for a person to say: many change only the time that is taken, or the slack of a bound.
"""

from __future__ import annotations

import argparse
import ast
import os
import random
import resource
import shutil
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
#: What stands for an operator.
OPERATORS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult,
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.And: ast.Or, ast.Or: ast.And, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd, ast.MatMult: ast.Mult,
}  # fmt: skip


class Change(NamedTuple):
    """A file, a line of it, what the line says then, and the text of the whole file."""

    path: Path
    line: int
    says: str
    text: str


def changes(path: Path) -> Iterator[Change]:
    """All changes of one operator, number or condition in a file, but for annotations and texts."""
    source = path.read_text(encoding="utf-8")
    count = sum(1 for _ in _places(ast.parse(source)))
    for k in range(count):
        tree = ast.parse(source)
        node, change = next(place for i, place in enumerate(_places(tree)) if i == k)
        change()
        line = getattr(node, "lineno", 0)
        yield Change(path, line, ast.unparse(node)[:100], ast.unparse(tree))


def _places(tree: ast.Module) -> Iterator[tuple[ast.AST, object]]:
    """Nodes, each with the function that changes it."""
    skipped: set[int] = set()
    for node in ast.walk(tree):
        for name in ("annotation", "returns"):
            if (note := getattr(node, name, None)) is not None:
                skipped |= {id(child) for child in ast.walk(note)}
    for node in ast.walk(tree):
        if id(node) in skipped:
            continue
        if isinstance(node, ast.BinOp | ast.AugAssign | ast.BoolOp) and type(node.op) in OPERATORS:
            yield node, lambda node=node: setattr(node, "op", OPERATORS[type(node.op)]())
        elif isinstance(node, ast.Compare) and type(node.ops[0]) in OPERATORS:
            yield node, lambda node=node: node.ops.__setitem__(0, OPERATORS[type(node.ops[0])]())
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not | ast.Invert):
            yield (
                node,
                lambda node=node: setattr(
                    node, "op", ast.UAdd() if isinstance(node.op, ast.USub) else _twice(node)
                ),
            )
        elif isinstance(node, ast.Constant) and type(node.value) in (int, float):
            yield (
                node,
                lambda node=node: setattr(
                    node,
                    "value",
                    2 * node.value
                    if isinstance(node.value, float) and node.value
                    else node.value + 1,
                ),
            )
        elif isinstance(node, ast.If | ast.IfExp | ast.While) and not isinstance(
            node.test, ast.Constant
        ):
            yield node, lambda node=node: setattr(node, "test", ast.UnaryOp(ast.Not(), node.test))


def _twice(node: ast.UnaryOp) -> ast.unaryop:
    """The same operator on an operand that has it already: none."""
    node.operand = ast.UnaryOp(node.op, node.operand)
    return node.op


def likely_first(room: str, change: Change) -> list[str]:
    """The room's files of tests, that of the changed module first."""
    files = sorted((ROOT / "tests" / room).rglob("test_*.py"))
    files.sort(key=lambda file: file.stem != f"test_{change.path.stem}")
    return [str(file.relative_to(ROOT)) for file in files]


def noticed(change: Change, shadow: Path, tests: list[str]) -> bool:
    """Whether a test fails on a copy of the package with a change; in a fork, which has the libraries already."""
    target = shadow / change.path.relative_to(ROOT)
    before = target.read_text(encoding="utf-8")
    target.write_text(change.text, encoding="utf-8")
    try:
        child = os.fork()
        if child == 0:
            _run(shadow, tests)
        return os.waitpid(child, 0)[1] != 0
    finally:
        target.write_text(before, encoding="utf-8")


_LONGEST = 60  # CPU seconds: a loop without an end is noticed, too


def _run(shadow: Path, tests: list[str]) -> None:
    """Run tests on the copy, and end the process with their status."""
    import pytest

    resource.setrlimit(resource.RLIMIT_CPU, (_LONGEST, _LONGEST))
    nothing = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    os.dup2(nothing, 2)
    os.chdir(shadow)
    sys.path.insert(0, str(shadow))
    os.environ["PYTHONPATH"] = str(shadow)
    sys.dont_write_bytecode = True
    os._exit(int(pytest.main(["-x", "-q", "-p", "no:cacheprovider", *tests])) % 256)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("room")
    parser.add_argument("count", type=int)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--tests", nargs="*", help="instead of tests/ROOM")
    args = parser.parse_args()
    found = [
        change
        for path in sorted((ROOT / "igl_spheremap" / args.room).rglob("*.py"))
        for change in changes(path)
    ]
    chosen = random.Random(args.seed).sample(found, min(args.count, len(found)))
    for library in (
        "igl",
        "numpy",
        "scipy.optimize",
        "scipy.sparse.linalg",
        "scipy.spatial",
        "pytest",
    ):
        __import__(library)
    left = []
    with tempfile.TemporaryDirectory() as folder:
        shadow = Path(folder)
        for name in ("igl_spheremap", "tests"):
            shutil.copytree(
                ROOT / name, shadow / name, ignore=shutil.ignore_patterns("__pycache__")
            )
        shutil.copy(ROOT / "pyproject.toml", shadow)
        for number, change in enumerate(chosen, 1):
            seen = noticed(change, shadow, args.tests or likely_first(args.room, change))
            left += [] if seen else [change]
            word = "noticed" if seen else "LIVES"
            place = f"{change.path.name}:{change.line}"
            print(f"{number:3d} {word:8s}{place:24s}{change.says}", flush=True)
    print(
        f"{args.room}: {len(chosen) - len(left)} of {len(chosen)} noticed, of {len(found)} that there are"
    )


if __name__ == "__main__":
    main()
