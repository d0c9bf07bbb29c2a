"""`igl-spheremap map IN OUT`: map a mesh to the sphere and write the map."""

from __future__ import annotations

from argparse import Namespace

from ....descent.iterate import Listener
from ....maps.balanced import rebalance
from ....maps.sphere_map import SphereMap
from ....maps.spherical_conformal_map import spherical_conformal_map
from ....mesh.arrays import FloatArray, IntArray
from ..chosen import chosen_method
from ..exits import Exit
from ..mapping import map_by


def run(args: Namespace) -> Exit:
    """Map, conformally unless another balance is asked for."""
    method = chosen_method(args)

    def solve(v: FloatArray, f: IntArray, listener: Listener) -> SphereMap:
        result = spherical_conformal_map(v, f, method, listener=listener)
        return rebalance(result, args.balance, listener=listener) if args.balance else result

    return map_by(args, solve)
