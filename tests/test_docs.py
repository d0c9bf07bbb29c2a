"""README and docs: their code runs, their commands exist and do as said, their pages are in the index."""

from __future__ import annotations

import ast
import csv
import importlib.util
import inspect
import os
import re
import shlex
import shutil
import subprocess
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from corpus import ROOT
from disks import half
from doors import PUBLIC
from drawing import missing
from other_programs import cifti, label_image

import igl_spheremap as ism
from benchmarks.pages import fill
from benchmarks.reproduction import settings
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.exits import Exit
from igl_spheremap.apps.cli.parser import build_parser
from igl_spheremap.apps.cli.table import COMMANDS
from igl_spheremap.apps.reproduce.figures import FIGURES
from igl_spheremap.apps.reproduce.tables import TABLES as REPRODUCED_TABLES
from igl_spheremap.io.formats import FORMATS
from igl_spheremap.io.scalars import write_scalars
from igl_spheremap.io.write_mesh import write_mesh

DOCS = ROOT / "docs"
REPRODUCED = DOCS / "reproduction"
BENCHMARKS = ROOT / "benchmarks"
BUILT = {DOCS / "_build", DOCS / "gallery", DOCS / "reference" / "generated", REPRODUCED}
PAGES = [ROOT / "README.md", *(p for p in sorted(DOCS.rglob("*.md")) if not BUILT & set(p.parents))]
NAMES = [str(page.relative_to(ROOT)) for page in PAGES]
EXTRAS = {
    "io": ("nibabel", "trimesh", "PIL"),
    "display": ("polyscope",),
    "plot": ("matplotlib",),
    "pyvista": ("pyvista",),
    "nitransforms": ("nitransforms",),
    "mne": ("mne",),
    "neuromaps": ("neuromaps",),
    "nilearn": ("nilearn",),
}
FENCE = re.compile(r"^```(\w+)([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
#: Words of command lines that open a window, take long or go on from those; their own tests run them.
ELSEWHERE = {
    "view",
    "play",
    "reproduce",
    "batch",
    "match",
    "template",
    "spharm-pdm",
    "--modes",
    "--report",
    "--plot",
}
#: A sample that is as large as it is for the reader only.
SMALLER = {
    "sample:bunny ": "sample:bunny:n_vertices=2000 ",
    'make("bunny")': 'make("bunny", n_vertices=2000)',
}
COMMAND = re.compile(r"igl-spheremap ([a-z][a-z-]*)")

#: Surfaces and scalar maps that FreeSurfer makes for each hemisphere.
OF_FREESURFER = {
    "white",
    "pial",
    "orig",
    "smoothwm",
    "inflated",
    "sphere",
    "sphere.reg",
    "qsphere.nofix",
    "curv",
    "sulc",
    "area",
    "thickness",
    "volume",
    "avg_curv",
    "jacobian_white",
}

#: polyscope with its backend that draws nothing.
NO_WINDOW = """
import polyscope
init = polyscope.init
polyscope.init = lambda *backend: init("openGL_mock")
polyscope.show = polyscope.frame_tick
"""

pages = pytest.mark.parametrize("page", PAGES, ids=NAMES)


@dataclass(frozen=True)
class Block:
    """A fenced block, and the extras that it says it needs (```python needs=io)."""

    language: str
    needs: tuple[str, ...]
    text: str
    line: int
    prints: str | None = None


def printed_after(rest: str) -> str | None:
    """The output of a block, which may stand below it."""
    found = re.match(r"\n\n```text\n(.*?)^```$", rest, re.MULTILINE | re.DOTALL)
    if found is None:
        return None
    return found[1]


def blocks(page: Path, language: str) -> list[Block]:
    text = page.read_text("utf-8")
    return [
        Block(
            found[1],
            tuple(re.findall(r"needs=(\w+)", found[2])),
            found[3],
            text[: found.start()].count("\n") + 1,
            printed_after(text[found.end() :]),
        )
        for found in FENCE.finditer(text)
        if found[1] == language
    ]


def require(extras):
    for extra in extras:
        for package in EXTRAS[extra]:
            if importlib.util.find_spec(package) is None:
                pytest.skip(f"the rest of this page needs {package}, of the extra {extra}")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A folder with the files that pages speak of, small ones."""
    folder = tmp_path_factory.mktemp("files")
    v, f = ism.samples.make("spheroid", n_vertices=500)
    write_mesh(folder / "bunny.ply", v, f)
    write_mesh(folder / "67p.tab", v, f)
    write_mesh(folder / "bunny.obj", v, f)
    write_mesh(
        folder / "scan.stl",
        np.concatenate([v, v[f[:20]].reshape(-1, 3) + 9]),
        scan_faces(f, len(v)),
    )
    write_mesh(folder / "X_surf.vtk", v, f)
    for name, shape in (("cat", "pear"), ("horse", "spheroid")):
        write_mesh(folder / f"{name}.ply", *ism.samples.make(shape, n_vertices=400))
        (folder / f"{name}.vts").write_text("0\n200\n")
    write_mesh(folder / "face.ply", *half(v, f)[:2])
    (folder / "bunny.vts").write_text("0 0 0 0\n")
    (folder / "scan.pinned").write_text("lk 7\n")
    x = np.array(ism.gauss_map(v, f))
    x[:5] *= -1
    write_mesh(folder / "folded.ply", x, f)
    if importlib.util.find_spec("nibabel") is not None:
        brain = ism.samples.make("brain", n_vertices=3500)
        for name in ("lh.pial", "lh.white", "lh.pial.surf.gii"):
            write_mesh(folder / name, *brain)
        write_mesh(folder / "rh.white", brain[0] * [-1, 1, 1], brain[1][:, ::-1])
        for name, values in (
            ("sulc", np.linalg.norm(brain[0], axis=1)),
            ("thickness", brain[0][:, 2]),
        ):
            for side in ("lh", "rh"):
                write_scalars(folder / f"{side}.{name}", {name: values})
        label_image()[2].to_filename(folder / "labels.nii.gz")
        label_image("MGHImage")[2].to_filename(folder / "aseg.mgz")
        cifti(len(brain[0]), range(100)).to_filename(folder / "myelin.dscalar.nii")
        x = ism.spherical_conformal_map(*brain).sphere
        write_mesh(folder / "lh.sphere", x, brain[1])
        write_mesh(folder / "rh.sphere", x * [-1, 1, 1], brain[1][:, ::-1])
    return folder


def scan_faces(f, n):
    """The mesh, and some loose triangles besides."""
    return np.concatenate([f, n + np.arange(60).reshape(-1, 3)])


@pytest.fixture
def desk(files, tmp_path, monkeypatch):
    """A copy of that folder, as the working directory."""
    shutil.copytree(files, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


_FIGURE = re.compile(r"\d+(?:\.\d+)?(?:e[-+]\d+)?")


def assert_alike(said, printed):
    """The same words, and numbers within 3 percent: they depend on rounding, but 0 is 0, and 1 is 1."""
    words, numbers = zip(
        *((_FIGURE.sub("#", text).split(), _FIGURE.findall(text)) for text in (said, printed)),
        strict=True,
    )
    assert words[0] == words[1]
    assert [*map(float, numbers[1])] == pytest.approx([*map(float, numbers[0])], rel=0.03)


def test_another_count_or_word_is_noticed():
    assert_alike("a: 1341 -> 206", "a: 1341 ->  208")
    for printed in ("a: 1341 -> 240", "b: 1341 -> 206", "a: 1341 -> 0"):
        with pytest.raises(AssertionError):
            assert_alike("a: 1341 -> 206", printed)


@pages
def test_python_blocks_run(page, desk, capsys):
    found = blocks(page, "python")
    # polyscope lives once in a process, and leaves files
    if any("display" in block.needs for block in found):
        if missing():
            pytest.skip(missing())
        code = NO_WINDOW + "\n".join(block.text for block in found)
        ended = subprocess.run(
            [sys.executable, "-c", code], cwd=desk, env=environment(desk), timeout=300
        )
        assert ended.returncode == 0
        return
    namespace = {"__name__": "__main__"}
    for block in found:
        require(block.needs)
        code = "\n" * block.line + block.text  # so that a traceback shows the page's own line
        exec(compile(code, str(page), "exec"), namespace)
        out = capsys.readouterr().out
        if block.prints is not None:
            assert_alike(block.prints, out)


@pytest.mark.posix
@pages
def test_shell_commands_run(page, desk, capfd):
    for command in commands(page):
        words = shlex.split(smaller(command))
        require(needs(words))
        if words[0] != "igl-spheremap" or set(words) & {"|", "<", ">"}:
            assert in_a_shell(command, desk) == 0, command
        elif ELSEWHERE & set(words):
            parser().parse_args(words[1:])
        else:
            assert main(words[1:]) == Exit.OK, f"{command}\n{capfd.readouterr().err}"


def smaller(text):
    """A gallery's script or a command with the small sample."""
    for large, small in SMALLER.items():
        text = text.replace(large, small)
    return text


@cache
def parser():
    """Of the command line."""
    return build_parser()


def commands(page: Path) -> list[str]:
    """Commands of this package in sh blocks, and folders that they make; not its installation and tests."""
    lines = [
        line.partition(" #")[0].strip()
        for block in blocks(page, "sh")
        for line in block.text.splitlines()
    ]
    return [
        part
        for line in lines
        for part in line.split(" && ")
        if re.search(r"igl-spheremap |^mkdir ", part)
    ]


def needs(words):
    ours = (".glb", ".gltf", ".gii", ".pial", ".white", ".sphere", ".conformal")
    textured = {"equirectangular", "octahedral"} & set(words)
    images = any(".nii" in word or ".mgz" in word for word in words)
    surfaces = any(word.endswith(ours) or "lh" in word for word in words)
    found = []
    if textured or images or surfaces:
        found.append("io")
    if "fsaverage5" in words:
        found.append("nilearn")  # ships it
    return found


def in_a_shell(command, folder):
    """The exit status of a line with pipes or loops."""
    return subprocess.run(
        ["sh", "-c", command], cwd=folder, env=environment(folder), timeout=300
    ).returncode


def environment(folder):
    """Variables under which another process finds this checkout's package and command."""
    program = folder / "bin" / "igl-spheremap"
    program.parent.mkdir(exist_ok=True)
    program.write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)} -m igl_spheremap "$@"\n')
    program.chmod(0o755)
    path = os.pathsep.join([str(program.parent), os.environ["PATH"]])
    places = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    return {**os.environ, "PATH": path, "PYTHONPATH": places}


