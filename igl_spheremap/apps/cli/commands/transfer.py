"""`resample` and `transfer`: surfaces and data carried over a map."""

from argparse import Namespace

import numpy as np
from scipy.sparse import csr_array, save_npz

from ....io.formats import format_of
from ....io.replacing import replacing
from ....io.scalars import write_scalars
from ....io.write_mesh import write_mesh
from ....resampling.transfer import transfer, transfer_matrix
from ....resampling.weights import apply_matrix, largest
from ..exits import UsageError
from ..inputs import load_pair, read_maps, read_table, read_target_sphere
from ..output import Findings, check_outputs, mirrored, target_format, write_target


def run_resample(args: Namespace) -> None:
    check_outputs(args, surface=True)
    pair = load_pair(args, args.reflect)
    source = pair.source
    points, faces = read_target_sphere(args.to, source)
    args.progress.begin(f"resampling {source.name}")
    v = transfer(pair.map(), source.v, points)
    write_target(
        args, lambda path: write_mesh(path, v, faces, force=args.force, metadata=source.metadata)
    )
    found = Findings(target=args.target, vertices=len(v), faces=len(faces))
    found.mesh("source", source)
    found.add(
        "sphere",
        f"{pair.name}{mirrored(args)}, resampled at the vertices of {args.to}",
        sphere=pair.name,
        to=args.to,
        reflect=args.reflect,
    )
    found.add(
        "written",
        f"{args.target} ({target_format(args).name}): {len(v)} vertices, {len(faces)} faces",
    )
    found.report(args)


def run_transfer(args: Namespace) -> None:
    check_outputs(args)
    if args.matrix is not None and not args.matrix.lower().endswith(".npz"):
        raise UsageError(f"--matrix {args.matrix}: SciPy keeps sparse matrices in .npz files")
    format_of(args.target, data=True)
    pair = load_pair(args, args.reflect)
    source = pair.source
    there = read_target_sphere(args.to, source)
    maps, table = read_maps(args.data, source), read_table(args.data)
    labels, metadata = args.labels or table is not None, dict(source.metadata)
    if labels:
        metadata["labels"] = table or ()
    result = pair.map()
    args.progress.begin(f"locating {len(there[0])} points on {pair.name}")
    weights = transfer_matrix(result, there, method=args.method)
    matrix, received, areas, own_areas = (
        weights.matrix,
        weights.received,
        weights.areas,
        weights.source_areas,
    )
    carried = {key: apply_matrix(matrix, values, labels) for key, values in maps.items()}
    write_scalars(args.target, carried, surface=there, force=args.force, metadata=metadata)
    if args.matrix is not None:
        with replacing(args.matrix, args.force) as partial:
            save_npz(partial, csr_array((largest(matrix) if labels else matrix).T))
    found = Findings(target=args.target, vertices=len(there[0]), matrix=args.matrix, maps={})
    found.mesh("source", source)
    found.add(
        "sphere",
        f"{pair.name}{mirrored(args)}, at the {len(there[0])} vertices of {args.to}",
        sphere=pair.name,
        to=args.to,
        reflect=args.reflect,
    )
    for key, values in carried.items():
        low, high = found.figures["maps"][key] = float(values.min()), float(values.max())
        kind = f"{len(np.unique(values))} labels, " if labels else ""
        found.add("written", f"{args.target}: {key}, {kind}{low:.4g} to {high:.4g}")
        if received is not None and areas is not None and own_areas is not None and not labels:
            before, kept, own = own_areas @ maps[key], received @ values, areas @ values
            found.add(
                "integral",
                f"{key}: {before:.6g}, kept to {abs(kept - before):.2g} by the areas that came to "
                f"each vertex; {own:.6g} by those of the surface resampled on {args.to}",
            )
            found.figures.setdefault("integrals", {})[key] = {
                "source": before,
                "received": kept,
                "target": own,
            }
    if args.matrix is not None:
        found.add(
            "matrix", f"{args.matrix}: sources by targets, values @ matrix, as in nitransforms"
        )
    found.report(args)
