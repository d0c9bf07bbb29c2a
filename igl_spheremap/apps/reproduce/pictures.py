"""Figs. 3, 5, 6, 9 and 10: surfaces and their maps."""

from __future__ import annotations

from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import samples
from ...start.star_map import weighted_eigen_projection
from ...verify.certificate import orientation_signs
from ...verify.distortion import conformal_factor
from .canvas import folded_patches, new_figure, show_fold, show_function, show_source, show_sphere
from .curves import histogram
from .measures import mean_angle
from .paper import TABLE_1
from .runs import Outcome, Runs
from .surfaces import Surface, load_surface

FloatArray = NDArray[np.float64]

_FIG_10 = ("Dino", "Armadillo", "Bird 1", "Dilo")
#: Radius of the sphere that normalised eigenfunctions make: |phi|^2 = 3 / (4 pi).
_PHI_RADIUS = np.sqrt(3 / (4 * np.pi))


def figure_3(runs: Runs, folder: Path | None) -> Any:
    """Fig. 3: surfaces, their harmonic maps, and u on the surfaces.

    Parameters
    ----------
    runs : Runs
        Computes or recalls.
    folder : Path, optional
        Folder of meshes.

    Returns
    -------
    matplotlib.figure.Figure
        Not shown.
    """
    figure, axes = new_figure(3, len(TABLE_1), "Fig. 3. Surfaces, harmonic maps by Algorithm 1, and u of e^2u on them")
    for column, row in enumerate(TABLE_1):
        surface = load_surface(row.surface, folder)
        outcome = runs.get(surface, "Algorithm 1")
        show_source(axes[0][column], surface)
        axes[0][column].set_title(f"{row.surface}: {surface.source}", fontsize=8)
        show_sphere(axes[1][column], surface, outcome.sphere)
        axes[1][column].set_title(f"{outcome.foldings} foldings", fontsize=8)
        show_function(axes[2][column], surface, _u(surface, outcome.sphere))
    return figure


def figure_5(runs: Runs, folder: Path | None) -> Any:
    """Fig. 5: what Algorithm 1 folds of a dinosaur.

    Parameters
    ----------
    runs : Runs
        Computes or recalls.
    folder : Path, optional
        Folder of meshes.

    Returns
    -------
    matplotlib.figure.Figure
        Not shown.
    """
    dinosaurs = _dinosaurs(folder)
    figure, axes = new_figure(len(dinosaurs), 4, "Fig. 5. Foldings of Algorithm 1 from the Gauss map")
    for line, surface in zip(axes, dinosaurs, strict=True):
        outcome = runs.get(surface, "Algorithm 1")
        show_source(line[0], surface, outcome.sphere)
        line[0].set_title(f"{surface.source}: folded faces", fontsize=8)
        show_sphere(line[1], surface, outcome.sphere)
        line[1].set_title(f"{outcome.foldings} of {len(surface.f)} faces folded", fontsize=8)
        patches = folded_patches(surface, outcome.sphere)
        for ax, patch in zip(line[2:], patches, strict=False):
            show_fold(ax, surface, outcome.sphere, patch)
        for ax in line[2 + len(patches) :]:
            ax.axis("off")
    return figure


def figure_6(runs: Runs, folder: Path | None) -> Any:
    """Fig. 6: the first three nontrivial eigenfunctions of the sphere, and the surface that they make.

    Parameters
    ----------
    runs : Runs
        Not used: the sphere needs no run.
    folder : Path, optional
        Not used: the package makes spheres itself.

    Returns
    -------
    matplotlib.figure.Figure
        Not shown.
    """
    v, f = samples.make("sphere", n_vertices=10_242)
    surface = Surface("Sphere", v, f, "sample:sphere", "the same")
    projection = weighted_eigen_projection(v, f, v)
    figure, axes = new_figure(1, 4, "Fig. 6. Laplace-Beltrami eigenfunctions of the sphere, and their surface")
    for k in range(3):
        show_function(axes[0][k], surface, projection.phi[:, k])
        axes[0][k].set_title(f"eigenvalue {projection.eigenvalues[k]:.4f}", fontsize=8)
    show_sphere(axes[0][3], surface, projection.phi)
    axes[0][3].set_title(_roundness(projection.phi), fontsize=8)
    return figure


