"""Outputs of commands: OUT, which may be stdout, a summary in 80 columns for people, and JSON for programs."""

import json
import math
import os
import shlex
import sys
import tempfile
import textwrap
from argparse import Namespace
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ...draw.plot import FORMATS
from ...errors import FileError, import_optional, printable
from ...gate import PathLike
from ...io.formats import Format, format_of
from ...io.pages import check_own_page, page_file
from ...io.replacing import check_writable, replacing
from ...io.write_mesh import write_mesh
from ...io.written_map import SphereCheck, write_map
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray
from ...result.findings import Finding
from ...verify.certificate import Certificate
from ..viewer.choices import Pictures
from .arguments import WRITTEN
from .exits import Exit, UsageError, exit_of, usage
from .inputs import STREAM, InputMesh

_INPUTS = (
    "source",
    "other",
    "sphere",
    "patch",
    "other_sphere",
    "to",
    "data",
    "image",
    "template",
    "via",
)
_OUTPUTS = ("target", "surface", "table", "matrix", "json", "plot", "write")
#: Lines of one kind that a summary has at most: files, landmarks. Tables and JSON have them all.
LISTED = 20
_T = TypeVar("_T")


def check_outputs(args: Namespace, surface: bool = False) -> None:
    """If an output can't be written, or would replace an input, raise an error before the work starts.

    A surface as OUT needs a format that is known, and may be stdout.
    """
    target = getattr(args, "target", None)
    if target == STREAM and not surface:
        raise UsageError("OUT must be a file here, not stdout")
    if target == STREAM and args.format not in WRITTEN:
        raise UsageError(f"stdout takes text: --format {' or '.join(WRITTEN)}, not {args.format}")
    if target == STREAM == args.json:
        raise UsageError("OUT and --json can't both be stdout")
    if STREAM in (target, args.json) and sys.stdout is None:
        raise FileError("can't write stdout: it is closed")
    if target not in (None, STREAM) and os.path.isdir(target):
        raise FileError(f"{target} is a folder; name a file in it")
    others = _inputs(args)
    if surface and (kind := target_format(args)).package:
        import_optional(kind.package, kind.name, "io")
    replaced = _paths(args, ("json", "plot"))
    for path in _paths(args, (*_OUTPUTS, "overlay")):
        check_apart(path, others)
        check_writable(path, force=getattr(args, "force", False) or path in replaced)
        others.append(path)


def check_apart(path: PathLike, others: Iterable[str], flag: str = "") -> None:
    """If a file is one of others, which it would replace, raise a UsageError that names the flag."""
    if os.path.realpath(path) in set(map(os.path.realpath, others)):
        raise UsageError(
            f"{flag}{path} is an input or another output, which would be lost; write another file"
        )


def check_plots(args: Namespace) -> None:
    """If --plot and --report can't be served, raise an error before the work starts."""
    if args.plot is not None and Path(args.plot).suffix.lower() not in FORMATS:
        raise UsageError(f"--plot {args.plot}: the name must end in one of {', '.join(FORMATS)}")
    for flag in ("--plot", "--report"):
        if getattr(args, flag.lstrip("-")) is not None:
            import_optional("matplotlib", flag, "plot")
    check_report(args)


def command_of(args: Namespace) -> str:
    """The command line that made a page."""
    return shlex.join(("igl-spheremap", *args.words))


def check_report(args: Namespace, name: str = "report.html") -> None:
    """If --report names neither a page nor a folder, or would replace a file, raise an error before the work starts.

    Pages of earlier reports are replaced. `name` is a page's name in a folder.
    """
    if args.report is None:
        return
    with usage("--report "):
        path = page_file(args.report, name)
    check_own_page(path)
    if path == Path(args.report):  # a folder is made if it is missing
        check_writable(path, force=True)
        check_apart(path, (*_inputs(args), *_paths(args, _OUTPUTS)), "--report ")


def _inputs(args: Namespace) -> list[str]:
    """The files that the command reads; of --data FILE:NAME and --feature NAME=SOURCE,TARGET those within."""
    features = [
        file for word in getattr(args, "feature", ()) for file in word.partition("=")[2].split(",")
    ]
    named = [word.rpartition(":")[0] for word in (*_paths(args, ("data",)), *features)]
    return [*_paths(args, (*_INPUTS, "landmarks")), *features, *named]


def _paths(args: Namespace, names: tuple[str, ...]) -> list[str]:
    """The files that arguments of these names give, of lists all."""
    paths: list[str] = []
    for name in names:
        given = getattr(args, name, None)
        if isinstance(given, list):
            paths += given
        elif given not in (None, STREAM):
            paths.append(given)
    return paths


def target_format(args: Namespace) -> Format:
    """The format of OUT: by its name, or for stdout by --format."""
    if args.target == STREAM:
        return format_of(f"stdout.{args.format}")
    return format_of(args.target)


def write_target(args: Namespace, write: Callable[[str | Path], _T]) -> _T:
    """Write OUT by a function of a path, and return its result; OUT may be stdout."""
    args.progress.begin(f"writing {args.target}")
    if not target_format(args).ordered:
        args.progress.write(
            f"igl-spheremap: {args.target}: an STL file holds triangles and no vertices; their order "
            "is lost, other formats keep it"
        )
    if args.target != STREAM:
        return write(args.target)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"stdout.{args.format}"
        outcome = write(path)
        args.progress.close()
        sys.stdout.write(path.read_text(encoding="utf-8"))
        sys.stdout.flush()
    return outcome


