"""Imports run downwards only."""

import ast
from pathlib import Path

import igl_spheremap

ROOT = Path(igl_spheremap.__file__).parent


def imported(path):
    """Modules of the package that a file imports at run time, as paths below its root."""
    found = set()
    package = path.relative_to(ROOT).parent.parts
    tree = ast.parse(path.read_text())
    guarded = [node for node in ast.walk(tree) if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test)]
    skip = {id(inner) for node in guarded for inner in ast.walk(node)}
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.level and id(node) not in skip:
            base = package[: len(package) - node.level + 1]
            target = (*base, *(node.module or "").split(".")) if node.module else base
            names = [target] if node.module else [(*base, alias.name) for alias in node.names]
            for name in names:
                found |= modules_at(name)
    return found - {path}


def modules_at(name):
    """The file that a dotted name stands for, if it is a module of the package."""
    base = ROOT.joinpath(*name)
    return {p for p in (base.with_suffix(".py"), base / "__init__.py") if p.is_file()}


def graph():
    return {path: imported(path) for path in sorted(ROOT.rglob("*.py"))}


def test_no_module_imports_what_imports_it():
    links = graph()
    links[ROOT / "__init__.py"] = set()  # the front door collects everything
    done, path = set(), []

    def visit(module):
        assert module not in path, " -> ".join(p.name for p in [*path[path.index(module):], module])
        if module in done:
            return
        path.append(module)
        for other in sorted(links[module]):
            visit(other)
        path.pop()
        done.add(module)

    for module in links:
        visit(module)
    assert len(done) == len(links) > 20


def test_witnesses_import_no_solver():
    links = graph()
    for name in ("certify.py", "distortion.py"):
        reached, todo = set(), [ROOT / name]
        while todo:
            for other in links[todo.pop()] - reached:
                reached.add(other)
                todo.append(other)
        assert {p.name for p in reached} <= {"mesh.py", "errors.py", "sums.py"}


def test_the_core_needs_no_extra():
    """Polyscope is imported only where something is drawn, an extra only where it is used.

    (scipy.optimize itself looks for scikit-sparse, which is therefore not in the list.)
    """
    import subprocess
    import sys

    code = "import sys, igl_spheremap; print(' '.join(sorted({m.split('.')[0] for m in sys.modules})))"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not {"polyscope", "matplotlib", "nibabel", "trimesh", "cvxopt", "cholespy"} & set(loaded)
