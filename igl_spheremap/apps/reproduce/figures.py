"""Figs. 3, 4, 5, 6, 9 and 10: surfaces, their maps, energies and angle differences."""

from __future__ import annotations

from itertools import count
from typing import Any

import numpy as np

from ... import samples
from ...draw.palette import GUIDE, LINES
from ...draw.plot import new_figure, plot_angles
from ...mesh.arrays import FloatArray
from ...start.star_map import weighted_eigen_projection
from ...verify.distortion import angle_differences, conformal_factor
from ...verify.signs import folded_faces
from .canvas import folded_patches, show_fold, show_function, show_map, show_shape, show_source
from .runs import Outcome, Runs, Surface
from .tables import TABLE_1

_FIG_10 = ("Dino", "Armadillo", "Bird 1", "Dilo")
_REACH = 45.0  # degrees at the end of histograms that are compared
#: Radius of the sphere that normalised eigenfunctions make: |phi|^2 = 3 / (4 pi).
_PHI_RADIUS = np.sqrt(3 / (4 * np.pi))


def figure_3(runs: Runs) -> Any:
    """Surfaces, their harmonic maps, and u on the surfaces."""
    figure, axes = new_figure(3, len(TABLE_1), "Fig. 3. Surfaces, maps by Algorithm 1, and u of $e^{2u}$ on them")
    for column, row in zip(axes.T, TABLE_1, strict=True):
        surface = runs.surface(row.surface)
        outcome = runs.get(surface, "Algorithm 1")
        show_source(column[0], surface, title=f"{row.surface}: {surface.source}")
        show_map(column[1], surface, outcome.sphere, title=f"{outcome.foldings} foldings")
        show_function(column[2], surface, _u(surface, outcome.sphere), title="u")
    return figure


def figure_4(runs: Runs) -> Any:
    """Harmonic energy by iteration, and histograms of angle differences."""
    figure, axes = new_figure(2, len(TABLE_1), "Fig. 4. Algorithm 1: energy (6) by iteration, and angle differences")
    for (energy, angles), row in zip(axes.T, TABLE_1, strict=True):
        surface = runs.surface(row.surface)
        outcome = runs.get(surface, "Algorithm 1")
        energy.loglog(1 + np.arange(len(outcome.energies)), outcome.energies, color=LINES[0])
        energy.axhline(4 * np.pi, color=GUIDE, linestyle=":", linewidth=1)
        energy.set(xlabel="iteration + 1", ylabel="energy (dotted: 4π)")
        energy.set_title(f"{row.surface}: {surface.source}", fontsize=8)
        _angles(angles, surface, outcome)
    return figure


def figure_5(runs: Runs) -> Any:
    """The faces of a dinosaur that Algorithm 1 folds."""
    dinosaurs = _dinosaurs(runs)
    figure, axes = new_figure(len(dinosaurs), 4, "Fig. 5. Foldings of Algorithm 1 from the Gauss map")
    for line, surface in zip(axes, dinosaurs, strict=True):
        outcome = runs.get(surface, "Algorithm 1")
        x, faces = outcome.sphere, len(surface.f)
        show_source(line[0], surface, x, title=f"{surface.source}: folded faces")
        show_map(line[1], surface, x, title=f"{outcome.foldings} of {faces} faces folded")
        patches = folded_patches(surface, x)
        for ax, patch in zip(line[2:], patches, strict=False):
            show_fold(ax, surface, x, patch)
        for ax in line[2 + len(patches) :]:
            ax.axis("off")
    return figure


def figure_6(runs: Runs) -> Any:
    """The first three nontrivial eigenfunctions of the sphere, and the surface that they make; needs no run."""
    v, f = samples.make("sphere", n_vertices=10_242)
    surface = Surface("Sphere", v, f, "sample:sphere", "the same")
    projection = weighted_eigen_projection(v, f, v)
    figure, axes = new_figure(1, 4, "Fig. 6. Laplace-Beltrami eigenfunctions of the sphere, and their surface")
    for k in range(3):
        title = f"eigenvalue {projection.eigenvalues[k]:.4f}, function"
        show_function(axes[0][k], surface, projection.phi[:, k], title=title)
    show_shape(axes[0][3], surface, projection.phi, title=_roundness(projection.phi))
    return figure


