"""Readings of Algorithm 1 beside the paper's numbers of iterations, where text and program leave open what was run.

    python -m benchmarks readings readings|surfaces --csv FILE [--meshes CORPUS]

runs Algorithm 1 from the Gauss map of the surfaces of Tables 2 and 3, in all of `WAYS`, and notes in which iteration
each of `quantities` first is below epsilon, for each of `EPSILONS`. FILE keeps these numbers, a row a quantity, blank
if none of 5,000 iterations is; a run that stands there is not made again. The factor of a reading is by how much its
iterations, 5,000 where it does not end, differ from the paper's in the mean, and in brackets in the median, up or down:
exp of the mean of |log(iterations / the paper's)| over the surfaces.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import igl
import numpy as np

import igl_spheremap as ism
from igl_spheremap.apps.reproduce.surfaces import load_surface
from igl_spheremap.apps.reproduce.tables import TABLE_2, TABLE_3

from .common import parser

#: Iterations of Algorithm 1 from the Gauss map, by surface; the paper has no more than 5,000.
PAPER = {row.surface: row.iterations[0] for row in TABLE_2 + TABLE_3}
CAP = 5000
EPSILONS = [f"1e-{k}" for k in range(13)]
#: The paper's.
EPSILON = "1e-10"


@dataclass(frozen=True)
class Way:
    """How iterates are made: the derivative of the energy, inner products, and the search."""

    #: Whether the derivative L F is divided by areas A, eqs. (9) and (13), and inner products are weighed by them, eq.
    #: (12). By the authors' program neither is so.
    divided: bool
    weighed: bool
    #: Area of the surface, None for that of the file. It changes nothing where areas are not used.
    area: float | None
    #: First step, factor by which a refused step is shortened, and number of trials, of which the last is taken.
    first: float
    shorten: float
    trials: int
    #: Which quotient of eq. (12) an odd iteration gives to the next one.
    quotient: int


_PAPER, _PROGRAM = (1.0, 0.1, 40, 1), (1e-3, 0.2, 5, 2)
_AREAS = {"area 1": 1.0, "area 4 pi": 4 * np.pi, "the file's area": None}
WAYS = {
    "H = L F, Frobenius": Way(False, False, 1.0, *_PROGRAM),
    "H = L F, Frobenius, the paper's search": Way(False, False, 1.0, *_PAPER),
    **{f"H = L F / A, L2, {name}": Way(True, True, area, *_PAPER) for name, area in _AREAS.items()},
    **{
        f"H = L F / A, Frobenius, {name}": Way(True, False, area, *_PROGRAM)
        for name, area in _AREAS.items()
    },
}


def course(v: np.ndarray, f: np.ndarray, way: Way) -> np.ndarray:
    """(5001, 4) of the start and each iterate: energy, L2 and Frobenius norm of the gradient, and that of the step."""
    L = -igl.cotmatrix(v, f)
    A = igl.massmatrix(v, f, igl.MASSMATRIX_TYPE_BARYCENTRIC).diagonal()[:, None]
    A *= (way.area or A.sum()) / A.sum()
    divisor, weight = A if way.divided else 1.0, A if way.weighed else 1.0

    def dots(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.einsum("ij,ij->i", a, b)[:, None]

    def tangential(x: np.ndarray, H: np.ndarray) -> np.ndarray:
        return H - dots(x, H) * x

    def noted(energy: float, P: np.ndarray, S: np.ndarray) -> tuple[float, ...]:
        return energy, *map(np.linalg.norm, (P * divisor / np.sqrt(A), P, S))

    x = ism.gauss_map(v, f)
    Lx = L @ x
    energy, H, tau = float((x * Lx).sum() / 2), Lx / divisor, way.first
    P, C, Q = tangential(x, H), energy, 1.0
    rows = [noted(energy, P, x)]
    for k in range(1, CAP + 1):
        slope = -(weight * P * P).sum()
        xH, HH, xx = dots(x, H), dots(H, H), dots(x, x)
        for trial in range(way.trials):
            tau *= way.shorten if trial else 1
            half = tau / 2
            y = (((1 + half * xH) ** 2 - half**2 * xx * HH) * x - tau * xx * H) / (
                1 + half**2 * (xx * HH - xH**2)
            )
            Ly = L @ y
            energy = float((y * Ly).sum() / 2)
            if energy <= C + 1e-4 * tau * slope:
                break
        H = Ly / divisor
        S, Y = y - x, tangential(y, H) - P
        x, P = y, P + Y
        rows.append(noted(energy, P, S))
        C, Q = (0.85 * Q * C + energy) / (0.85 * Q + 1), 0.85 * Q + 1
        SS, SY, YY = (weight * S * S).sum(), abs((weight * S * Y).sum()), (weight * Y * Y).sum()
        tau = way.first
        if SY > 0:
            tau = min(max(SS / SY if k % 2 == way.quotient % 2 else SY / YY, 1e-20), 1e20)
    return np.array(rows)


def quantities(rows: np.ndarray) -> dict[str, np.ndarray]:
    """Quantities that epsilon may bound, by iteration."""
    energy, L2, frobenius, step = rows.T
    step, change = step[1:] / np.sqrt(3), np.abs(np.diff(energy)) / (1 + np.abs(energy[:-1]))
    steps, changes = means(step), means(change)
    last, five = np.where(step < 1e-6, change, np.inf), np.where(steps < 1e-5, changes / 10, np.inf)
    return {
        "L2 norm of the gradient": L2[1:],
        "Frobenius norm of the gradient": frobenius[1:],
        "change of the map": step,
        "change of the energy": change,
        "mean of five changes of the energy": changes,
        _RULE: np.where(frobenius[1:] < 1e-6, 0, np.minimum(last, five)),
    }


#: It ends runs by gradient, map and energy; epsilon stands for its bound of the energy's change, 1e-12.
_RULE = "rule of the program"


def means(values: np.ndarray) -> np.ndarray:
    """The means of the last five, or of all if they are fewer."""
    n = np.arange(1, len(values) + 1)
    return np.convolve(values, np.ones(5))[: len(values)] / np.minimum(n, 5)


Reading = tuple[str, str, str]


def main(argv: list[str]) -> None:
    """Run what FILE lacks, the small surfaces first, and print a table."""
    arguments = parser(__doc__)
    arguments.add_argument("table", choices=("readings", "surfaces"))
    arguments.add_argument("--csv", type=Path, required=True)
    arguments.add_argument(
        "--meshes", type=Path, metavar="CORPUS", help="without it, samples are taken"
    )
    options = arguments.parse_args(argv)
    surfaces = [load_surface(name, options.meshes) for name in PAPER]
    for surface in sorted(surfaces, key=lambda surface: len(surface.v)):
        for name, way in WAYS.items():
            if (surface.name, name) not in {
                (row["surface"], row["way"]) for row in kept(options.csv)
            }:
                keep(options.csv, surface.name, name, quantities(course(surface.v, surface.f, way)))
    found: dict[Reading, dict[str, int]] = {}
    for row in kept(options.csv):
        for epsilon in EPSILONS:
            iterations = int(row[epsilon] or CAP)
            found.setdefault((row["way"], row["quantity"], epsilon), {})[row["surface"]] = (
                iterations
            )
    print_readings(found) if options.table == "readings" else print_surfaces(found)


def kept(file: Path) -> list[dict[str, str]]:
    """The rows of the file."""
    if not file.is_file():
        return []
    with file.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def keep(file: Path, surface: str, way: str, found: dict[str, np.ndarray]) -> None:
    """Append the iterations in which quantities of a run first are below the epsilons."""
    head = ["surface", "way", "quantity", *EPSILONS]
    new = not file.is_file()
    with file.open("a", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerows([head] if new else [])
        for name, values in found.items():
            below = [np.flatnonzero(values <= float(epsilon)) for epsilon in EPSILONS]
            writer.writerow([surface, way, name, *(k[0] + 1 if len(k) else "" for k in below)])


def logs(iterations: dict[str, int]) -> list[float]:
    """|log(iterations / the paper's)| by surface."""
    return [abs(np.log(n / PAPER[name])) for name, n in iterations.items()]


def factor(iterations: dict[str, int]) -> str:
    """By how much iterations differ from the paper's, in the mean and in the median."""
    return f"{np.exp(np.mean(logs(iterations))):.1f} ({np.exp(np.median(logs(iterations))):.1f})"


def nearest(found: dict[Reading, dict[str, int]], quantity: str = "", epsilon: str = "") -> Reading:
    """The reading with the smallest factor, with this quantity and epsilon if given; of equal ones, the strictest."""
    some = [one for one in found if quantity in ("", one[1]) and epsilon in ("", one[2])]
    return min(
        some, key=lambda one: (round(float(np.exp(np.mean(logs(found[one])))), 1), float(one[2]))
    )


def print_readings(found: dict[Reading, dict[str, int]]) -> None:
    """By quantity, the nearest reading with the paper's epsilon, and the nearest with any."""
    print(f"| epsilon bounds | nearest with {EPSILON} | factor | nearest with any | | factor |")
    print("|---|---|---:|---|---|---:|")
    for quantity in dict.fromkeys(quantity for _, quantity, _ in found):
        given, free = nearest(found, quantity, EPSILON), nearest(found, quantity)
        print(
            f"| {quantity} | {given[0]} | {factor(found[given])} | {free[2]} | {free[0]} | {factor(found[free])} |"
        )
    alike = round(float(np.exp(np.median(np.log(list(PAPER.values()))))))
    print(
        f"| nothing: {alike:,} iterations on all | | {factor(dict.fromkeys(PAPER, alike))} | | | |"
    )


def print_surfaces(found: dict[Reading, dict[str, int]]) -> None:
    """By surface, the paper's iterations, those as printed, as programmed, and of the nearest reading."""
    printed = ("H = L F / A, L2, area 1", "L2 norm of the gradient", EPSILON)
    programmed = ("H = L F, Frobenius", _RULE, "1e-12")
    way, quantity, _ = nearest(found, epsilon=EPSILON)
    print(
        f"| surface | the paper | as printed | as programmed | {quantity} with {EPSILON}, {way} |"
    )
    print("|---|---:|---:|---:|---:|")
    columns = [found[one] for one in (printed, programmed, (way, quantity, EPSILON))]
    for name in PAPER:
        print(f"| {name} | {' | '.join(f'{column[name]:,}' for column in (PAPER, *columns))} |")
    print(f"| factor | | {' | '.join(map(factor, columns))} |")
