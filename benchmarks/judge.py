"""Judge the spheres, disks and maps between surfaces that any programs wrote: exact signs, angles, areas, edges.

    python -m benchmarks judge --meshes DIR                      write the 50 meshes there, and nothing else
    python -m benchmarks judge --meshes DIR FOLDER ...           judge the files of each FOLDER
    python -m benchmarks judge --meshes DIR --run FOLDER         run the programs that are installed here, and judge
    python -m benchmarks judge [--kind sphere|disk|map]          print what is known
    python -m benchmarks judge --published FOLDER                judge what programs and data sets ship themselves

A program maps each DIR/NAME.ply to a sphere about the origin, or to the plane if it has a boundary, or onto
DIR/NAME.target.ply if there is one, and writes FOLDER/NAME.* in any format that the package reads, positions as .npy
or tables among them, vertices and faces in the mesh's order. FOLDER/times.tsv may have lines of a name, seconds, and a
note. DIR may hold other meshes. A sphere's radius is not judged: signs are those of directions from the origin. A map
between surfaces is judged on the conformal sphere of its target, which keeps small triangles upright.

Rows of the programs that were judged are replaced in --table; --page has tables by program and class of meshes.
The files of --published are brought to FOLDER, those of repositories from --clones if they are there.
SDEM_FOLDER and SEM_FOLDER name the folders of MATLAB code for programs in Octave.
"""

from __future__ import annotations

import csv
import re
import subprocess
import sys
import warnings
from dataclasses import dataclass
from functools import cached_property, partial
from html import escape
from pathlib import Path

import numpy as np

import igl_spheremap as ism
from igl_spheremap.draw import markup
from igl_spheremap.io.files import read_sphere
from igl_spheremap.io.plane_map import read_images
from igl_spheremap.io.scalars import read_scalars
from igl_spheremap.plane.plane_map import in_space
from igl_spheremap.resampling.transfer import interpolate
from igl_spheremap.shapes.correspondence.surface_map import nearest
from igl_spheremap.sphere.rows import row_lengths, unit_rows
from igl_spheremap.verify.certificate import UNIT_TOLERANCE, Certificate
from igl_spheremap.verify.distortion import angle_figures, log_figures

from .common import ROOT, fault, limit_time, parser, timed
from .judge_published import COLUMNS as PUBLISHED_COLUMNS
from .judge_published import by_verdict, judge_published

RESULTS = Path(__file__).with_name("results") / "judge.tsv"
TIMES = "times.tsv"
KINDS = {"sphere": "Spheres", "disk": "Disks", "map": "Maps between surfaces"}
#: Columns of the table, each number a mean over faces, corners or edges.
COLUMNS = (
    "program",
    "mesh",
    "kind",
    "vertices",
    "verdict",
    "folds",
    "degree",
    "crossings",
    "angle",
    "angle_p99",
    "area",
    "edge",
    "seconds",
    "note",
)
MEASURES = {
    "angle": "angle, degrees",
    "angle_p99": "angle, 99 %",
    "area": "log area",
    "edge": "log edge",
    "seconds": "CPU s",
}
#: What the page begins with.
NOTES = (
    "Folds, degrees and crossings are exact. Figures are means over a mesh, of sizes: differences of angles in "
    "degrees, natural logarithms of ratios of areas and of lengths of edges, each surface having area 1; then "
    "their median and largest over meshes. A mesh without a map counts as worse than any in a median. Seconds are "
    "as reported."
)
#: Files of positions without faces.
_PLAIN = (".npy", ".csv", ".tsv", ".txt", ".1d")
#: A note names radii that differ by more than this share, and distances from a target above this share of its diagonal.
_OFF = {"sphere": UNIT_TOLERANCE, "map": 1e-3}
_NOTE = 160  # letters of a note, which is a cell of the page


class Unfit(Exception):
    """A file that is not a map of its mesh: a verdict and a note."""


