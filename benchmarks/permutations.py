"""Findings of `permutation_test` without and with an effect.

    python -m benchmarks permutations [--experiments 1500]
    python -m benchmarks permutations --planted 300

Each experiment draws 20 points in space for each member, covariates, and a variable that is their mean and a draw of
its own, all of one distribution: normal, Student's t with 2 degrees of freedom, or exp(s z), z normal. The last rows
have groups of 2 and 10 members as the variable. Shares of experiments, in percent, with p of .05 or less anywhere: by
residuals, then with augmented models. With --planted the variable moves one point of normal data by twice their
standard deviation for each of its own.
"""

from __future__ import annotations

import numpy as np
from family import group_of

import igl_spheremap as ism

from .common import parser

_POINTS, _PERMUTATIONS = 20, 99
_COVARIATES = (0, 1, 2, 5)
_DRAWS = {
    "normal": lambda rng, size: rng.normal(size=size),
    "t, 2 degrees of freedom": lambda rng, size: rng.standard_t(2, size=size),
    "exp(z)": lambda rng, size: np.exp(rng.normal(size=size)),
    "exp(2 z)": lambda rng, size: np.exp(2 * rng.normal(size=size)),
}


def share(draw, count, covariates, experiments, augment, unequal=False, effect=0.0):
    """Percent of experiments in which something is found, at the moved point if one is; a dash without any test."""
    found = 0
    for k in range(experiments):
        rng = np.random.default_rng([k, count, covariates, unequal])
        z, own = draw(rng, (count, covariates)), draw(rng, count)
        x = rng.permutation(count) < 2 if unequal else own + (z.mean(axis=1) if covariates else 0)
        shapes = draw(rng, (count, _POINTS, 3))
        shapes[:, 0, 0] += effect * x
        try:
            test = ism.shapes.permutation_test(
                group_of(shapes),
                x,
                covariates=z if covariates else None,
                permutations=_PERMUTATIONS,
                augment=augment,
                seed=k,
            )
        except ism.MeshError:
            return "-"
        found += (test.p[0] if effect else test.p.min()) <= 0.05
    return f"{100 * found / experiments:.1f}"


def table(rows, experiments, effect=0.0):
    """A row for each distribution and number of members, columns by covariates, residuals / augmented."""
    print(
        f"| distribution | members | {' | '.join(f'{k} covariates' for k in _COVARIATES)} |\n|---|---|"
        f"{'---|' * len(_COVARIATES)}"
    )
    for name, count, unequal in rows:
        cells = [
            " / ".join(
                share(_DRAWS[name], count, k, experiments, augment, unequal, effect)
                for augment in ((False, True) if k else (False,))
            )
            for k in _COVARIATES
        ]
        print(f"| {name} | {'2 and 10' if unequal else count} | {' | '.join(cells)} |", flush=True)


def main(words):
    options = parser(__doc__)
    options.add_argument("--experiments", type=int, default=1500)
    options.add_argument("--planted", type=int, default=0)
    args = options.parse_args(words)
    if args.planted:
        table([("normal", count, False) for count in (8, 12, 20, 30)], args.planted, effect=2.0)
        return
    table(
        [(name, count, False) for name in _DRAWS for count in (8, 12, 20, 30)]
        + [(name, 12, True) for name in _DRAWS],
        args.experiments,
    )