def write_surface(
    args: Namespace, v: FloatArray, f: IntArray, metadata: Mapping[str, Any] | None = None
) -> str:
    """Write OUT as a surface, and say what was written."""
    write_target(args, lambda path: write_mesh(path, v, f, force=args.force, metadata=metadata))
    return f"{args.target} ({target_format(args).name}): {len(v)} vertices, {len(f)} faces"


def write_sphere(
    args: Namespace, result: SphereMap, source: InputMesh, **options: Any
) -> SphereCheck:
    """Write OUT as a map of the source by `write_map`."""
    metadata = source.metadata
    return write_target(
        args,
        lambda path: write_map(path, result, force=args.force, metadata=metadata, **options),
    )


class Findings:
    """The results of a command: figures for --json, and the lines of its summary."""

    def __init__(self, **figures: Any) -> None:
        self.figures = figures
        self.lines: list[str] = []

    def add(self, label: str, text: str, **figures: Any) -> None:
        """Add a labelled paragraph, and the figures that it states."""
        self.lines.append(paragraph(label, text))
        self.figures |= figures

    def mesh(self, label: str, source: InputMesh) -> None:
        """Add the name and the size of a mesh."""
        self.add(
            label,
            f"{source.name}: {len(source.v)} vertices, {len(source.f)} faces",
            **{label: source.name},
        )

    def source(self, source: InputMesh) -> None:
        """Add the mesh that the command read."""
        self.mesh("source", source)
        self.figures |= {
            "repairs": source.repairs,
            "vertices": len(source.v),
            "faces": len(source.f),
        }

    def extend(self, findings: Iterable[Finding]) -> None:
        """Add the findings on a map."""
        for finding in findings:
            self.add(finding.label, finding.text, **finding.numbers)

    def notes(self, notes: Sequence[str], label: str = "note") -> None:
        """Add notes, and all of them as a figure."""
        self.figures["notes"] = notes
        for note in notes:
            self.add(label, note)

    def left_out(self, reasons: Mapping[str, str]) -> None:
        """Add left-out names, with their reasons; of many only the first."""
        self.figures["left_out"] = dict(reasons)
        for name, reason in list(reasons.items())[:LISTED]:
            self.add("left out", f"{name}: {reason}")

    def written(self, **paths: PathLike | None) -> None:
        """Add the files besides OUT, each by the flag that asked for it."""
        for flag, path in paths.items():
            if path is not None:
                self.add(flag, os.fspath(path), **{flag: path})

    def report(self, args: Namespace, *certificates: Certificate) -> Exit:
        """Print the summary and write the JSON, as the flags ask; the status is that of these certificates."""
        args.progress.close()
        if args.json is not None:
            text = json.dumps(_plain(self.figures), indent=2, allow_nan=False) + "\n"
            if args.json == STREAM:
                sys.stdout.write(text)
                return exit_of(*certificates)
            with replacing(args.json, force=True) as partial:
                partial.write_text(text)
        if not args.quiet:
            stream = sys.stdout
            if getattr(args, "target", None) == STREAM:  # the surface is there
                stream = sys.stderr
            print(*self.lines, sep="\n", file=stream, flush=True)
        return exit_of(*certificates)

    def report_beside(
        self,
        args: Namespace,
        pictures: Pictures,
        show: Callable[[], object],
        *certificates: Certificate,
    ) -> Exit:
        """Print the summary, then open the window that --show asks for; or write pictures, then name them."""
        if pictures.offscreen:
            args.progress.begin("drawing")
            show()
            self.written(screenshot=pictures.screenshot, video=pictures.video)
        status = self.report(args, *certificates)
        if args.show and not pictures.offscreen:
            show()
        return status


def pictures_of(args: Namespace) -> Pictures:
    """The files of a program with a picture."""
    return Pictures(
        args.screenshot, args.video, tuple(args.size), args.frame, args.length, args.fps
    )


def mirrored(args: Namespace) -> str:
    """If --reflect was given, say that both were mirrored."""
    if not args.reflect:
        return ""
    return ", mirrored (x to -x)"


def paragraph(label: str, text: str) -> str:
    """A labelled paragraph of the summary, wrapped to 80 columns behind a label of at most 12 characters.

    >>> paragraph("energy", "12.57")
    'energy       12.57'
    """
    first = printable(label).ljust(13)
    return textwrap.fill(
        printable(" ".join(text.split())),
        80,
        initial_indent=first,
        subsequent_indent=" " * len(first),
        break_long_words=False,
        break_on_hyphens=False,
    )


def aligned(rows: Sequence[Sequence[str]], left: int) -> list[str]:
    """Lines of a table whose columns are as wide as their widest cell; this many of the first are flush left.

    >>> aligned([("round", "energy"), ("0", "43699.071234")], left=1)
    ['  round        energy', '  0      43699.071234']
    """
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    sides = "<" * left + ">" * (len(widths) - left)
    shape = "".join(f"  {{:{side}{width}}}" for side, width in zip(sides, widths, strict=True))
    return [shape.format(*row) for row in rows]


def _plain(value: Any) -> Any:
    """Convert to numbers, strings, lists and dicts; numbers that are not finite become null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.generic | np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if value is None or isinstance(value, bool | int | str | float):
        return value
    return str(value)