def figure_9(runs: Runs) -> Any:
    """Folded faces, map, u, and surface of the weighted eigenfunctions before and after each folding removal."""
    dinosaurs = _dinosaurs(runs)
    outcomes = [runs.get(surface, "Algorithm 2") for surface in dinosaurs]
    rows = max(len(outcome.maps) for outcome in outcomes)
    figure, axes = new_figure(rows, 4 * len(dinosaurs), "Fig. 9. Algorithm 2: folded faces, map, u, surface of $Φ^u$")
    for ax in axes.ravel():
        ax.axis("off")
    for k, (surface, outcome) in enumerate(zip(dinosaurs, outcomes, strict=True)):
        for line, x, step in zip(axes[:, 4 * k : 4 * k + 4], outcome.maps, count(), strict=False):
            _removal(line, surface, x, step)
    return figure


def _removal(line: Any, surface: Surface, x: FloatArray, step: int) -> None:
    """One row of Fig. 9: the state after a step of Algorithm 2."""
    folded = int(folded_faces(x, surface.f).sum())
    show_source(line[0], surface, x, title=f"{f'removal {step}' if step else surface.source}: {folded} foldings")
    show_map(line[1], surface, x, title=f"map: {folded} foldings")
    show_function(line[2], surface, _u(surface, x), title="u")
    projection = weighted_eigen_projection(surface.v, surface.f, x)
    values = ", ".join(f"{value:.3f}" for value in projection.eigenvalues)
    show_shape(line[3], surface, projection.phi, title=f"eigenvalues {values}\n{_roundness(projection.phi)}")


def figure_10(runs: Runs) -> Any:
    """The algorithm of Gu and Yau and Algorithm 2 on surfaces with long, sharp features."""
    figure, axes = new_figure(len(_FIG_10), 5, "Fig. 10. Surfaces; Gu-Yau; Algorithm 2 (vermilion: folded)")
    for line, name in zip(axes, _FIG_10, strict=True):
        surface = runs.surface(name)
        show_source(line[0], surface, title=f"{name}: {surface.source}")
        for panel, method in ((1, "Gu-Yau"), (3, "Algorithm 2")):
            outcome = runs.get(surface, method)
            verdict = f"{method}: {outcome.foldings} foldings, mean {outcome.mean_angle(surface):.2f} degrees"
            show_map(line[panel], surface, outcome.sphere, title=verdict)
            _angles(line[panel + 1], surface, outcome)
    return figure


#: The figures by the names of their files.
FIGURES = {
    "fig3": figure_3,
    "fig4": figure_4,
    "fig5": figure_5,
    "fig6": figure_6,
    "fig9": figure_9,
    "fig10": figure_10,
}


def _angles(ax: Any, surface: Surface, outcome: Outcome) -> None:
    """Histogram of the angle differences of a run's result, on one scale in all figures."""
    if outcome.foldings < 0:
        ax.set_title("no map", fontsize=8)
    else:
        plot_angles(ax, angle_differences(surface.v, surface.f, outcome.sphere), _REACH)


def _dinosaurs(runs: Runs) -> list[Surface]:
    """The folder's dinosaur, if there is one, and the sample: meshes of different quality behave differently."""
    found = [runs.surface("Dino"), runs.surface("Dino", sample=True)]
    return found[found[0].source == found[1].source :]


def _u(surface: Surface, x: FloatArray) -> FloatArray:
    """u of the conformal factor e^{2u}, eq. (14)."""
    factor = conformal_factor(surface.v, surface.f, x)
    return np.asarray(0.5 * np.log(np.maximum(factor, 1e-30)))


def _roundness(phi: FloatArray) -> str:
    """How far the surface of the eigenfunctions is from the sphere of Theorem 2."""
    radius = np.linalg.norm(phi, axis=1) / _PHI_RADIUS
    return f"|Φ| / √(3/4π) from {radius.min():.3f} to {radius.max():.3f}"
