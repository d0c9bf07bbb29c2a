"""Whether a room's tests notice that its code is wrong: seeded changes of one operator, constant or condition each.

`python -m benchmarks.mutate verify 20 --seed 1` makes 20 changes in `igl_spheremap/verify`, one at a time, runs the
files of `tests/verify` that call the changed function, the fastest first, in a process of its own and until a test
fails, and prints the changes that no test notices. Whether these alter a result is for a person to say: many
change only the time that is taken, or the slack of a bound.
"""

from __future__ import annotations

import argparse
import ast
import os
import pickle
import random
import resource
import shutil
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import FrameType
from typing import Any, NamedTuple

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


class Calls:
    """A plugin of pytest that notes which functions of the package each file of tests calls, and the file's time."""

    def __init__(self, package: Path) -> None:
        self.package, self.file = str(package), ""
        self.called: dict[str, set[tuple[str, int]]] = defaultdict(set)
        self.seconds: dict[str, float] = defaultdict(float)

    def note(self, frame: FrameType, event: str, _: object) -> None:
        """A profiler's callback."""
        code = frame.f_code
        if event == "call" and code.co_filename.startswith(self.package):
            self.called[self.file].add((code.co_filename, code.co_firstlineno))

    def pytest_collectstart(self, collector: Any) -> None:
        self.file = collector.nodeid.partition("::")[0]

    def pytest_runtest_logstart(self, nodeid: str) -> None:
        self.file = nodeid.partition("::")[0]

    def pytest_runtest_logreport(self, report: Any) -> None:
        self.seconds[self.file] += report.duration


def files_of_tests(room: str, shadow: Path) -> list[tuple[str, set[tuple[str, int]]]]:
    """The room's files of tests, the fastest first, and the functions that each calls."""
    reader, writer = os.pipe()
    if os.fork() == 0:
        calls = Calls(shadow / "igl_spheremap")
        sys.setprofile(calls.note)
        status = _run(shadow, [f"tests/{room}"], [calls])
        sys.setprofile(None)
        files = sorted(calls.seconds, key=calls.seconds.__getitem__)
        with os.fdopen(writer, "wb") as pipe:
            pickle.dump([(file, calls.called[file]) for file in files], pipe)
        os._exit(status)
    os.close(writer)
    with os.fdopen(reader, "rb") as pipe:
        found = pickle.load(pipe)
    if os.wait()[1]:
        raise SystemExit(f"tests/{room} fail on the package as it is")
    return found


def that_call(
    change: Change, shadow: Path, files: list[tuple[str, set[tuple[str, int]]]]
) -> list[str]:
    """The files of tests that call the changed function; all of them for what runs as the module is imported."""
    tree = ast.parse(change.path.read_text(encoding="utf-8"))
    starts = {
        min([node.lineno, *(each.lineno for each in node.decorator_list)])
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef)
        and node.body[0].lineno <= change.line <= (node.end_lineno or 0)
    }
    places = {(str(shadow / change.path.relative_to(ROOT)), start) for start in starts}
    found = [file for file, called in files if called & places]
    if not starts or not found:
        return [file for file, _ in files]
    return found


def noticed(change: Change, shadow: Path, tests: list[str]) -> bool:
    """Whether a test fails on a copy of the package with a change; in a fork, which has the libraries already."""
    target = shadow / change.path.relative_to(ROOT)
    before = target.read_text(encoding="utf-8")
    target.write_text(change.text, encoding="utf-8")
    try:
        child = os.fork()
        if child == 0:
            resource.setrlimit(resource.RLIMIT_CPU, (_LONGEST, _LONGEST))
            os._exit(_run(shadow, tests))
        return os.waitpid(child, 0)[1] != 0
    finally:
        target.write_text(before, encoding="utf-8")


_LONGEST = 60  # CPU seconds: a loop without an end is noticed, too


def _run(shadow: Path, tests: list[str], plugins: Sequence[object] = ()) -> int:
    """The status of tests on the copy, without a word."""
    import pytest

    nothing = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    os.dup2(nothing, 2)
    os.chdir(shadow)
    sys.path.insert(0, str(shadow))
    os.environ["PYTHONPATH"] = str(shadow)
    sys.dont_write_bytecode = True
    return int(pytest.main(["-x", "-q", "-p", "no:cacheprovider", *tests], plugins)) % 256


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("room")
    parser.add_argument("count", type=int)
    parser.add_argument("--seed", type=int, default=1)
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
        files = files_of_tests(args.room, shadow)
        for number, change in enumerate(chosen, 1):
            seen = noticed(change, shadow, that_call(change, shadow, files))
            left += [] if seen else [change]
            word = "noticed" if seen else "LIVES"
            place = f"{change.path.name}:{change.line}"
            print(f"{number:3d} {word:8s}{place:24s}{change.says}", flush=True)
    print(
        f"{args.room}: {len(chosen) - len(left)} of {len(chosen)} noticed, of {len(found)} that there are"
    )


if __name__ == "__main__":
    main()
