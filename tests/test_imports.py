"""Imports run one way through the rooms that docs/architecture.md lists, and no two files import each other."""

import ast
import os
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

import igl_spheremap
from igl_spheremap.apps.cli.table import COMMANDS, GROUPS, SHAPES

ROOT = Path(igl_spheremap.__file__).parent
ARCHITECTURE = ROOT.parent / "docs" / "architecture.md"
FRONT = {
    "__init__.py",
    "__main__.py",
    "_version.py",
    "errors.py",
    "gate.py",
    "lazy.py",
    "pyvista.py",
    "timings.py",
    "wings.py",
}
DOORS = {"": ROOT / "__init__.py", "shapes": ROOT / "shapes" / "__init__.py"}
#: Calls a wing when the spine asks for one: what it imports is imported then.
WINGS = ROOT / "wings.py"


def modules_at(name):
    """The file that a dotted name below the package stands for."""
    base = ROOT.joinpath(*name)
    found = {base.with_suffix(".py"), base / "__init__.py"} if name else set()
    return {path for path in found if path.is_file()}


@cache
def imported(path):
    """Files of the package that a file imports by any statement, wherever it stands, type checking included."""
    found = set()
    package = path.relative_to(ROOT).parent.parts if ROOT in path.parents else ()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            names = [alias.name.split(".") for alias in node.names]
            for name in names:
                if name[0] == ROOT.name:
                    found |= modules_at(name[1:]) or {ROOT / "__init__.py"}
        elif isinstance(node, ast.ImportFrom):
            module = (node.module or "").split(".") if node.module else []
            if node.level:
                base = [*package[: len(package) - node.level + 1], *module]
            elif module and module[0] == ROOT.name:
                base = module[1:]
            else:
                continue
            for alias in node.names:  # a module of that name, or a name within the module
                found |= (
                    modules_at([*base, alias.name]) or modules_at(base) or {ROOT / "__init__.py"}
                )
    return frozenset(found - {path})


def files():
    return sorted(path for path in ROOT.rglob("*.py") if path.parent.name != "_pyinstaller")


def room(path):
    """The room of a file: a folder, or one within `shapes`; of the two doors the folder that they open."""
    parts = path.relative_to(ROOT).parent.parts
    return "/".join(parts[: 2 if parts[:1] == ("shapes",) else 1])


def tables():
    """The rooms of each table, in order: the spine, the wings, those of several surfaces, the programs."""
    if not ARCHITECTURE.exists():
        pytest.skip("the docs are not installed with the package")
    text = ARCHITECTURE.read_text("utf-8")
    found = [re.findall(r"^\| `([\w/]+)/` \|", part, re.MULTILINE) for part in text.split("\n\n")]
    return [names for names in found if names]


def rooms():
    """The rooms in the order of the tables."""
    return [name for table in tables() for name in table]


def test_the_table_lists_the_rooms_and_the_root_holds_the_front_door():
    assert sorted(rooms()) == sorted({room(path) for path in files()} - DOORS.keys())
    assert {path.name for path in ROOT.glob("*.py")} == FRONT
    assert [*ROOT.glob("shapes/*.py")] == [DOORS["shapes"]]


def test_imports_run_towards_the_top_of_the_table():
    order = ["", *rooms()]
    for path in files():
        if path in DOORS.values() or path in (ROOT / "__main__.py", ROOT / "pyvista.py", WINGS):
            continue  # the front doors collect everything
        for other in imported(path):
            assert other not in DOORS.values(), f"{path} imports a front door"
            assert order.index(room(other)) <= order.index(room(path)), f"{path} imports {other}"


def test_the_spine_imports_no_wing():
    """Not even in a function, or for type checkers: what it asks of wings is in one file, which it calls."""
    spine = tables()[0]
    assert len(spine) == 12
    for path in files():
        if room(path) in spine:
            assert {room(other) for other in imported(path)} <= {"", *spine}, path