@pages
def test_commands_that_are_named_exist(page):
    known = {command.name for command in COMMANDS}
    assert set(COMMAND.findall(page.read_text("utf-8"))) <= known


@pages
def test_no_example_writes_over_files_of_freesurfer(page):
    """`lh.sphere` of a subject is its registration sphere; examples are copied into such folders."""
    named = re.findall(r'write_\w+\("([^"]+)"', page.read_text("utf-8"))
    assert not OF_FREESURFER & of_a_hemisphere([*named, *written_by(commands(page))])


def test_no_help_writes_over_files_of_freesurfer():
    assert not OF_FREESURFER & of_a_hemisphere(
        written_by([line for one in COMMANDS for line in one.examples])
    )


def written_by(lines):
    """Names of files that lines of the shell write."""
    for line in lines:
        words = shlex.split(re.split("[|<>]", line)[0])
        if words[0] == "igl-spheremap" and words[1] != "reproduce":
            args = parser().parse_args(words[1:])
            yield from (name for key in ("target", "out") if (name := getattr(args, key, None)))


def of_a_hemisphere(names):
    """Names without folders and sides."""
    return {Path(name).name.removeprefix("lh.").removeprefix("rh.") for name in names}


OTHERS = ("CHANGELOG.md", "CODE_OF_CONDUCT.md", "CONTRIBUTING.md")
#: Registries of packages, hosts that are places to fill in, and folders of one machine.
NOWHERE = re.compile(
    r"pypi\.org|pythonhosted|anaconda\.org|example\.(com|org)|(?<![\w}])/(home|root|tmp|work)/"
)


