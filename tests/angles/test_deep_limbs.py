"""The table of a limb: no kappas cost less than those that it chooses, with branches and with gains of no use."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from igl_spheremap.angles.deep_limbs import Costs, Table

KAPPAS = 1 - 0.05 * np.arange(20)
BINS = 3


def costs(seed, *, useful=200):
    """Random costs of three bins, the deepest of which lie up to 10 nepers below the floor."""
    rng = np.random.default_rng(seed)
    angles = np.cumsum(rng.random((BINS, 20)), axis=1) * 300
    return Costs(
        angles - angles[:, :1],
        rng.random(BINS),
        35 + 10 * rng.random(BINS),
        np.full(BINS, useful),
        35.0,
        0.05 * 4,
        200,
    )


def cost(given, choice, gained, branches=(), at=()):
    """The sum that the table minimises, written out for one choice of kappas."""
    total = 0.0
    for b, step in enumerate(choice):
        gained += step
        useful = min(gained, given.useful[b])
        missing = given.deepest[b] - np.log(KAPPAS[step]) - given.step * useful - given.floor
        total += given.angles[b, step] + 300 * given.vertices[b] * max(0.0, missing)
        total += sum(
            branch.least[useful] for branch, where in zip(branches, at, strict=True) if where == b
        )
    return total


@pytest.mark.parametrize(
    ("seed", "useful", "gained"), [(0, 200, 0), (1, 200, 7), (2, 5, 0), (3, 0, 0), (4, 12, 3)]
)
def test_no_kappas_of_three_bins_cost_less_than_those_chosen(seed, useful, gained):
    branches, at = [Table.of(costs(seed + 10)), Table.of(costs(seed + 20))], [2, 0]
    given = costs(seed, useful=useful)
    table = Table.of(given, branches, at)
    least = min(
        cost(given, choice, gained, branches, at) for choice in product(range(20), repeat=BINS)
    )
    kappas, gains = table.chosen(gained)
    steps = np.rint((1 - kappas) / 0.05).astype(int)
    assert table.least[gained] == pytest.approx(least, rel=1e-12)
    assert cost(given, steps.tolist(), gained, branches, at) == pytest.approx(least, rel=1e-12)
    assert gains.tolist() == np.minimum(gained + np.cumsum(steps), useful).tolist()
    assert steps.any() == (useful > 0)


def test_what_lies_above_the_floor_is_not_shortened():
    given = costs(0)._replace(deepest=np.full(BINS, 30.0))
    table = Table.of(given)
    assert table.least[0] == 0
    assert (table.chosen(0)[0] == 1).all()