#: Imports every wing in vain.
ALONE = """
import sys
from importlib.abc import MetaPathFinder

class NoWings(MetaPathFinder):
    def find_spec(self, name, path, target=None):
        room = name.removeprefix("igl_spheremap.").split(".")[0]
        assert room == name or room not in {wings}, name

sys.meta_path.insert(0, NoWings())
import numpy as np
import igl_spheremap as ism

v = np.array([[1.0, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
f = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])
maps = [ism.spherical_conformal_map(v, f), ism.spherical_conformal_map(v, f, method="lai2014")]
maps += [ism.algorithm_2(v, f), ism.sphere_map(v, f, maps[0].sphere), ism.repair_foldings(v, f, v)]
assert all(ism.certify(each).folding_free for each in maps)
print(*sorted(name for name in sys.modules if name.startswith("igl_spheremap.")))
"""


def test_the_spine_maps_without_the_wings():
    """Where no wing can be imported, arrays are mapped by every method, and the maps are certified."""
    wings = {name.split("/")[0] for table in tables()[1:] for name in table}
    code = ALONE.replace("{wings}", repr(wings))
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert not run.returncode, run.stderr
    assert "igl_spheremap.maps.methods" in run.stdout.split()


def test_no_file_imports_what_imports_it():
    done, way = set(), []

    def visit(path):
        assert path not in way, " -> ".join(p.name for p in [*way[way.index(path) :], path])
        if path in done:
            return
        way.append(path)
        for other in sorted(imported(path)):
            if path != WINGS:
                visit(other)
        way.pop()
        done.add(path)

    for path in files():
        if path not in DOORS.values():
            visit(path)
    assert len(done) > 20


def test_witnesses_import_no_solver():
    allowed = {"mesh", "sphere", "verify", ""}
    for path in (ROOT / "verify").glob("*.py"):
        assert {room(p) for p in reached(path)} <= allowed


def reached(path, by_wings=False):
    """Files that a file imports, and those that they import; and those that calls of wings import, if asked."""
    found, todo = set(), [path]
    while todo:
        one = todo.pop()
        if one == WINGS and not by_wings:
            continue
        other = imported(one) - found
        found |= other
        todo += other
    return found


def test_the_first_door_needs_nothing_of_the_second():
    """Nor do its commands, the demos and reports."""
    apps, demos = ROOT / "apps", sorted((ARCHITECTURE.parents[1] / "demos").glob("*.py"))
    modules = {row.module for row in COMMANDS if row.name not in GROUPS[SHAPES]}
    commands = [apps / "cli" / "commands" / f"{module}.py" for module in modules]
    others = (DOORS[""], ROOT / "__main__.py", apps, ROOT / "shapes")
    first = [path for path in files() if not {path, *path.parents} & {*others}]
    for path in [*first, *commands, *demos, apps / "report.py"]:
        assert not [
            other for other in reached(path, by_wings=True) if room(other).startswith("shapes")
        ], path
    assert not [path for path in demos if "shapes" in path.read_text("utf-8")]


def test_every_form_of_import_is_seen():
    """The checks above rest on this: indented imports, as for type checkers, count; names resolve to files."""
    seen = imported(ROOT / "maps" / "spherical_conformal_map.py")
    assert ROOT / "maps" / "sphere_map.py" in seen  # only under TYPE_CHECKING
    assert ROOT / "maps" / "methods.py" in seen  # in a function
    # from . import samples
    assert ROOT / "samples" / "__init__.py" in imported(ROOT / "__init__.pyi")


@pytest.mark.parametrize(
    "door", [igl_spheremap, igl_spheremap.shapes], ids=lambda door: door.__name__
)
def test_each_public_name_is_listed_once_for_readers_type_checkers_and_the_front_door(door):
    stub = ast.parse(Path(door.__file__).with_suffix(".pyi").read_text("utf-8")).body
    imports = [node for node in stub if isinstance(node, ast.ImportFrom)]
    assert all(
        node.level == len(node.names) == 1 and node.names[0].name == node.names[0].asname
        for node in imports
    )
    names = [node.names[0].name for node in imports]
    assert sorted(names) == sorted(set(names)) == door.__all__ == dir(door)
    # the table that is read at run time
    assert {
        node.names[0].name: node.module or node.names[0].name for node in imports
    } == door._MODULES
    for node in imports:
        public = getattr(door, node.names[0].name)
        assert (
            getattr(public, "__module__", f"{door.__name__}.{node.module}")
            == f"{door.__name__}.{node.module}"
        )
    with pytest.raises(AttributeError, match="no_such_name"):
        door.no_such_name  # noqa: B018