@pytest.mark.parametrize("page", [*PAGES, *(ROOT / name for name in OTHERS)], ids=[*NAMES, *OTHERS])
def test_links_and_pictures_exist(page):
    """Files, and headings within them; addresses have the form of one."""
    text = page.read_text("utf-8")
    for target in re.findall(r"\]\(([^)\s]+)[^)]*\)", text):
        if "://" in target:
            assert re.fullmatch(r"https://[\w-]+(\.[\w-]+)+(/\S*)?", target), target
        else:
            name, _, heading = target.partition("#")
            linked = page.parent / name if name else page
            assert linked.exists(), target
            assert not heading or heading in anchors(linked), target
    assert not NOWHERE.search(text)


@cache
def anchors(page: Path) -> set[str]:
    """A site's anchors of the headings of a page: small letters, hyphens for spaces, no other marks."""
    headings = re.findall(r"^#+ (.+)$", page.read_text("utf-8"), re.MULTILINE)
    return {
        re.sub(r"[^\w -]", "", heading.lower()).strip().replace(" ", "-") for heading in headings
    }


@pages
def test_files_that_are_named_exist(page):
    named = re.findall(
        r"`(?:python )?((?:docs|demos|benchmarks|tests)/[\w./]+\.\w+)`", page.read_text("utf-8")
    )
    assert [name for name in named if not (ROOT / name).exists()] == []


