"""Map by the p-harmonic energy, which gives limbs more room for p above 2.

    igl-spheremap p-harmonic sample:dino dino_sphere.obj -p 4
"""

from __future__ import annotations

from argparse import Namespace

from ....maps.p_harmonic import p_harmonic_map
from ..chosen import given
from ..exits import Exit
from ..mapping import map_by


def run(args: Namespace) -> Exit:
    """Map p-harmonically."""
    options = given(args, "tolerance", "max_iterations") | {"keep_injective": not args.may_fold}
    return map_by(args, lambda v, f, listener: p_harmonic_map(v, f, args.p, listener=listener, **options))