def test_the_core_needs_no_extra():
    """Polyscope is imported only where something is drawn, an extra only where it is used.

    Not in the list are the solvers: scipy.optimize itself looks for scikit-sparse, and one that is installed
    is imported with what factorises, so that no process's first map waits for it.
    """
    code = (
        "import sys, igl_spheremap as ism\n"
        "[getattr(door, name) for door in (ism, ism.shapes) for name in dir(door)]\n"
        "print(' '.join(sorted({m.split('.')[0] for m in sys.modules})))"
    )
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.split()
    assert not {"polyscope", "matplotlib", "nibabel", "trimesh"} & set(loaded)


#: A process as Windows has it: without POSIX modules and calls, with locks, Ctrl-Break and process groups of its own.
WINDOWS = """
import fcntl, importlib, os, pkgutil, signal, subprocess, sys, types
import asyncio, concurrent.futures, multiprocessing
import igl, numpy, scipy.optimize, scipy.sparse.linalg, scipy.spatial, tqdm

class Popen(subprocess.Popen):
    def __init__(self, command, creationflags=0, **options):
        assert (creationflags, "start_new_session" in options) == (0x200, False)
        super().__init__(command, **options)

    def kill(self):
        os.kill(self.pid, 9)

def locking(descriptor, mode, count):
    assert (mode, count, os.lseek(descriptor, 0, os.SEEK_CUR) > 1 << 30) == (2, 1, True)
    try:
        flock(descriptor, EXCLUSIVE)
    except BlockingIOError:
        raise PermissionError(13, "Permission denied") from None

flock, EXCLUSIVE = fcntl.flock, fcntl.LOCK_EX | fcntl.LOCK_NB
sys.modules["msvcrt"] = msvcrt = types.ModuleType("msvcrt")
msvcrt.locking, msvcrt.LK_NBLCK = locking, 2
subprocess.Popen, subprocess.CREATE_NEW_PROCESS_GROUP = Popen, 0x200
signal.SIGBREAK = signal.SIGUSR1
sys.modules |= dict.fromkeys(["fcntl", "resource", "termios", "tty", "pty", "pwd", "grp"])
os.process_cpu_count = os.cpu_count  # of Python 3.13, which elsewhere asks for the affinity
for name in ("fork", "forkpty", "mkfifo", "killpg", "getpgid", "setsid", "getuid", "geteuid", "fchmod", "chown",
             "sched_getaffinity", "sysconf", "uname", "O_NOFOLLOW", "O_NONBLOCK", "O_DIRECTORY", "O_CLOEXEC"):
    delattr(os, name)
for name in ("SIGKILL", "SIGXCPU", "SIGALRM", "SIGHUP", "SIGUSR1", "SIGPIPE", "alarm", "setitimer", "pthread_kill"):
    delattr(signal, name)
sys.platform = "win32"

import igl_spheremap as ism
for module in pkgutil.walk_packages(ism.__path__, "igl_spheremap."):
    if not module.name.endswith(("__main__", ".pyvista", "hook-igl_spheremap")):
        importlib.import_module(module.name)
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.exits import Exit, Interrupt
from igl_spheremap.populations.manifest import Manifest

for k in (1, 2):
    ism.write_mesh(f"{k}.ply", *ism.samples.make("spheroid", n_vertices=200 * k))
words = ["batch", "1.ply", "2.ply", "--out", "{stem}.obj", "--manifest", "all.jsonl", "--jobs", "2", "-q"]
assert main(words) == Exit.OK
assert main(["check", "2.ply", "2.obj", "-q"]) == Exit.OK
with Manifest("all.jsonl", {"options": "-", "by": "host:1"}):
    assert main(words) == Exit.FILE
with Interrupt() as interrupt:
    signal.raise_signal(signal.SIGBREAK)
    assert interrupt.status == Exit.TERMINATED
print("done")
"""


@pytest.mark.posix
def test_nothing_needs_what_windows_lacks(tmp_path):
    """Jobs run, manifests are locked, and a run is ended, by what Windows has in the place of POSIX's calls."""
    places = os.pathsep.join([str(ROOT.parent), *filter(None, [os.environ.get("PYTHONPATH")])])
    done = subprocess.run(
        [sys.executable, "-c", WINDOWS],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": places},
    )
    assert done.stdout.endswith("done\n"), done.stderr
