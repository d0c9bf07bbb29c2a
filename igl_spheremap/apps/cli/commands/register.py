"""`igl-spheremap register MOVING SPHERE FIXED FIXED_SPHERE OUT`: lay one mapped surface on another."""

from __future__ import annotations

from argparse import Namespace
from typing import Any

import numpy as np

from ....errors import FoldingsRemain, MeshError
from ....io import read_sphere, write_map
from ....maps.given_sphere import sphere_map
from ....maps.sphere_map import SphereMap
from ....mesh.arrays import FloatArray
from ....shapes.registration import STAGES
from ....shapes.registration.register import Registration, register
from ...viewer.app import open_for, run_app
from ...viewer.choices import REGISTRATION_SIZE
from ...viewer.row_view import registration_view
from ..exits import Exit
from ..failures import UsageError
from ..output import certificate_figures, mesh_row, report, row
from ..pair import check_fits, load_pair
from ..source import Source, read_source
from ..streams import check_outputs, write_target
from ..vertex_data import read_data


def run(args: Namespace) -> Exit:
    """Register, write, and certify what was written."""
    check_outputs(args, surface=True)
    stages = [stage for stage in args.stages.split(",") if stage]
    unknown = [stage for stage in stages if stage not in STAGES]
    if unknown:
        raise UsageError(f"--stages knows no {unknown[0]!r}: choose from {', '.join(STAGES)}")
    args.video, args.frame, args.size = None, None, REGISTRATION_SIZE
    if args.show or args.screenshot:
        open_for(args, "igl_spheremap")
    moving, moving_name, x = load_pair(args)
    fixed = read_source(args.fixed, stage=args.progress.stage)
    y, g = read_sphere(args.fixed_sphere)
    check_fits(fixed, args.fixed_sphere, y, g)
    maps = _map(moving, moving_name, x), _map(fixed, args.fixed_sphere, y)
    features = _features(args.feature, moving, fixed) if args.feature else None
    args.progress.stage(f"registering {moving.name}")
    listener = args.progress.listener(maps[0].faces)
    result = register(*maps, features, stages, args.stiffness, reflect=args.reflect, listener=listener)
    written = write_target(args, lambda path: write_map(path, result.map, force=args.force, metadata=moving.metadata))
    summary = [
        mesh_row("moving", moving.name, len(moving.v), len(moving.f)),
        mesh_row("fixed", fixed.name, len(fixed.v), len(fixed.f)),
        *_rows(result),
        row("written", f"{args.target}: {written.certificate}"),
    ]
    report(args, {**_figures(result), "moving": moving.name, "fixed": fixed.name, "target": args.target,
                  "certificate": certificate_figures(written.certificate)}, summary)  # fmt: skip
    if args.show or args.screenshot:
        run_app(registration_view(*maps, result, features), args)
    return Exit.OK if written.certificate.folding_free else Exit.FOLDINGS


def _map(source: Source, name: str, x: FloatArray) -> SphereMap:
    try:
        return sphere_map(source.v, source.f, x)
    except (MeshError, FoldingsRemain) as error:
        raise type(error)(f"{name}: {error}") from None


def _features(words: list[str], moving: Source, fixed: Source) -> tuple[FloatArray, FloatArray]:
    """The columns of all `NAME=MOVING,FIXED`."""
    columns: tuple[list[FloatArray], list[FloatArray]] = [], []
    for word in words:
        files = word.partition("=")[2].split(",")
        if len(files) != 2:
            raise UsageError(f"--feature {word} is not of the form NAME=MOVING,FIXED with two files")
        for file, source, column in zip(files, (moving, fixed), columns, strict=True):
            column.append(read_data(file, len(source.v), source.name))
    return np.concatenate(columns[0], axis=1), np.concatenate(columns[1], axis=1)


def _rows(result: Registration) -> list[str]:
    rows = [
        row(stage.name, f"correlation {', '.join(f'{value:.4f}' for value in stage.correlation)}; areas change by "
            f"{100 * np.expm1(stage.strain):.3g} percent on average, 95% below {100 * np.expm1(stage.strain_95):.3g}")
        for stage in result.stages
    ]  # fmt: skip
    return rows + [row("note", note) for note in result.notes]


def _figures(result: Registration) -> dict[str, Any]:
    return {
        "rotation": result.rotation,
        "candidates": [candidate.correlation for candidate in result.candidates],
        "margin": result.margin,
        "stages": [vars(stage) for stage in result.stages],
        "notes": result.notes,
        "seconds": result.map.seconds,
    }