def test_every_page_is_reachable():
    index = (DOCS / "index.md").read_text("utf-8")
    listed = re.findall(r"^(?:\w+/)?\w+$", index, re.MULTILINE)
    reached = {DOCS / "index.md", *(DOCS / f"{entry}.md" for entry in listed)}
    assert reached >= {page for page in PAGES if DOCS in page.parents}


EXAMPLES = sorted((DOCS / "examples").glob("plot_*.py"))


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_examples_are_a_screen_long_and_draw_a_picture(example, tmp_path, monkeypatch):
    pytest.importorskip("matplotlib")
    monkeypatch.syspath_prepend(example.parent)
    assert example.read_text("utf-8").count("\n") <= 50
    namespace = {"__name__": "__main__"}
    code = smaller(example.read_text("utf-8")).replace("ico:3", "ico:2")
    # Sphinx draws them as they are
    code = re.sub(r'(?<!"brain", )n_vertices=\d{4}', "n_vertices=1200", code)
    exec(compile(code, str(example), "exec"), namespace)
    namespace["figure"].savefig(tmp_path / "figure.png", dpi=50)


def test_every_command_is_documented():
    text = (DOCS / "reference" / "command_line.md").read_text("utf-8")
    assert {command.name for command in COMMANDS} == set(COMMAND.findall(text))
    assert [flag for flag in long_flags() if not re.search(rf"`{flag}\b", text)] == []


def long_flags():
    """Of all commands."""
    subparsers = next(action for action in parser()._actions if action.dest == "command")
    options = {
        o
        for one in subparsers.choices.values()
        for action in one._actions
        for o in action.option_strings
    }
    return sorted(flag for flag in options - {"--help"} if flag.startswith("--"))


def test_exit_statuses_are_documented():
    text = (DOCS / "reference" / "command_line.md").read_text("utf-8")
    rows = re.findall(r"^\| (\d+) \| (.+) \|", text, re.MULTILINE)
    assert rows == [(str(int(each)), each.meaning) for each in Exit]


def test_every_format_is_documented():
    text = (DOCS / "reference" / "files.md").read_text("utf-8")
    for entry in FORMATS:
        row = next(line for line in text.splitlines() if line.startswith(f"| {entry.name} |"))
        assert ("float32" in row) == entry.single
        assert entry.name == "FreeSurfer" or f"`{entry.suffixes[0]}`" in row


#: The pages of both doors.
REFERENCES = [path.read_text("utf-8") for path in sorted((DOCS / "reference").glob("api*.md"))]


def test_every_public_name_is_in_the_reference():
    listed = {
        f"{door.removeprefix('igl_spheremap').removeprefix('.')}.{name}".removeprefix(".")
        for text in REFERENCES
        for door, names in re.findall(r"currentmodule:: (\S+)\n(.*?)```", text, re.DOTALL)
        for name in re.findall(r"^   ([\w.]+)$", names, re.MULTILINE)
    }
    samples = {f"samples.{name}" for name in ism.samples.names()}
    assert (PUBLIC.keys() - {"samples"}) | samples <= listed


def test_every_public_name_has_an_example_that_runs():
    """In its own docstring, or on the reference page."""
    shown = {name for text in REFERENCES for name in re.findall(r"\bism\.((?:shapes\.)?\w+)", text)}
    own = {name for name, public in PUBLIC.items() if ">>> " in (inspect.getdoc(public) or "")}
    assert PUBLIC.keys() - shown - own == set()


def test_summaries_are_whole_sentences():
    """Sphinx cuts a summary at the first full stop before a space, such as that of an abbreviation."""
    public = PUBLIC.values()
    members = [value for one in public if inspect.isclass(one) for value in vars(one).values()]
    for one in (*public, *members):
        first = re.split(r"(?<=\.)\s", (inspect.getdoc(one) or "").partition("\n\n")[0])[0]
        assert not re.search(r"\b(eqs?|Figs?|Sect|vs|cf)\.$", first), first


#: One word for each unit, and for what has none.
UNIT = re.compile(
    r"degrees|radians|logarithm|units?\b|share|seconds|MB|megabytes|times|norm|weight|factor|ratio|energy"
    r"|correlation|exponent|step size|conformal|from -1 to 1",
    re.IGNORECASE,
)


