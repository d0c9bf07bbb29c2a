"""Convergence of Algorithm 1, of Gu and Yau's descent and of the fast method, in one plot.

    python -m benchmarks convergence [--mesh sample:brain]

writes docs/images/convergence.png: energy gap against iterations and against CPU
seconds, each method counted from the arrays on. The gap is the energy above the limit of the method itself, run on to
rounding (of the fast method's, for the descent, which does not get near), in units of the mesh's own discretisation
error, energy minus image area: below 1e-3 of it nothing that can be seen of the map changes.
"""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

import igl_spheremap as ism
from igl_spheremap.maps.options import Method
from igl_spheremap.mesh.measure import surface_area

from .common import IMAGES, load, parser, pyplot

#: What is run: label and method.
RUNS = {
    "Gu and Yau's descent, Gauss map": ism.GuYau(tutte=False, plateau=0.0, max_iterations=4000),
    "Algorithm 1, Gauss map": ism.Lai2014(
        rounds=0, plateau=0.0, gradient_tolerance=1e-6, max_iterations=4000
    ),
    "fast method, punctured start": ism.Auto(tolerance=1e-10),
}


def course(
    v: np.ndarray, f: np.ndarray, method: Method
) -> tuple[np.ndarray, np.ndarray, ism.SphereMap]:
    """CPU seconds and energy at every iterate, and the result."""
    seen: list[tuple[float, float]] = []
    began = time.process_time()

    def listen(iterate: ism.Iterate) -> None:
        # it is iterate 0 of the stage that follows
        if iterate.stage not in ("gauss map", "repair"):
            seen.append((time.process_time() - began, iterate.energy))

    result = ism.spherical_conformal_map(v, f, method=method, listener=listen)
    seconds, energies = np.array(seen).T
    return seconds, energies, result


def main(argv: list[str]) -> None:
    """Run the three, after a first map that loads what they import, print what they reached, and draw."""
    arguments = parser(__doc__)
    arguments.add_argument("--mesh", default="sample:brain", help="file, or sample:SPEC")
    arguments.add_argument("--image", type=Path, default=IMAGES / "convergence.png")
    options = arguments.parse_args(argv)
    v, f = load(options.mesh)
    for method in RUNS.values():
        ism.spherical_conformal_map(*ism.samples.make("sphere"), method=method)
    figure, axes = pyplot().subplots(1, 2, figsize=(10, 4), sharey=True, layout="constrained")
    courses = {label: course(v, f, method) for label, method in RUNS.items()}
    descent, *_, fastest = RUNS
    fast = courses[fastest]
    error = fast[1][-1] - surface_area(fast[2].sphere, f)
    for label, (seconds, energies, result) in courses.items():
        limit = fast[1][-1] if label == descent else energies.min()
        gap = np.maximum((energies - limit) / error, 1e-12)
        print(
            f"{label}: {len(energies) - 1} iterations, {seconds[-1]:.2f} s, energy {energies[-1]:.9f}, "
            f"{result.certificate.foldings} foldings; gap below 1, 0.01, 0.001 after "
            + ", ".join(reached(gap, seconds, level) for level in (1, 1e-2, 1e-3))
        )
        axes[0].loglog(np.arange(len(gap)) + 1, gap, ".-", label=label, markersize=4, linewidth=1)
        axes[1].loglog(seconds, gap, ".-", label=label, markersize=4, linewidth=1)
    axes[0].set(
        xlabel="iterations + 1", ylabel="energy gap / discretisation error", ylim=(1e-6, None)
    )
    axes[1].set(xlabel="CPU seconds from arrays on")
    axes[0].legend(fontsize=8)
    for panel in axes:
        panel.axhline(1e-3, color="0.6", linewidth=0.8, linestyle="--")
    figure.suptitle(f"{options.mesh.split('/')[-1]}, {len(v):,} vertices")
    figure.savefig(options.image, dpi=130)


def reached(gap: np.ndarray, seconds: np.ndarray, level: float) -> str:
    """Iterations and seconds after which the gap stays below a level."""
    above = np.flatnonzero(gap > level)
    k = above[-1] + 1 if len(above) else 0
    return f"{k} ({seconds[k]:.2f} s)" if k < len(gap) else "never"
