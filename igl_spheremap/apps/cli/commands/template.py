"""`template`: the mean of many surfaces, its modes, and new surfaces in a group that stays."""

import re
import shutil
from argparse import Namespace
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....balance.balanced_spherical_map import balanced_spherical_map
from ....errors import FileError, MapError, MeshError, import_optional, one_line, without_name
from ....io.files import read_mesh
from ....io.pages import check_own_page
from ....io.replacing import REPLACE, make_folder
from ....io.tables import read_cells, write_cells
from ....io.written_map import write_map
from ....mesh.arrays import FloatArray
from ....populations.map_many import filled
from ....populations.ratings import failed_in
from ....shapes.groups.design import data_of, read_design, test_names, write_test
from ....shapes.groups.features import FeatureFiles
from ....shapes.groups.files import (
    ARCHIVE,
    file_names,
    member_row,
    member_rows,
    read_group,
    write_group,
)
from ....shapes.groups.group import Group
from ....shapes.groups.page import (
    write_group_page,
    write_series_film,
    write_series_page,
    write_tests,
)
from ....shapes.groups.permutation import LEVEL, PointTest, indicators, permutation_test
from ....shapes.groups.series import series
from ....shapes.groups.series_files import ARCHIVE as SERIES
from ....shapes.groups.series_files import write_series
from ....shapes.groups.template import template
from ..arguments import refuse_flags
from ..exits import Exit, UsageError, usage
from ..inputs import expand
from ..output import LISTED, Findings, command_of
from .batch import engine_of

_PAGE, _FILM = "index.html", "frames.gif"
_COMMON = ("out", "json", "quiet")
#: Uses of the command besides making a group, and the flags that each takes.
_TAKEN = {
    "series": (
        "feature",
        "to",
        "balance",
        "exclude",
        "ratings",
        "force",
        "jobs",
        "scheduler",
        "resume",
        "retry-failed",
        "timeout",
        "retries",
    ),
    "add": (),
    "design": ("of", "permutations", "augment"),
}


def run_template(args: Namespace) -> Exit:
    given = [args.sources, args.add, args.design is not None]
    if sum(map(bool, given)) != 1:
        raise UsageError(
            "give surfaces of a new group, or one of --add NEW and --design TABLE for one that exists"
        )
    _refuse_unused(args)
    if args.add:
        return _add(args)
    if args.design is not None:
        return _test(args)
    if args.series:
        return _follow(args)
    return _make(args)


def _refuse_unused(args: Namespace) -> None:
    """Refuse flags that this use of the command would ignore."""
    way = next((way for way in _TAKEN if getattr(args, way)), None)
    if way is None:
        refuse_flags(args, [f"--{name}" for name in _TAKEN["design"]], "a new group")
        return
    taken = {f"--{name}" for name in (*_COMMON, way, *_TAKEN[way])}
    flags = [names[-1] for names, _ in args.row.arguments if names[-1].startswith("--")]
    refuse_flags(args, [flag for flag in flags if flag not in taken], f"--{way}")


def _make(args: Namespace) -> Exit:
    """A new group, in files."""
    kept, excluded, names, features = _given(args, ARCHIVE)
    out = make_folder(args.out)
    group = template(
        kept,
        features=features,
        modes=args.modes,
        target=args.to,
        balance=args.balance,
        rigid=args.rigid,
        out=out,
        engine=engine_of(args),
    )
    failed = group.left_out
    group = replace(group, left_out={**excluded, **failed}, feature_names=names)
    args.progress.begin("writing")
    write_group(out, group, force=True)
    write_group_page(out / _PAGE, group, command_of(args))
    # the maps stay, for another group of these surfaces
    shutil.rmtree(out / "work" / "rounds", ignore_errors=True)
    status = _describe(args, group)
    if failed:
        return Exit.FAILED
    return status


def _follow(args: Namespace) -> Exit:
    """A series, in files."""
    kept, _, names, features = _given(args, SERIES)
    found = series(
        kept,
        features=features,
        target=args.to,
        balance=args.balance,
        out=make_folder(args.out),
        engine=engine_of(args),
    )
    args.progress.begin("writing")
    out = Path(args.out)
    mean = write_series(out, found, kept, names)
    write_series_film(out / _FILM, found, mean)
    write_series_page(out / _PAGE, found, mean, _FILM, kept, names, command_of(args))
    summary, off = Findings(), np.sqrt((found.drift**2).mean())
    summary.add("frames", f"{len(kept)}, followed at {len(mean)} points", frames=kept)
    for label, values in (("area", found.surface_areas), ("volume", found.volumes)):
        summary.add(
            label,
            f"{values[0]:.5g} in the first frame, {values[-1]:.5g} in the last",
            **{label: values},
        )
    summary.add(
        "drift",
        f"{off:.3g} in the root mean square, {found.drift.max():.3g} at most, from the direct map of "
        "the first frame and the last",
        drift=off,
        largest_drift=found.drift.max(),
    )
    summary.add("written", f"{out / _PAGE} shows all of it, {SERIES} holds it")
    summary.notes(found.notes, "doubtful")
    return summary.report(args)