@dataclass(frozen=True)
class Task:
    """A mesh, and the target if it is to be mapped onto another one."""

    name: str
    v: np.ndarray
    f: np.ndarray
    target: tuple[np.ndarray, np.ndarray] | None

    @cached_property
    def kind(self) -> str:
        """The target of its map."""
        edges = np.sort(self.f[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        closed = (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
        return "map" if self.target is not None else "sphere" if closed else "disk"

    @property
    def group(self) -> str:
        """The class of meshes, by its name."""
        return re.sub(r"_?\d+$", "", self.name) or self.kind

    @cached_property
    def sphere(self) -> ism.SphereMap:
        """The target's."""
        return ism.spherical_conformal_map(*self.target)


def read_tasks(folder: Path) -> list[Task]:
    """The meshes of a folder."""
    files = {path.name: path for path in sorted(folder.iterdir()) if path.suffix != ".tsv"}
    ends = {name: path for name, path in files.items() if ".target." in name}
    targets = {name.partition(".")[0]: tuple(ism.read_mesh(path)) for name, path in ends.items()}
    return [
        Task(
            path.name.partition(".")[0],
            *ism.read_mesh(path),
            targets.get(path.name.partition(".")[0]),
        )
        for name, path in files.items()
        if name not in ends
    ]


def judge(folder: Path, tasks: list[Task], program: str) -> list[dict]:
    """A row for each mesh of a kind that the folder has files of."""
    files: dict[str, list[Path]] = {}
    for path in sorted(folder.rglob("*")):
        if path.is_file() and path.name != TIMES:
            files.setdefault(path.name.partition(".")[0], []).append(path)
    times, notes = read_times(folder / TIMES)
    kinds = {
        task.kind
        for task in tasks
        if task.name in files or task.name in times or task.name in notes
    }
    rows = []
    for task in (task for task in tasks if task.kind in kinds):
        found = files.get(task.name, [])
        try:
            if len(found) != 1:
                raise Unfit(
                    "several files" if found else "missing", ", ".join(path.name for path in found)
                )
            figures = figures_of(task, read_positions(task, found[0]))
        except Unfit as error:
            figures = dict(zip(("verdict", "note"), error.args, strict=True))
        figures["note"] = "; ".join(filter(None, (figures.get("note"), notes.get(task.name))))
        rows.append(
            {
                "program": program,
                "mesh": task.name,
                "kind": task.kind,
                "vertices": len(task.v),
                "seconds": times.get(task.name),
            }
            | figures
        )
    return rows


def read_times(path: Path) -> tuple[dict[str, float], dict[str, str]]:
    """Seconds and notes by names of meshes."""
    times, notes = {}, {}
    for line in path.read_text("utf-8").splitlines() if path.exists() else ():
        name, seconds, note = (*line.split("\t", 2), "", "")[:3]
        try:
            times[name] = float(seconds)
        except ValueError:
            note = note or seconds  # a header, or no time
        if note:
            notes[name] = note
    return times, notes


def read_positions(task: Task, path: Path) -> np.ndarray:
    """Positions of the mesh's vertices in a file; Unfit says why there are none."""
    try:
        faces = None
        if path.name.lower().endswith(_PLAIN):
            x = np.column_stack(list(read_scalars(path).values()))
        elif task.kind == "disk":
            x, faces = read_images(path).plane, ism.read_mesh(path).f
        else:
            x, faces = read_sphere(path) if task.kind == "sphere" else ism.read_mesh(path)
    except Exception as error:  # whatever a file holds is a row
        raise Unfit(
            "unreadable", str(error).replace(f"{path}: ", "").replace(str(path), path.name)
        ) from error
    columns = 2 if task.kind == "disk" else 3
    if x.shape[1:] != (columns,):
        raise Unfit("unreadable", f"{x.shape[1]} columns, not {columns}")
    if len(x) != len(task.v):
        raise Unfit("another mesh", f"{len(x)} vertices, the mesh has {len(task.v)}")
    if faces is not None and len(faces) != len(task.f):
        raise Unfit("another mesh", f"{len(faces)} faces, the mesh has {len(task.f)}")
    if faces is not None and not np.array_equal(
        *(np.unique(np.sort(f, axis=1), axis=0) for f in (faces, task.f))
    ):
        raise Unfit("another mesh", "as many faces, but others: the vertices have another order")
    bad = np.flatnonzero(~np.isfinite(x).all(axis=1))
    if len(bad):
        raise Unfit("not finite", f"{len(bad)} vertices, e.g. {bad[0]}")
    return x


def figures_of(task: Task, x: np.ndarray) -> dict:
    """Verdict, exact counts, and changes of angles, areas and edges."""
    note = ""
    if task.kind == "disk":
        rim = ism.check_disk(task.v, task.f).rim
        own, mirror = (Certificate.of_plane(p, task.f, rim) for p in (x, x * [-1, 1]))
        image = in_space(x)
    else:
        on, image, note = on_sphere(task, x)
        own, mirror = (Certificate.of(p, task.f) for p in (on, on * [-1, 1, 1]))
    reflected = mirror.foldings < own.foldings
    upright = mirror if reflected else own
    wrong = (
        "folded"
        if upright.foldings
        else "crossing"
        if len(upright.crossings)
        else ""
        if upright.degree == 1
        else "covered"
    )
    if wrong == "covered":
        note = f"{note}{'; ' * bool(note)}the sphere is covered {own.degree} times: is its centre the origin?"
    angle = angle_figures(ism.angle_differences(task.v, task.f, image))
    return {
        "verdict": f"mirrored{', ' * bool(wrong)}{wrong}" if reflected else wrong or "certified",
        "folds": upright.foldings,
        "degree": own.degree,
        "crossings": len(upright.crossings),
        "angle": angle["mean"],
        "angle_p99": angle["p99"],
        "area": log_figures(ism.log_area_ratios(task.v, task.f, image))["mean"],
        "edge": log_figures(ism.log_length_ratios(task.v, task.f, image))["mean"],
        "note": note,
    }


def on_sphere(task: Task, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, str]:
    """Directions whose signs are judged, positions whose figures are taken, and a note."""
    if task.kind == "sphere":
        if not x.any(axis=1).all():
            raise Unfit("not finite", "vertices at the origin have no direction")
        lengths = row_lengths(x)
        off = np.abs(lengths / np.median(lengths) - 1).max()
        return x, unit_rows(x), f"radii vary by {off:.2g}" if off > _OFF["sphere"] else ""
    target = task.sphere
    on = nearest(target, x, "the target")
    off = row_lengths(interpolate(target.vertices, target.faces, on) - x).max()
    off /= np.linalg.norm(np.ptp(target.vertices, axis=0))
    directions = unit_rows(interpolate(target.sphere, target.faces, on))
    return directions, x, f"up to {off:.2g} diagonals off the target" if off > _OFF["map"] else ""


def run(folder: Path, meshes: Path, only: list[str], seconds: int) -> None:
    """Let the programs that are installed write their files, each in a process of its own; what is there stays."""
    from .judge_programs import PROGRAMS

    tasks = read_tasks(meshes)
    for program in dict.fromkeys(name for programs in PROGRAMS.values() for name in programs):
        place = folder.resolve() / program
        command = [
            sys.executable,
            "-m",
            "benchmarks",
            "judge",
            "--trials",
            program,
            meshes.resolve(),
            place,
            seconds,
        ]
        while (not only or program in only) and pending(program, tasks, place):
            done = subprocess.run(
                [*map(str, command)], cwd=ROOT, stdout=subprocess.DEVNULL, check=False, text=True
            )
            if not done.returncode:
                break  # all are done, or it is not installed
            add_time(
                place,
                pending(program, tasks, place)[0],
                "",
                fault(done, f"not done after {seconds} s"),
            )


def pending(program: str, tasks: list[Task], place: Path) -> list[Task]:
    """The meshes that a program has not tried."""
    from .judge_programs import PROGRAMS

    times, notes = read_times(place / TIMES)
    return [
        task for task in tasks if program in PROGRAMS[task.kind] and task.name not in times | notes
    ]


def add_time(place: Path, task: Task, seconds: object, text: str) -> None:
    """Add a line to the times of a program."""
    print(place.name, task.name, seconds, text, file=sys.stderr, flush=True)
    place.mkdir(parents=True, exist_ok=True)
    with (place / TIMES).open("a", encoding="utf-8") as file:
        print(task.name, seconds, " ".join(text.split())[:_NOTE], sep="\t", file=file)


def trials(program: str, meshes: Path, place: Path, seconds: int) -> None:
    """Let a program map all meshes that it has not tried, after a small one of each kind."""
    from .judge_programs import COLD, PROGRAMS, small

    warm = set()
    for task in pending(program, read_tasks(meshes), place):
        call = PROGRAMS[task.kind][program]
        limit_time(seconds)
        try:
            if program not in COLD and task.kind not in warm:
                warm.add(task.kind)
                call(*small(task.kind))
            found, taken = timed(partial(call, task.v, task.f, *(task.target or ())))
            x, taken = found if isinstance(found, tuple) else (found, taken)
            place.mkdir(parents=True, exist_ok=True)
            ism.write_mesh(
                place / f"{task.name}.ply",
                in_space(x) if x.shape[1] == 2 else x,
                task.f,
                force=True,
            )
        except ImportError as error:
            print(f"{program}: {error}", file=sys.stderr)
            return
        except Exception as error:  # whatever a program raises is a row
            add_time(place, task, "", f"{type(error).__name__}: {error}")
        else:
            add_time(place, task, f"{taken:.4f}", "")


def numbers(rows: list[dict], measure: str) -> tuple[float, float]:
    """Median and largest of a measure; a mesh without a figure counts as worse than any in the median."""
    values = [float(row[measure]) if row.get(measure) not in (None, "") else np.inf for row in rows]
    values = [value if np.isfinite(value) else np.inf for value in values]
    return float(np.median(values)), max(
        (value for value in values if np.isfinite(value)), default=np.inf
    )


def text(value: float) -> str:
    """Three digits; a dash where there is no figure."""
    return f"{value:.3g}" if np.isfinite(value) else "-"


def by_program(rows: list[dict]) -> dict[str, list[dict]]:
    """Rows of each program, those with the most certified maps first, and of these those with the least angles."""
    found = {
        name: [row for row in rows if row["program"] == name]
        for name in sorted({row["program"] for row in rows})
    }
    return dict(
        sorted(found.items(), key=lambda item: (-certified(item[1]), numbers(item[1], "angle")))
    )


def certified(rows: list[dict]) -> int:
    """How many maps are certified."""
    return sum(row["verdict"] == "certified" for row in rows)


def summary(rows: list[dict]) -> list[list[str]]:
    """Head and rows of the table of programs on one kind of meshes."""
    lines = [["program", "certified", "folded faces", "no map", *MEASURES.values()]]
    for program, some in by_program(rows).items():
        made = [row for row in some if row.get("angle") not in (None, "")]
        lines.append(
            [
                program,
                f"{certified(some)} of {len(some)}",
                str(sum(int(row["folds"]) for row in made)),
                str(len(some) - len(made)),
                *("; ".join(map(text, numbers(some, each))) for each in MEASURES),
            ]
        )
    return lines


def by_class(rows: list[dict], groups: dict[str, str], measure: str) -> list[list[str]]:
    """Head and rows of one measure, by program and class of meshes."""
    classes = list(dict.fromkeys(groups[row["mesh"]] for row in rows))
    lines = [["median; worst", *classes]]
    for program, found in by_program(rows).items():
        some = [[row for row in found if groups[row["mesh"]] == each] for each in classes]
        lines.append(
            [
                program,
                *("; ".join(map(text, numbers(each, measure))) if each else "" for each in some),
            ]
        )
    return lines


def best(rows: list[dict]) -> list[list[str]]:
    """Head and rows of which certified map of a mesh is best, by each measure."""
    lines = [["certified maps with the least", *MEASURES.values()]]
    for mesh in dict.fromkeys(row["mesh"] for row in rows):
        some = [row for row in rows if row["mesh"] == mesh and row["verdict"] == "certified"]
        cells = []
        for each in MEASURES:
            value, program = min(
                ((numbers([row], each)[0], row["program"]) for row in some), default=(np.inf, "")
            )
            cells.append(f"{text(value)} {program}")
        lines.append([mesh, *cells])
    return lines


def write_page(path: Path, rows: list[dict]) -> None:
    """Tables of each kind of meshes, as one file."""
    parts = ["<h1>Maps of meshes, judged</h1>", f"<p>{escape(NOTES)}</p>"]
    groups = {row["mesh"]: Task(row["mesh"], *(None,) * 3).group for row in rows}
    for kind, title in KINDS.items():
        if some := [row for row in rows if row["kind"] == kind]:
            parts += [f"<h2>{title}</h2>", _html(summary(some))]
            for measure, name in MEASURES.items():
                parts += [f"<h3>{escape(name)}</h3>", _html(by_class(some, groups, measure))]
            parts += [
                "<h3>The best of each mesh</h3>",
                _html(best(some)),
                "<h3>All</h3>",
                _html([COLUMNS, *([shown(row.get(each)) for each in COLUMNS] for row in some)]),
            ]
    path.write_text(markup.page("Maps of meshes, judged", "\n".join(parts)), encoding="utf-8")


def _html(lines) -> str:
    return markup.table(lines[1:], lines[0])


def shown(value: object) -> str:
    """A cell of the table of all rows."""
    return "" if value is None else f"{value:.5g}" if isinstance(value, float) else str(value)


def read_table(path: Path) -> list[dict]:
    """Rows that are known."""
    if not path.exists():
        return []
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file, delimiter="\t"))


def write_table(path: Path, rows: list[dict]) -> None:
    """Keep rows, those of a program together."""
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, delimiter="\t", lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(
            [shown(row.get(each)) for each in COLUMNS]
            for row in sorted(
                rows, key=lambda row: (row["program"], list(KINDS).index(row["kind"]))
            )
        )


def main(argv: list[str]) -> None:
    """Write meshes, run programs, judge, and print a table of programs for each kind of meshes."""
    if argv[:1] == ["--trials"]:
        program, meshes, place, seconds = argv[1:]
        return trials(program, Path(meshes), Path(place), int(seconds))
    words = parser(__doc__)
    words.add_argument("folders", nargs="*", type=Path, metavar="FOLDER")
    words.add_argument(
        "--meshes",
        type=Path,
        metavar="DIR",
        help="what is mapped; without FOLDER the 50 meshes are written there if it does not exist",
    )
    words.add_argument(
        "--program", metavar="NAME", help="name of the program of one FOLDER; that of the folder"
    )
    words.add_argument(
        "--run",
        type=Path,
        metavar="FOLDER",
        help="run the programs that are installed here, each with a folder there",
    )
    words.add_argument("--only", nargs="+", default=[], metavar="NAME", help="programs to run")
    words.add_argument(
        "--cap", type=int, default=60, help="CPU seconds that a program may take for a mesh (60)"
    )
    words.add_argument("--kind", choices=KINDS, help="what to print")
    words.add_argument(
        "--table",
        type=Path,
        default=RESULTS,
        help="rows that are known (benchmarks/results/judge.tsv)",
    )
    words.add_argument(
        "--page",
        type=Path,
        default=Path("judge.html"),
        help="the page that is written (judge.html)",
    )
    words.add_argument(
        "--published", type=Path, metavar="FOLDER", help="where published files are kept"
    )
    words.add_argument(
        "--clones", type=Path, metavar="DIR", help="of repositories, as OWNER+NAME/repo"
    )
    args = words.parse_args(argv)
    warnings.simplefilter("ignore")  # of other programs
    if args.published is not None:
        found = judge_published(args.published, args.clones)
        with args.table.with_name("judge_published.csv").open(
            "w", newline="", encoding="utf-8"
        ) as file:
            writer = csv.DictWriter(file, PUBLISHED_COLUMNS, restval="", lineterminator="\n")
            writer.writeheader()
            writer.writerows(found)
        return print_table(by_verdict(found))
    folders = {args.program or path.resolve().name: path for path in args.folders}
    if len(folders) < len(args.folders):
        words.error("several folders of one name: judge them one by one, with --program")
    meshes = args.meshes
    if meshes is None and (args.run or folders):
        words.error("give --meshes DIR, the meshes that are mapped")
    if meshes is not None and not meshes.exists():
        if folders:
            words.error(f"there is no {meshes}; --meshes {meshes} alone writes the 50 meshes there")
        from .judge_meshes import write

        write(meshes)
    if args.run:
        run(args.run, meshes, args.only, args.cap)
        folders |= {path.name: path for path in sorted(args.run.iterdir()) if path.is_dir()}
    rows = read_table(args.table)
    if folders:
        tasks = read_tasks(meshes)
        judged = [
            row for program, folder in folders.items() for row in judge(folder, tasks, program)
        ]
        for name in {args.program or path.resolve().name for path in args.folders} - {
            row["program"] for row in judged
        }:
            words.error(
                f"{folders[name]} has no file that is named after a mesh of {meshes}, such as "
                f"{tasks[0].name}.ply"
            )
        rows = [row for row in rows if row["program"] not in folders] + judged
        write_table(args.table, rows)
        rows = [
            row for row in read_table(args.table) if row["mesh"] in {task.name for task in tasks}
        ]
        write_page(args.page, rows)
    for kind in KINDS if args.kind is None else [args.kind]:
        print_table(summary([row for row in rows if row["kind"] == kind]))


def print_table(lines: list[list[str]]) -> None:
    """Print a head and its rows, if there are any, as a table of a page."""
    head, *rows = lines
    for line in (head, ["---"] + ["---:"] * (len(head) - 1), *rows) if rows else ():
        print(f"| {' | '.join(line)} |")
