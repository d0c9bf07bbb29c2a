"""`resample` and `transfer`: surfaces and data carried over a map."""

from argparse import Namespace
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array, save_npz

from ....errors import MeshError
from ....io.formats import format_of
from ....io.hemispheres import LEFT, RIGHT, fill_sides
from ....io.records import Label
from ....io.replacing import replacing
from ....io.scalars import write_scalars
from ....mesh.arrays import FloatArray, IntArray
from ....resampling.transfer import transfer, transfer_matrix
from ....resampling.weights import TransferMatrix, apply_matrix, largest
from ..exits import UsageError
from ..inputs import InputMap, load_pair, read_maps, read_table, read_target_sphere
from ..output import Findings, check_outputs, mirrored, write_surface


def run_resample(args: Namespace) -> None:
    check_outputs(args, surface=True)
    pair = load_pair(args, args.reflect)
    source = pair.source
    points, faces = read_target_sphere(args.to, source)
    args.progress.begin(f"resampling {source.name}")
    v = transfer(pair.map(), source.v, points)
    written = write_surface(args, v, faces, source.metadata)
    found = Findings(target=args.target, vertices=len(v), faces=len(faces))
    found.mesh("source", source)
    found.add(
        "sphere",
        f"{pair.name}{mirrored(args)}, resampled at the vertices of {args.to}",
        sphere=pair.name,
        to=args.to,
        reflect=args.reflect,
    )
    found.add("written", written)
    found.report(args)


@dataclass(frozen=True, eq=False)
class _Side:
    """Data carried over the map of one surface."""

    pair: InputMap
    to: str
    there: tuple[FloatArray, IntArray]
    weights: TransferMatrix
    before: dict[str, FloatArray]
    after: dict[str, FloatArray]
    table: tuple[Label, ...] | None
    labels: bool


def run_transfer(args: Namespace) -> None:
    check_outputs(args)
    if args.matrix is not None and not args.matrix.lower().endswith(".npz"):
        raise UsageError(f"--matrix {args.matrix}: SciPy keeps sparse matrices in .npz files")
    kind = format_of(args.target, data=True)
    if fill_sides(args.source, LEFT) == args.source:
        sides = [_carried(args)]
    else:
        if not kind.sides or args.matrix is not None:
            raise UsageError(
                "data of both sides go to one CIFTI file: give .dscalar.nii or .dlabel.nii, no --matrix"
            )
        sides = [_carried(_of_side(args, structure)) for structure in (LEFT, RIGHT)]
    first, *others = sides
    metadata = dict(first.pair.source.metadata)
    if others:
        metadata |= {"structure": LEFT, "others": {RIGHT: others[0].after}}
    if first.labels:
        metadata["labels"] = ()
        if first.table:
            metadata["labels"] = first.table
    after = first.after
    if first.labels and not kind.sides:
        after = {key: np.nan_to_num(values) for key, values in after.items()}
    write_scalars(args.target, after, surface=first.there, force=args.force, metadata=metadata)
    if args.matrix is not None:
        matrix = first.weights.matrix
        if first.labels:
            matrix = largest(matrix)
        with replacing(args.matrix, args.force) as partial:
            save_npz(partial, csr_array(matrix.T))
    found = Findings(target=args.target, vertices=len(first.there[0]), matrix=args.matrix, maps={})
    for side in sides:
        _describe(args, found, side)
    if args.matrix is not None:
        found.add(
            "matrix", f"{args.matrix}: sources by targets, values @ matrix, as in nitransforms"
        )
    found.report(args)


def _of_side(args: Namespace, structure: str) -> Namespace:
    """The arguments with {hemi} and {side} filled in."""
    words = {
        name: fill_sides(value, structure)
        for name in ("source", "sphere", "data", "to")
        if (value := getattr(args, name)) is not None
    }
    return Namespace(**{**vars(args), **words})


def _carried(args: Namespace) -> _Side:
    """The data of a surface, and their values at --to; without data, none."""
    pair = load_pair(args, args.reflect)
    there = read_target_sphere(args.to, pair.source)
    given = pair.source
    if args.reflect:
        given = given.mirrored()  # as the file has it
    before, table = read_maps(args.data, given), read_table(args.data)
    for key, values in before.items():
        if np.isnan(values).all():
            raise MeshError(f"{args.data}: {key} has no data at all; give a map that has some")
    labels = args.labels or table is not None
    result = pair.map()
    args.progress.begin(f"locating {len(there[0])} points on {pair.name}")
    weights = transfer_matrix(result, there, method=args.method)
    after = {key: carry(weights.matrix, values, labels) for key, values in before.items()}
    return _Side(pair, args.to, there, weights, before, after, table, labels)


def carry(matrix: csr_array, values: FloatArray, labels: bool) -> FloatArray:
    """Apply a matrix to one map; NaN, for no data, has no weight; if the largest weight is its own, it stays.

    >>> carry(csr_array([[0.75, 0.25], [0.25, 0.75]]), np.array([3.0, np.nan]), False)
    array([ 3., nan])
    """
    known = ~np.isnan(values)
    carried: FloatArray = apply_matrix(matrix, values, labels)
    if labels or known.all():
        return carried
    sums, shares = matrix @ np.where(known, values, 0.0), matrix @ known
    stays = apply_matrix(matrix, known, labels=True)
    return np.divide(sums, shares, out=np.full(len(sums), np.nan), where=stays)


def _describe(args: Namespace, found: Findings, side: _Side) -> None:
    """Names, sources and ranges of carried data, and the change of their integrals."""
    weights = side.weights
    found.mesh("source", side.pair.source)
    found.add(
        "sphere",
        f"{side.pair.name}{mirrored(args)}, at the {len(side.there[0])} vertices of {side.to}",
        sphere=side.pair.name,
        to=side.to,
        reflect=args.reflect,
    )
    for key, values in side.after.items():
        known = values[~np.isnan(values)]
        low, high = found.figures["maps"][key] = float(known.min()), float(known.max())
        text = f"{args.target}: {key}, "
        if side.labels:
            text += f"{len(np.unique(known))} labels, "
        text += f"{low:.4g} to {high:.4g}"
        if len(known) < len(values):
            text += f"; {len(values) - len(known)} vertices without data"
        found.add("written", text)
        areas, received, own_areas = weights.areas, weights.received, weights.source_areas
        whole = len(known) == len(values) and not side.labels
        if whole and received is not None and areas is not None and own_areas is not None:
            before, kept, own = own_areas @ side.before[key], received @ values, areas @ values
            found.add(
                "integral",
                f"{key}: {before:.6g}, kept to {abs(kept - before):.2g} by the areas that came to "
                f"each vertex; {own:.6g} by those of the surface resampled on {side.to}",
            )
            found.figures.setdefault("integrals", {})[key] = {
                "source": before,
                "received": kept,
                "target": own,
            }
