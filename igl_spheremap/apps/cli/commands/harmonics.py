"""`harmonics`, `grid` and `mesh`: a surface, or data over it, in a basis and on a grid, and back from the grid."""

from argparse import Namespace
from math import isqrt
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ....draw.palette import colours
from ....errors import FileError, MapError, MeshError, naming, one_line, without_name
from ....io.formats import format_in
from ....io.npz import array_of, read_arrays, write_arrays
from ....io.pictures import write_picture
from ....io.reading import reading
from ....io.replacing import replacing
from ....io.scalars import file_of
from ....io.tables import SEPARATORS, write_cells
from ....io.write_mesh import write_mesh
from ....mesh.arrays import FloatArray
from ....populations.map_many import filled
from ....populations.table import check_table
from ....shapes.groups.coefficients import (
    coefficient_table,
    in_common_frame,
    write_coefficient_table,
)
from ....shapes.harmonics.files import check_name, read_coefficients, write_coefficients
from ....shapes.harmonics.geometry_image import mesh_from_grid
from ....shapes.harmonics.grid import to_grid
from ....shapes.harmonics.harmonics import SphericalHarmonics, spherical_harmonics
from ....timings import counted
from ..exits import Exit, UsageError, usage
from ..inputs import InputMap, InputMesh, expand, load_pair, read_data, read_target_sphere
from ..output import Findings, check_outputs, write_surface


def _data(args: Namespace, source: InputMesh) -> FloatArray:
    """The columns of --data; vertices of a CIFTI file that have none, those of the medial wall, count as 0."""
    values = read_data(args.data, source)
    missing = np.isnan(values).any(axis=1)
    if missing.any() and format_in(file_of(args.data)[0], data=True).sides:
        args.progress.write(
            f"igl-spheremap: {args.data}: {missing.sum()} vertices without data, the medial wall, count as 0"
        )
        values = np.nan_to_num(values)
    return values


def run_grid(args: Namespace) -> None:
    target: str = args.target
    if not target.lower().endswith((".png", ".npz", ".npy")):
        raise UsageError(f"OUT is a .png, .npz or .npy file, not {target}")
    if target.lower().endswith(".png") and args.data is None:
        raise UsageError(
            "a picture holds 8 bits of each position: give an .npz or .npy file, or --data for a picture"
        )
    if args.kind == "equiangular" and args.rows == 1:
        raise UsageError("--kind equiangular has both poles: give --rows 2 or more")
    check_outputs(args)
    pair = load_pair(args)
    source = pair.source
    values = source.v
    if args.data is not None:
        values = _data(args, source)
    args.progress.begin(f"sampling {source.name}")
    grid = to_grid(pair.map(), values, kind=args.kind, rows=args.rows, columns=args.columns)
    if target.lower().endswith(".png"):
        write_picture(target, _picture(grid), force=args.force)
    else:
        with replacing(target, args.force) as partial:
            if target.lower().endswith(".npz"):
                write_arrays(partial, {"grid": grid, "kind": args.kind})
            else:
                with partial.open("wb") as file:
                    np.save(file, grid)
    found = Findings(
        source=source.name, sphere=pair.name, target=target, kind=args.kind, shape=grid.shape
    )
    found.add("written", f"{target}: {args.kind}, {grid.shape[0]} x {grid.shape[1]}")
    found.report(args)


def run_mesh(args: Namespace) -> None:
    if not args.image.lower().endswith((".npz", ".npy")):
        raise UsageError(f"IMAGE is an .npz or .npy file, as `grid` writes them, not {args.image}")
    check_outputs(args, surface=True)
    with reading(Path(args.image)):
        if args.image.lower().endswith(".npz"):
            held = read_arrays(args.image)
        else:
            held = {"grid": array_of(Path(args.image).read_bytes())}
    if "grid" not in held:
        raise MeshError(f"{args.image} holds no array `grid`; write it by `grid --kind octahedral`")
    with naming(args.image):
        v, f = mesh_from_grid(held["grid"])
    found = Findings(image=args.image, target=args.target, vertices=len(v), faces=len(f))
    found.add("written", write_surface(args, v, f))
    found.report(args)


def _picture(grid: FloatArray) -> NDArray[np.uint8]:
    """One column by the colour scale, three as red, green and blue on a common scale."""
    columns = grid.shape[2]
    if columns == 1:
        shades = colours(grid.ravel())
        return np.stack([shades[name] for name in ("red", "green", "blue")], axis=1).reshape(
            *grid.shape[:2], 3
        )
    if columns != 3:
        raise UsageError(
            f"a picture shows one or three columns, not {columns}: choose one by --data FILE:NAME"
        )
    widest = float(np.ptp(grid, axis=(0, 1)).max())
    if widest == 0:
        widest = 1.0
    return np.round((grid - grid.min(axis=(0, 1))) * (255 / widest)).astype(np.uint8)


