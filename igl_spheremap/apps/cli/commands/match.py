"""`match`: a map from one surface to another."""

from argparse import Namespace

import numpy as np

from ....balance import AREA_PRESERVING
from ....io.formats import format_of
from ....io.scalars import read_landmarks
from ....io.write_mesh import write_mesh
from ....mesh.arrays import IntArray
from ....result.findings import certificate_numbers
from ....shapes.correspondence.files import write_surface_map
from ....shapes.correspondence.matching import match
from ....shapes.correspondence.surface_map import SurfaceMap
from ...viewer.app import open_for, run_app
from ...viewer.carried_view import CarriedView
from ..exits import Exit, UsageError
from ..inputs import STREAM, InputMesh, load_source, map_of, up_of
from ..output import Findings, check_outputs, pictures_of, write_surface
from .register import read_features


def run_match(args: Namespace) -> Exit:
    if args.source == args.other == STREAM:
        raise UsageError("stdin is read once: give one of the surfaces as a file")
    if args.overlay:
        for path in args.overlay:
            format_of(path)
    check_outputs(args, surface=True)
    pictures = pictures_of(args)
    if args.show or pictures.offscreen:
        both = f"{args.source} onto {args.other}"
        open_for(pictures, title=f"{both} - match", said=f"matching {both}")
    sources = [load_source(args, name) for name in (args.source, args.other)]
    landmarks, features = None, None
    if args.landmarks:
        landmarks = _landmarks(args.landmarks, sources)
    curves = [_vertices(files, sources) for files in args.curve]
    if args.feature:
        features = read_features(args.feature, *sources)[1]
    maps = [map_of(args, source, balance=AREA_PRESERVING) for source in sources]
    args.progress.begin(f"matching {sources[0].name} with {sources[1].name}")
    result = match(
        *maps,
        landmarks=landmarks,
        features=features,
        curves=curves,
        feature_weight=args.feature_weight,
        soft=args.soft,
        reflect=args.reflect,
        listener=args.progress.listener(maps[0].faces),
    )
    held = _write(args, result, sources[1])
    args.progress.begin("measuring the map on the overlay")
    if args.overlay:
        common = result.overlay()
        for path, v in zip(args.overlay, (common.on_source, common.on_target), strict=True):
            write_mesh(path, v, common.faces, force=args.force)
    found = Findings(target=args.target)
    for label, source in zip(("source", "onto"), sources, strict=True):
        found.mesh(label, source)
    _describe(found, result)
    found.add("written", f"{args.target}: {held}")
    if args.overlay:
        found.add("overlay", f"{' and '.join(args.overlay)}: {len(common.faces)} faces, on each")
    return found.report_beside(
        args,
        pictures,
        lambda: run_app(
            CarriedView(result, up=up_of(args, sources[0]), subject=args.colours),
            pictures,
            progress=args.progress,
        ),
    )


def _write(args: Namespace, result: SurfaceMap, target: InputMesh) -> str:
    """Write OUT, and describe it."""
    if args.target.lower().endswith(".npz"):
        args.progress.begin(f"writing {args.target}")
        write_surface_map(args.target, result, force=args.force)
        return "both maps and the landmarks"
    write_surface(args, result.positions, result.map.faces, target.metadata)
    return "TARGET's positions on the connectivity of SOURCE"


def _landmarks(files: list[str], sources: list[InputMesh]) -> tuple[IntArray, IntArray]:
    """As many vertices of the source as of the target."""
    landmarks = _vertices(files, sources)
    m, n = map(len, landmarks)
    if m != n:
        raise UsageError(
            f"{files[0]} has {m} landmarks but {files[1]} has {n}; give lists of the same landmarks in "
            "the same order"
        )
    return landmarks


def _vertices(files: list[str], sources: list[InputMesh]) -> tuple[IntArray, IntArray]:
    """The vertices of the source and of the target in two lists."""
    a, b = (read_landmarks(file) for file in files)
    for file, source, vertices in zip(files, sources, (a, b), strict=True):
        if vertices.max() >= len(source.v):
            raise UsageError(
                f"{file} names vertex {vertices.max()} but {source.name} has vertices 0 to "
                f"{len(source.v) - 1}"
            )
    return a, b


def _describe(found: Findings, result: SurfaceMap) -> None:
    """Certificates, distortion in both directions, landmarks and notes."""
    certificate = result.map.certificate
    found.add(
        "map",
        f"SOURCE to the sphere of TARGET: {certificate}",
        certificate=certificate_numbers(certificate),
    )
    figures = result.distortion().figures
    found.figures["distortion"] = figures
    for over, name in (("over_source", "source"), ("over_target", "target")):
        dirichlet, area, angle = (
            figures[over][key] for key in ("symmetric_dirichlet", "area_ratio", "angle_ratio")
        )
        found.add(
            f"over {name}",
            f"symmetric Dirichlet energy {dirichlet['median']:.3g} (median; 4 is an isometry), "
            f"95% below {dirichlet['p95']:.3g}, {100 * dirichlet['above_100']:.2g}% of the area above 100; areas "
            f"times {area['median']:.3g}, 95% below {area['p95']:.3g}; angles by singular values' ratio "
            f"{angle['median']:.3g}, 95% below {angle['p95']:.3g}",
        )
    errors = result.landmark_errors
    if len(errors):
        size = float(np.ptp(result.target.vertices, axis=0).max())
        missed = int(np.count_nonzero(errors > 1e-9 * size))
        text = f"{len(errors)}, {missed} of them missed; the farthest is {errors.max():.3g} off, in units of TARGET"
        found.add("landmarks", text, landmark_errors=errors)
    found.notes(result.notes)