def described(doc: str) -> list[tuple[str, str, str]]:
    """Name, type and text of each parameter, attribute and result of a numpydoc text."""
    rows = re.findall(r"^(\S.*?) : (.*)\n((?:    .*\n?|\n(?=    ))+)", doc, re.MULTILINE)
    return [(name, kind, " ".join(text.split())) for name, kind, text in rows]


def test_positions_and_numbers_say_their_unit():
    public = [one for name, one in PUBLIC.items() if name != "samples"]
    members = [
        value
        for one in public
        if inspect.isclass(one)
        for value in vars(one).values()
        if callable(value)
    ]
    rows = [
        (one.__qualname__, *row)
        for one in (*public, *members)
        for row in described(inspect.getdoc(one) or "")
    ]
    numbers = [
        row
        for row in rows
        if row[2].startswith("float") or (row[1] == "v" and "array_like" in row[2])
    ]
    assert len(numbers) > 40
    assert [row for row in numbers if not UNIT.search(row[3])] == []


IMAGES = DOCS / "images"
#: What benchmarks measure, and write with their pages.
MEASURED = {"benchmarks.png", "convergence.png", "gradient.png", "eq24.png"}


def test_every_picture_is_shown():
    shown = {
        Path(name).name
        for page in PAGES
        for name in re.findall(r"images/(\w+\.(?:png|gif))", page.read_text("utf-8"))
    }
    assert shown == {path.name for path in IMAGES.iterdir()}


def test_every_other_picture_is_made_by_one_program():
    listed = subprocess.run(
        [sys.executable, DOCS / "pictures.py", "--help"], capture_output=True, text=True
    ).stdout
    assert (
        set(re.findall(r"\w+\.(?:png|gif)", listed.partition("NAME  ")[2]))
        == {path.name for path in IMAGES.iterdir()} - MEASURED
    )
    sizes = {path.name: path.stat().st_size for path in IMAGES.iterdir()}
    assert sizes.pop("foldings.gif") < 2_000_000
    assert max(sizes.values()) < 300_000


def test_the_tables_and_pictures_of_the_reproduction_are_what_its_runs_have_written():
    """Nobody types a number between the sentences, and no table is older than the options of the methods."""
    page = (DOCS / "reproduction.md").read_text("utf-8")
    tables = {path.stem: path.read_text("utf-8") for path in REPRODUCED.glob("*.md")}
    measured = {path.stem for path in (BENCHMARKS / "results").glob("*.md")}
    assert set(re.findall(r"<!-- table (\w+) -->", page)) - measured == set(tables)
    assert set(tables) == set(REPRODUCED_TABLES)
    assert fill(page, tables) == page
    pictures = {path.name: path.stat().st_size for path in REPRODUCED.glob("*.png")}
    assert (
        set(re.findall(r"\(reproduction/(\w+\.png)\)", page))
        == set(pictures)
        == {f"{name}.png" for name in FIGURES}
    )
    assert max(pictures.values()) < 450_000
    assert (REPRODUCED / "methods.json").read_text("utf-8") == settings()


def test_the_tables_that_benchmarks_make_stand_in_the_pages_as_they_were_printed():
    """Each file says which command prints its table; the sums of parts are those of their rows."""
    kept = {path.stem: path.read_text("utf-8") for path in (BENCHMARKS / "results").glob("*.md")}
    [made] = [
        ast.literal_eval(line.value)
        for line in ast.parse((BENCHMARKS / "tables.py").read_text("utf-8")).body
        if isinstance(line, ast.Assign) and line.targets[0].id == "TABLES"
    ]
    assert all(
        text.startswith(f"`python -m benchmarks {made[name]}`\n\n|") for name, text in kept.items()
    )
    shown = set()
    for page in {*PAGES, BENCHMARKS / "tried.md", ROOT / "paper" / "paper.md"}:
        text = page.read_text("utf-8")
        assert fill(text, kept) == text, page
        shown |= set(re.findall(r"^<!-- table (\w+) -->$", text, re.MULTILINE))
    assert shown - set(REPRODUCED_TABLES) == set(kept)
    with (BENCHMARKS / "results" / "repair_test.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    sums = [sum(float(row[column]) for row in rows) for column in ("mean_before", "mean")]
    total = [cell.strip() for cell in kept["repair_test"].splitlines()[-1].split("|")[3:6]]
    assert total[0] == str(len(rows))
    assert [float(cell) for cell in total[1:]] == pytest.approx(sums, abs=0.1 + 5e-4 * len(rows))


def test_figures_of_other_programs_are_those_that_their_tables_have():
    """Figures from other tables are not older than these."""
    for name, options in (
        ("others", []),
        ("others_first", ["--first", "3"]),
        ("others_once", ["--once"]),
    ):
        command = [sys.executable, "-m", "benchmarks", "others", *options]
        printed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True).stdout
        assert (BENCHMARKS / "results" / f"{name}.md").read_text("utf-8").partition("\n\n")[
            2
        ] == printed


