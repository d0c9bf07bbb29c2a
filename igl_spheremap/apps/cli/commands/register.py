"""`register`: one mapped surface laid on another."""

from argparse import Namespace
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ....maps.sphere_map import SphereMap
from ....mesh.arrays import FloatArray
from ....result.findings import certificate_numbers
from ....shapes.correspondence import STAGES
from ....shapes.correspondence.registration import WIDTHS, Registration, reflected, register
from ...viewer.app import open_for, run_app
from ...viewer.choices import ROW_SIZE, Pictures
from ...viewer.registered_view import registration_view
from ..exits import Exit, UsageError
from ..inputs import InputMesh, load_pair, read_data, read_pair, read_source
from ..output import Findings, check_outputs, write_sphere

#: Depth potentials by their widths, which are compared without --feature.
_GEOMETRY = [f"depth ({width:g})" for width in WIDTHS]


def run_register(args: Namespace) -> Exit:
    check_outputs(args, surface=True)
    stages = [stage for stage in args.stages.split(",") if stage]
    unknown = [stage for stage in stages if stage not in STAGES]
    if unknown:
        raise UsageError(f"--stages knows no {unknown[0]!r}: choose from {', '.join(STAGES)}")
    pictures = Pictures(args.screenshot, size=ROW_SIZE)
    if args.show or pictures.offscreen:
        both = f"{args.source} on {args.other}"
        title, said = f"{both} - registration", f"registering {both}"
        open_for(pictures, instead="--screenshot OUT.png", title=title, said=said)
    pair = load_pair(args)
    source, target = pair.source, read_source(args.other)
    maps = pair.map(), read_pair(target, args.other_sphere).map()
    if args.reflect:
        maps = reflected(maps[0]), maps[1]
    names, features, shown = _GEOMETRY, None, "depth"
    if args.feature:
        names, features = read_features(args.feature, source, target)
        shown = names[0]
    args.progress.begin(f"registering {source.name}")
    listener = args.progress.listener(maps[0].faces)
    result = register(
        *maps, features=features, stages=stages, stiffness=args.stiffness, listener=listener
    )
    out = result.map
    if args.reflect:
        out = _of_the_file(out)
    written = write_sphere(args, out, source)
    found = Findings()
    found.mesh("source", source)
    found.mesh("onto", target)
    _describe(found, result, names)
    found.notes((*result.notes, *out.run.notes))
    found.add(
        "written",
        f"{args.target}: {written}",
        target=args.target,
        certificate=certificate_numbers(written),
    )
    return found.report_beside(
        args,
        pictures,
        lambda: run_app(registration_view(*maps, result, features, shown), pictures),
        written,
    )


def _of_the_file(result: SphereMap) -> SphereMap:
    """Mirror the registered map back, so that it fits the file of SOURCE; its mark says reflect=True."""
    note = "the sphere fits SOURCE as it is; x to -x of both lies on TARGET: give --reflect to transfer and resample"
    run = replace(
        result.run, settings=result.settings | {"reflect": True}, notes=(*result.run.notes, note)
    )
    return replace(reflected(result), run=run)


def read_features(
    words: list[str], source: InputMesh, target: InputMesh
) -> tuple[list[str], tuple[FloatArray, FloatArray]]:
    """The columns of all `NAME=SOURCE,TARGET`, and their names; if a file has several, a number follows."""
    columns: tuple[list[FloatArray], list[FloatArray]] = [], []
    names: list[str] = []
    for word in words:
        name, _, pair = word.partition("=")
        files = pair.split(",")
        if len(files) != 2:
            raise UsageError(
                f"--feature {word} is not of the form NAME=SOURCE,TARGET with two files"
            )
        for file, mesh, column in zip(files, (source, target), columns, strict=True):
            column.append(read_data(file, mesh))
        many, other = (column[-1].shape[1] for column in columns)
        if many != other:
            raise UsageError(
                f"--feature {word}: {many} maps in {files[0]} but {other} in {files[1]}; choose one "
                "of each by FILE:NAME"
            )
        if many == 1:
            names.append(name)
        else:
            names += [f"{name} {k + 1}" for k in range(many)]
    return names, (np.concatenate(columns[0], axis=1), np.concatenate(columns[1], axis=1))


def _describe(found: Findings, result: Registration, names: Sequence[str]) -> None:
    """Agreement of the features after each stage."""
    found.figures.update(
        rotation=result.rotation,
        candidates=[candidate.correlation for candidate in result.candidates],
        margin=result.margin,
        features=names,
        stages=[vars(stage) for stage in result.stages],
        seconds=result.map.seconds,
    )
    for stage in result.stages:
        correlation = ", ".join(
            f"of {name} {r:.4f}" for name, r in zip(names, stage.correlation, strict=True)
        )
        mean, most = (
            round(100 * np.expm1(strain), 6) for strain in (stage.strain, stage.strain_95)
        )
        found.add(
            stage.name,
            f"correlation {correlation}; areas change by {mean:.3g} percent on average, "
            f"95% below {most:.3g}",
        )