def figure_9(runs: Runs, folder: Path | None) -> Any:
    """Fig. 9: map, u, and the surface of the weighted eigenfunctions before and after each folding removal.

    Parameters
    ----------
    runs : Runs
        Computes or recalls.
    folder : Path, optional
        Folder of meshes.

    Returns
    -------
    matplotlib.figure.Figure
        Not shown.
    """
    dinosaurs = _dinosaurs(folder)
    outcomes = [runs.get(surface, "Algorithm 2") for surface in dinosaurs]
    rows = max(len(outcome.maps) for outcome in outcomes)
    figure, axes = new_figure(rows, 3 * len(dinosaurs), "Fig. 9. Algorithm 2: map, u, and surface of Phi^u")
    for ax in axes.ravel():
        ax.axis("off")
    for k, (surface, outcome) in enumerate(zip(dinosaurs, outcomes, strict=True)):
        for line, x, step in zip(axes[:, 3 * k : 3 * k + 3], outcome.maps, count(), strict=False):
            _removal(line, surface, x, step)
    return figure


def _removal(line: Any, surface: Surface, x: FloatArray, step: int) -> None:
    """Map, u and surface of Phi^u after a step of Algorithm 2."""
    folded = int((orientation_signs(x, surface.f) <= 0).sum())
    show_sphere(line[0], surface, x)
    line[0].set_title(f"{f'removal {step}' if step else surface.source}: {folded} foldings", fontsize=8)
    show_function(line[1], surface, _u(surface, x))
    projection = weighted_eigen_projection(surface.v, surface.f, x)
    show_sphere(line[2], surface, projection.phi)
    values = ", ".join(f"{value:.3f}" for value in projection.eigenvalues)
    line[2].set_title(f"eigenvalues {values}\n{_roundness(projection.phi)}", fontsize=8)


def _dinosaurs(folder: Path | None) -> list[Surface]:
    """The folder's dinosaur, if there is one, and the sample: meshes of different quality behave differently."""
    found = [load_surface("Dino", folder), load_surface("Dino", None)]
    return found[found[0].source == found[1].source :]


def figure_10(runs: Runs, folder: Path | None) -> Any:
    """Fig. 10: the algorithm of Gu and Yau and Algorithm 2 on surfaces with long, sharp features.

    Parameters
    ----------
    runs : Runs
        Computes or recalls.
    folder : Path, optional
        Folder of meshes.

    Returns
    -------
    matplotlib.figure.Figure
        Not shown.
    """
    figure, axes = new_figure(len(_FIG_10), 5, "Fig. 10. Surfaces; Gu-Yau; Algorithm 2 (vermilion: folded)")
    for line, name in zip(axes, _FIG_10, strict=True):
        surface = load_surface(name, folder)
        show_source(line[0], surface)
        line[0].set_title(f"{name}: {surface.source}", fontsize=8)
        for panel, method in ((1, "Gu-Yau"), (3, "Algorithm 2")):
            outcome = runs.get(surface, method)
            show_sphere(line[panel], surface, outcome.sphere)
            line[panel].set_title(_verdict(surface, method, outcome), fontsize=8)
            histogram(line[panel + 1], surface, outcome)
    return figure


def _u(surface: Surface, x: FloatArray) -> FloatArray:
    """u of the conformal factor e^{2u}, eq. (14)."""
    factor = conformal_factor(surface.v, surface.f, x)
    return np.asarray(0.5 * np.log(np.maximum(factor, 1e-30)))


def _roundness(phi: FloatArray) -> str:
    """How far the surface of the eigenfunctions is from the sphere of Theorem 2."""
    radius = np.linalg.norm(phi, axis=1) / _PHI_RADIUS
    return f"|Phi| / sqrt(3 / (4 pi)) from {radius.min():.3f} to {radius.max():.3f}"


def _verdict(surface: Surface, method: str, outcome: Outcome) -> str:
    return f"{method}: {outcome.foldings} foldings, mean {mean_angle(surface, outcome):.2f} degrees"