def run_harmonics(args: Namespace) -> Exit:
    if "{" in args.sphere:
        return _harmonics_of_all(args)
    if args.modes:
        raise UsageError(
            "--modes goes with many surfaces: give SPHERE as a pattern, such as spheres/{stem}.ply"
        )
    if args.table:
        with usage("--table "):
            check_table(args.table)
    check_outputs(args)
    check_name(args.target)
    mesh = None
    if args.surface:
        mesh = read_target_sphere(args.to)
    pair, found = load_pair(args), Findings(target=args.target)
    source = pair.source
    harmonics = _expanded(args, pair)
    found.add(
        "source",
        f"{source.name}: {len(source.v)} vertices, sphere {pair.name}",
        source=source.name,
        sphere=pair.name,
    )
    if args.align:
        template = None
        if args.template:
            template = read_coefficients(args.template)
        aligned = harmonics.align(template)
        harmonics = aligned.harmonics
        axes, skew = (
            ", ".join(f"{number:.3g}" for number in each) for each in (aligned.axes, aligned.skew)
        )
        found.add(
            "axes",
            f"half axes {axes} along x, y, z; skewness {skew}",
            axes=aligned.axes,
            skew=aligned.skew,
        )
    found.notes(harmonics.notes)
    args.progress.begin("measuring the error of each degree")
    error, power = harmonics.error(), harmonics.power()
    found.add(
        "error",
        f"{error[-1]:.3g} percent of the diagonal at degree {args.degree}",
        error_percent=error,
        degree=args.degree,
        power=power,
    )
    args.progress.begin(f"writing {args.target}")
    write_coefficients(args.target, harmonics, force=args.force)
    if mesh is not None:
        write_mesh(args.surface, *harmonics.surface(mesh), force=args.force)
    if args.table:
        rows = zip(range(args.degree + 1), error.tolist(), power.tolist(), strict=True)
        write_cells(args.table, [("degree", "error_percent", "power"), *rows], force=args.force)
    found.add("written", ", ".join(filter(None, (args.target, args.surface, args.table))))
    return found.report(args)


def _expanded(args: Namespace, pair: InputMap) -> SphericalHarmonics:
    """The surface, or its data, in the basis; a line says that its vertices do not determine the degree."""
    values, n = None, len(pair.source.v)
    if args.data is not None:
        values = _data(args, pair.source)
    coefficients = (args.degree + 1) ** 2
    if coefficients > n:
        args.progress.write(
            f"igl-spheremap: degree {args.degree} has {coefficients:,} coefficients a coordinate, more than the "
            f"{n:,} vertices determine, and takes long; they determine --degree {isqrt(n) - 1}"
        )
    args.progress.begin(f"expanding {pair.source.name}")
    return spherical_harmonics(pair.map(), values, degree=args.degree)


def _harmonics_of_all(args: Namespace) -> Exit:
    """One table of all surfaces that can be expanded."""
    for name in ("data", "template", "surface", "table"):
        if getattr(args, name):
            raise UsageError(f"--{name} goes with one surface")
    if not args.target.lower().endswith((*SEPARATORS, ".npz")):
        raise UsageError(f"OUT of many surfaces is a .tsv, .csv or .npz file, not {args.target}")
    names = expand([args.source])
    with usage(""):
        spheres = [filled(args.sphere, name, "SPHERE ") for name in names]
    check_outputs(args)
    found, shapes, reasons = Findings(target=args.target), {}, {}
    for name, sphere in counted("surfaces", list(zip(names, spheres, strict=True))):
        try:
            pair = load_pair(Namespace(**{**vars(args), "source": name, "sphere": sphere}))
            shapes[name] = spherical_harmonics(pair.map(), degree=args.degree)
        except (MeshError, FileError, MapError) as error:
            reasons[name] = without_name(one_line(error), name)
    if not shapes:
        raise MeshError(
            f"none of {len(names)} surfaces can be expanded; {names[0]}: {reasons[names[0]]}"
        )
    rows = list(shapes.values())
    if args.align:
        args.progress.begin("aligning")
        rows = in_common_frame(rows)
    args.progress.begin("writing")
    table = coefficient_table(list(shapes), rows, args.modes)
    write_coefficient_table(args.target, table, force=args.force)
    found.add("surfaces", f"{len(shapes)} of {len(names)}", surfaces=list(shapes))
    found.left_out(reasons)
    if table.modes is not None:
        shares = ", ".join(f"{100 * share:.3g}" for share in table.compactness)
        found.add(
            "modes",
            f"hold {shares} percent of the variance",
            variances=table.modes.variances,
            compactness=table.compactness,
        )
    found.add("written", f"{args.target}: degree {args.degree}, a row for each surface")
    status = found.report(args)
    if reasons:
        return Exit.FAILED
    return status