def _given(
    args: Namespace, archive: str
) -> tuple[list[str], dict[str, str], tuple[str, ...], list[FeatureFiles] | None]:
    """The surfaces to use, those that the user leaves out and why, names and files of features."""
    import_optional("PIL", "the page of a group", "io")
    names = expand(args.sources)
    excluded = _excluded(args, names)
    if not re.fullmatch(r"ico:[0-9]", args.to):
        raise UsageError(f"--to {args.to} is not an icosphere: give ico:4, or ico:5 for cortices")
    kept = [name for name in names if name not in excluded]
    feature_names, features = _features(args, kept)
    if (Path(args.out) / archive).exists() and not args.force:
        raise FileError(f"{Path(args.out) / archive} exists already; {REPLACE} replaces it")
    check_own_page(Path(args.out) / _PAGE)
    return kept, excluded, feature_names, features


def _excluded(args: Namespace, names: Sequence[str]) -> dict[str, str]:
    """The surfaces that the user leaves out, and why."""
    unknown = [name for name in args.exclude if name not in names]
    if unknown:
        raise UsageError(f"--exclude {unknown[0]} is not one of the surfaces that were given")
    excluded = dict.fromkeys(args.exclude, "excluded by --exclude")
    if args.ratings is not None:
        excluded |= failed_in(args.ratings, names)
    return excluded


def _features(
    args: Namespace, sources: Sequence[str]
) -> tuple[tuple[str, ...], list[FeatureFiles] | None]:
    """The names of --feature NAME=PATTERN, those of arrays that are written, and the files of each source, if any."""
    names, patterns = (tuple(word.partition("=")[k] for word in args.feature) for k in (0, 2))
    wrong = [
        word
        for name, word in zip(names, args.feature, strict=True)
        if not re.fullmatch(r"[A-Za-z]\w*=.+", word) or names.count(name) > 1
    ]
    if wrong:
        raise UsageError(
            f"--feature {wrong[0]}: give NAME=PATTERN, such as thickness={{folder}}/{{stem}}.thickness, "
            "each name once"
        )
    if not names:
        return names, None
    with usage("--"):
        files = [
            FeatureFiles(tuple(filled(pattern, source, "feature ") for pattern in patterns))
            for source in sources
        ]
    return names, files


def _describe(args: Namespace, group: Group) -> Exit:
    """The results, and the members left out."""
    found, model = Findings(), group.figures()
    found.add(
        "members",
        f"{len(group.members)} surfaces in correspondence at {len(group.vertices)} points",
        members=[member.name for member in group.members],
    )
    found.left_out(group.left_out)
    found.add(
        "mean",
        f"moved by {100 * group.changes[-1]:.2g} percent of its radius in round {len(group.changes)}, "
        "the last",
        changes=group.changes,
    )
    for name, mean, sd in zip(
        group.feature_names, group.feature_mean.T, group.feature_sd.T, strict=True
    ):
        found.add(
            name,
            f"{mean.min():.4g} to {mean.max():.4g}, standard deviation {np.median(sd):.3g} in the median",
            **{name: {"lowest": mean.min(), "highest": mean.max(), "median_sd": np.median(sd)}},
        )
    shares = ", ".join(f"{100 * share:.3g}" for share in group.compactness)
    found.add(
        "modes",
        f"hold {shares} percent of the variance",
        compactness=group.compactness,
        generalisation=model.generalisation,
        specificity=model.specificity,
        variances=group.variances,
    )
    far = max(group.members, key=lambda member: member.distance)
    found.add("farthest", f"{far.name}: {far.distance:.4g} from the mean")
    found.add("written", f"{Path(args.out) / _PAGE} shows all of it, {ARCHIVE} holds it")
    doubts = [f"{member.name}: {doubt}" for member in group.members for doubt in member.doubts]
    found.figures["doubts"] = {
        member.name: member.doubts for member in group.members if member.doubts
    }
    found.notes(group.notes, "doubtful")
    for line in doubts[:LISTED]:
        found.add("doubtful", line)
    return found.report(args)


