"""Map a closed genus-0 mesh to the unit sphere and certify the map.

    igl-spheremap map sample:dino dino_sphere.obj
    igl-spheremap map lh.pial lh.sphere.conformal
    igl-spheremap map bunny.ply bunny_map.npz --method lai2014 --json figures.json
    igl-spheremap map bunny.ply bunny_sphere.ply --report bunny_report --plot bunny.svg
    igl-spheremap map scan.stl sphere.ply --repair --keep-largest
    igl-spheremap map bunny.ply bunny_sphere.ply --polish angles
"""

from __future__ import annotations

from argparse import Namespace

from ....maps.balanced import rebalance
from ....maps.spherical_conformal_map import spherical_conformal_map
from ....mesh.arrays import FloatArray, IntArray
from ....result.run import Listener
from ....result.sphere_map import SphereMap
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
