"""`igl-spheremap map IN OUT`: map a mesh to the sphere and write the map."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from dataclasses import fields
from typing import Any, get_args

from ....descent.iterate import Listener
from ....maps.balanced import rebalance
from ....maps.options import METHODS, EdgeWeights, Gauge, Polish
from ....maps.sphere_map import SphereMap
from ....maps.spherical_conformal_map import spherical_conformal_map
from ....mesh.arrays import FloatArray, IntArray
from ..exits import Exit
from ..failures import UsageError
from ..mapping import add_balance, add_map_arguments, map_by


def configure(parser: ArgumentParser) -> None:
    """Add the arguments."""
    add_map_arguments(parser)
    parser.add_argument(
        "--method", choices=tuple(METHODS), default="auto", help="default: auto, the fast pipeline"
    )
    parser.add_argument(
        "--polish",
        choices=get_args(Polish),
        help="lower the angle differences, or their largest ones, when the map is done (auto)",
    )
    parser.add_argument(
        "--gauge",
        choices=get_args(Gauge),
        help="poles: the two deepest tips at the poles, for bodies beyond float64 (auto); default: centred",
    )
    parser.add_argument(
        "--weights",
        choices=get_args(EdgeWeights),
        help="of the edges: the paper's, or those of intrinsic Delaunay triangles, never negative (lai2014)",
    )
    parser.add_argument(
        "--atlas", action="store_true", default=None,
        help="write charts of the plane beside the map, where limbs beyond float64 keep their angles (auto; .npz)",
    )
    add_balance(parser)


def run(args: Namespace) -> Exit:
    """Map, conformally unless another balance is asked for."""
    names = ("polish", "gauge", "weights", "atlas")
    chosen = {name: getattr(args, name) for name in names if getattr(args, name) is not None}
    if unknown := set(chosen) - {option.name for option in fields(METHODS[args.method])}:
        raise UsageError(f"--method {args.method} takes no --{' and no --'.join(sorted(unknown))}")

    def solve(v: FloatArray, f: IntArray, listener: Listener, **limits: Any) -> SphereMap:
        result = spherical_conformal_map(v, f, METHODS[args.method](**chosen, **limits), listener=listener)
        return rebalance(result, args.balance, listener=listener) if args.balance else result

    return map_by(args, solve)