def test_the_paper_has_the_parts_the_length_and_the_references_that_its_journal_asks_for():
    """Its figures stand in its table, which a file of results fills; what only its authors can state is marked."""
    paper, references = (
        (ROOT / "paper" / name).read_text("utf-8") for name in ("paper.md", "paper.bib")
    )
    prose = re.sub(
        r"<!--.*?-->|^\|[^\n]*$", "", paper.split("---\n", 2)[2], flags=re.MULTILINE | re.DOTALL
    )
    assert re.findall(r"^# (.+)$", prose, re.MULTILINE) == [
        "Summary",
        "Statement of need",
        "State of the field",
        "Software design",
        "What is not solved",
        "Research impact statement",
        "AI usage disclosure",
        "Acknowledgements",
        "References",
    ]
    words = len(prose.split())
    assert 750 <= words <= 1750
    # of the algorithms
    assert set(re.findall(r"(?<![\w@-])\d[\d.,]*\d|(?<![\w@-])\d", prose)) <= {"1", "2"}
    entries = dict(re.findall(r"^@\w+\{(\w+),\n(.*?)^\}", references, re.MULTILINE | re.DOTALL))
    assert set(re.findall(r"@(\w+)", prose)) == set(entries)
    assert {
        name
        for name, entry in entries.items()
        if not re.search(r"doi = \{10\.\d{4,5}/\S+\}", entry)
    } == {"lapy"}
    assert re.findall(r"^# (.+)\n\n<!-- OWNER: ", paper, re.MULTILINE) == [
        "Research impact statement",
        "AI usage disclosure",
    ]


_NUMBER = re.compile(r"\d+(?:,\d{3})*(?:\.\d+)?")
#: Pictures whose captions show numbers, and which are drawn in seconds; a release draws the others, too.
CAPTIONED = ["dino.png", "caps.png"]


@pytest.mark.skipif(bool(missing()), reason=missing())
def test_the_captions_of_a_picture_are_what_its_command_draws(tmp_path):
    """Number by number where these are computed as they were; elsewhere in words, and in what is without foldings."""
    command = [sys.executable, DOCS / "pictures.py", *CAPTIONED, "--to", tmp_path]
    done = subprocess.run(command, capture_output=True, text=True, env=environment(tmp_path))
    assert done.returncode == 0, done.stderr
    for name in CAPTIONED:
        (made_with, made), (kept_with, kept) = (
            captions(folder / name) for folder in (tmp_path, IMAGES)
        )
        if made_with == kept_with:
            assert made == kept, f"python docs/pictures.py {name} makes it anew"
        else:
            assert _NUMBER.sub("#", made) == _NUMBER.sub("#", kept)
            none = [
                [float(number.replace(",", "")) == 0 for number in _NUMBER.findall(text)]
                for text in (made, kept)
            ]
            assert none[0] == none[1]


def captions(path):
    """The origin of a picture's numbers, and its captions."""
    with pytest.importorskip("PIL.Image").open(path) as image:
        if path.suffix == ".gif":
            first, _, rest = image.info["comment"].decode().partition("\n")
            return first, rest
        return image.text.get("made with", ""), image.text.get("captions", "")


def test_what_is_said_of_a_picture_in_numbers_is_in_its_captions():
    for page in PAGES:
        for alt, name in re.findall(
            r"!\[(.*?)\]\(\S*images/(\w+\.(?:png|gif))\)", page.read_text("utf-8")
        ):
            said, drawn = (
                set(re.findall(r"\d[\d.,]*\d|\d", text))
                for text in (alt, captions(IMAGES / name)[1])
            )
            assert said <= drawn, (page, alt)


def test_the_papers_example_in_the_readme_prints_what_its_comment_says():
    text = (ROOT / "README.md").read_text()
    low, high = map(int, re.search(r"paper\.rounds: .* (\d+) to (\d+) here\n", text).groups())
    v, f = ism.samples.make("dino", n_vertices=1500)
    rounds = ism.spherical_conformal_map(v, f, method="lai2014").rounds
    assert low <= rounds[0].foldings_after <= high
    assert rounds[-1].foldings_after == 0