def _add(args: Namespace) -> Exit:
    """Place new surfaces into a group: files of their own are written, and no other one."""
    out = Path(args.out)
    group = read_group(out)
    table, folder = out / "added.tsv", make_folder(out / "added", follow=False)
    rows: dict[str, tuple[object, ...]] = {}
    if table.exists():
        for row in read_cells(table)[1:]:
            rows[row[0]] = (*row[:4], *map(_number, row[4:]))
    names = expand(args.add)
    found, refused = Findings(), False
    others = [name for name in rows if name not in names]  # whose files stay
    for name, short in zip(names, file_names([*others, *names])[len(others) :], strict=True):
        args.progress.begin(f"placing {name}")
        cells: tuple[object, ...]
        try:
            placed = group.place(balanced_spherical_map(read_mesh(name), balance=group.balance))
            member = placed.member
            if member.map is not None:
                write_map(folder / f"{short}.npz", member.map, force=True)
            cells = (name, "added", *member_row(member, placed.scores)[2:])
            found.add("added", f"{name}: {member.distance:.4g} from the mean")
            for doubt in member.doubts:
                found.add("doubtful", f"{name}: {doubt}")
        except (MeshError, FileError, MapError) as error:
            reason = without_name(one_line(error), name)
            refused, cells = True, (name, "left out", reason)
            found.add("left out", f"{name}: {reason}")
        rows[name] = cells
    header = next(member_rows(group))
    write_cells(table, [header, *rows.values()], force=True)
    found.figures["members"] = [dict(zip(header, rows[name], strict=False)) for name in names]
    status = found.report(args)
    if refused:
        return Exit.FAILED
    return status


def _number(cell: str) -> float | str:
    """The number in a cell, which may be empty."""
    if not cell:
        return cell
    return float(cell)


def _covariates(columns: Mapping[str, NDArray[Any]], name: str) -> FloatArray | None:
    """The columns of a table but one; words as indicators. None if there is no other one."""
    others = []
    for key, values in columns.items():
        if key == name:
            continue
        if values.dtype.kind != "f":
            values = indicators(values)
        others.append(values)
    if not others:
        return None
    return np.column_stack(others)


def _figures(test: PointTest) -> dict[str, float]:
    """The share of the points below the level, the smallest p, and the figures there."""
    surest = int(test.statistic.argmax())
    return {
        "points": float((test.p <= LEVEL).mean()),
        "p": float(test.p.min()),
        "effect": float(np.linalg.norm(test.effect, axis=2).max(axis=0)[surest]),
        "error": float(test.error[:, surest].max()),
        "margin": float(test.margin[:, surest].max()),
        "explained": float(test.explained[surest]),
    }


def _test(args: Namespace) -> Exit:
    """Test the dependence on each column of a table, with the others as covariates."""
    group = read_group(args.out)
    check_own_page(Path(args.out) / _PAGE)
    columns, kept, left_out = read_design(args.design, [member.name for member in group.members])
    tested, data = (
        replace(group, members=tuple(group.members[k] for k in kept)),
        data_of(group, args.of)[kept],
    )
    rows, shown = list[tuple[object, ...]](), list[tuple[str, str, PointTest]]()
    found, tests = Findings(), dict[str, object]()
    found.figures["tests"] = tests
    found.left_out(left_out)
    for (name, values), short in zip(columns.items(), test_names(list(columns)), strict=True):
        args.progress.begin(f"testing {name}")
        try:
            test = permutation_test(
                tested,
                values,
                covariates=_covariates(columns, name),
                data=data,
                permutations=args.permutations,
                augment=args.augment,
            )
        except MeshError as error:
            raise MeshError(f"{args.design}, column {name}: {error}") from None
        write_test(str(Path(args.out) / short), group, test)
        figures = _figures(test)
        rows.append((name, *figures.values(), f"{short}.npz"))
        tests[name] = figures
        words = (
            f"{figures['points']:.1%} of the points, smallest p {figures['p']:.2g}; where it is surest the "
            f"effect is {figures['effect']:.3g} (each coordinate +- {figures['margin']:.2g} at 95 percent "
            f"confidence) and explains {figures['explained']:.0%}"
        )
        found.add(name, words)
        shown.append((name, words, test))
        for note in test.notes:
            found.add("note", f"{name}: {note}")
    header = (
        "variable",
        "share_of_points",
        "smallest_p",
        "effect",
        "standard_error",
        "margin",
        "explained",
        "file",
    )
    table = Path(args.out) / "tests.tsv"
    write_cells(table, [header, *rows], force=True)
    write_tests(table.with_name(_PAGE), group, shown, command_of(args))
    found.add(
        "written", f"{table.with_name(_PAGE)} shows them, {table} and files beside it hold them"
    )
    return found.report(args)
