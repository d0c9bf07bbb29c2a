"""The paper's figures, of the surfaces that stand for its own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import igl
import numpy as np

from ... import samples
from ...draw.folds import Clusters
from ...draw.lens import follow
from ...draw.palette import CHECKS, FACTORS, FOLDED, GUIDE, INK, LINES, diverging, fitting, round_up
from ...draw.plot import pose
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray
from ...paper.star_map import weighted_eigen_projection
from ...result.run import Stage
from ...sphere.cayley import cayley_step
from ...sphere.rows import unit_rows
from ...verify.distortion import conformal_factor
from ...verify.signs import folded_faces
from .canvas import (
    TEXT,
    caption,
    page_figure,
    show_angles,
    show_function,
    show_image,
    show_source,
    show_surface,
)
from .runs import Runs
from .surfaces import PaperSurface
from .tables import TABLE_1, TABLE_2, TABLE_3, WAYS

FIG_10 = ("Dino", "Armadillo", "Bird 1", "Dilo")
#: Settings of the paper's algorithms, of `WAYS`.
SETTINGS = ("lai2014", "as printed", "as programmed")
#: Radius of the sphere that normalised eigenfunctions make: |phi|^2 = 3 / (4 pi).
_PHI_RADIUS = np.sqrt(3 / (4 * np.pi))
#: u of a surface of unit area, less u of the surface scaled to the area of the sphere.
_UNIT = 0.5 * np.log(4 * np.pi)


def figure_1(runs: Runs, squares: int = 3, divided: int = 2) -> Any:
    """A brain and its conformal map under one checkerboard, whose squares keep their right angles.

    The arguments are the squares of a quarter turn, and the divisions of faces for smooth borders.
    """
    surface = runs.surface("Brain")
    result = runs.get(surface, "auto").result
    mean = np.abs(result.angle_differences()).mean()
    title = f"Fig. 1. A brain and its conformal map: mean angle difference {mean:.2f}°"
    figure, ((source, sphere),) = page_figure(1, 2, title, 3.6)
    v, f = igl.upsample(surface.v, surface.f, divided)
    x = unit_rows(igl.upsample(result.sphere, surface.f, divided)[0])
    longitude, latitude = np.arctan2(*x[f].mean(axis=1).T[:2]), np.arcsin(x[f, 2].mean(axis=1))
    odd = (
        sum(
            np.floor(angle / (np.pi / 2 / squares)).astype(np.int64)
            for angle in (longitude, latitude)
        )
        % 2
    )
    for ax, where, words in (
        (source, v, named(surface)),
        (sphere, x, "the same squares on the unit sphere"),
    ):
        show_surface(
            ax,
            PaperSurface("", v, f, "", "", surface.up),
            where,
            words,
            colours=np.array(CHECKS)[odd],
        )
    return figure


def figure_2(runs: Runs) -> Any:
    """The path of Theorem 1 beside the straight step, in the plane of F and A F at one vertex; needs no run."""
    figure, ((ax,),) = page_figure(1, 1, "Fig. 2. The path of Theorem 1 and the straight step", 5)
    F, AF = np.array([[0.0, 1.0, 0.0]]), np.array([[-1.0, 0.0, 0.0]])
    turn = np.linspace(0, 2 * np.pi, 200)
    ax.plot(np.cos(turn), np.sin(turn), color=GUIDE, label="unit sphere, in the plane of F and AF")
    path = np.array([cayley_step(F, AF, tau)[0] for tau in np.linspace(0, 1.5, 60)])
    ax.plot(path[:, 0], path[:, 1], color=LINES[0], linewidth=3, label="Y: on it, for every step")
    ax.plot(
        [0, 1.5], [1, 1], color=FOLDED, linewidth=2, label="straight: off the sphere, infeasible"
    )
    for tau in (0.5, 1.0, 1.5):
        straight, curved = (F - tau * AF)[0], cayley_step(F, AF, tau)[0]
        ax.plot([straight[0], curved[0]], [straight[1], curved[1]], color=GUIDE, linestyle=":")
        ax.plot(*straight[:2], "o", color=FOLDED)
        ax.plot(*curved[:2], "o", color=LINES[0])
        ax.annotate(
            f"F - {tau:g} AF", straight[:2], (0, 8), textcoords="offset points", ha="center"
        )
        ax.annotate(f"Y[{tau:g}]", curved[:2], (-10, -14), textcoords="offset points", ha="right")
    ax.plot(0, 1, "o", color=INK)
    ax.annotate("F", (0, 1), (-4, 8), textcoords="offset points", ha="right")
    ax.legend(loc="lower right", frameon=False)
    ax.set(aspect="equal", xlim=(-1.15, 2.2), ylim=(-1.15, 1.35))
    ax.axis("off")
    return figure


def figure_3(runs: Runs) -> Any:
    """Surfaces, their harmonic maps, and u on the surfaces."""
    title = "Fig. 3. Surfaces, maps by Algorithm 1 (lai2014), and u of $e^{2u}$"
    figure, axes = page_figure(3, len(TABLE_1), title, 2.4)
    for column, row in zip(axes.T, TABLE_1, strict=True):
        surface = runs.surface(row.surface)
        result = runs.get(surface, "Algorithm 1").result
        show_source(column[0], surface, title=named(surface))
        show_image(
            column[1], surface, result.sphere, title=f"{result.certificate.foldings:,} foldings"
        )
        u = relative_u(surface, result.sphere)
        show_function(
            column[2], surface, u, fitting(FACTORS, u), title="u (0: areas as on average)"
        )
    return figure


def figure_4(runs: Runs) -> Any:
    """Harmonic energy by iteration, and histograms of angle differences."""
    title = "Fig. 4. Algorithm 1: energy by iteration, logarithmic axes, and angle differences"
    figure, axes = page_figure(2, len(TABLE_1), title, 2.4)
    for energy in axes[0, 1:]:
        energy.sharey(axes[0, 0])
    for (energy, angles), row in zip(axes.T, TABLE_1, strict=True):
        surface = runs.surface(row.surface)
        results = _results(runs, surface, "Algorithm 1", SETTINGS)
        for (way, result), colour in zip(results.items(), LINES, strict=False):
            energies = [step.energy for step in result.history if step.stage is Stage.ALGORITHM_1]
            energy.loglog(
                1 + np.arange(len(energies)), energies, color=colour, label=way, linewidth=1
            )
        energy.axhline(4 * np.pi, color=GUIDE, linestyle=":", linewidth=1)
        energy.set_xlabel("iteration + 1", fontsize=TEXT)
        energy.set_ylabel("energy (dotted: 4π)", fontsize=TEXT)
        energy.tick_params(labelsize=TEXT)
        energy.legend(fontsize=TEXT, frameon=False)
        caption(energy, named(surface))
        show_angles(angles, results)
    return figure


def figure_5(runs: Runs) -> Any:
    """The faces of a dinosaur that Algorithm 1 folds: on the body, on the map, and the largest patch of them close."""
    found = dinosaurs(runs)
    figure, axes = page_figure(
        len(found), 3, "Fig. 5. Foldings of Algorithm 1 as printed from the Gauss map", 2.3
    )
    for (source, sphere, close), surface in zip(axes, found, strict=True):
        x = runs.get(surface, "Algorithm 2 as printed").ends[0]
        folded = np.flatnonzero(folded_faces(x, surface.f))
        share = len(folded) / len(surface.f)
        show_source(source, surface, x, title=f"{named(surface)},\n{share:.0%} of the faces folded")
        show_image(
            sphere, surface, x, title=f"map: {len(folded):,} of {len(surface.f):,}\nfaces folded"
        )
        clusters = Clusters.of(surface.f, folded)
        (lens,) = follow(
            [x], surface.f, clusters[0] if clusters else folded, facing=pose(surface.v, surface.up)
        )
        show_image(
            close, surface, lens(x), title=f"the largest patch,\nmagnified {lens.power:,.0f} times"
        )
    return figure


def figure_6(runs: Runs) -> Any:
    """The first three nontrivial eigenfunctions of the sphere, and the surface that they make; needs no run."""
    v, f = samples.make("sphere", n_vertices=10_242)
    surface = PaperSurface("Sphere", v, f, "sample sphere", "the same")
    projection = weighted_eigen_projection(v, f, v)
    figure, axes = page_figure(
        1, 4, "Fig. 6. Laplace-Beltrami eigenfunctions of the sphere, and their surface", 2.3
    )
    ramp = diverging("", round_up(np.abs(projection.phi).max()))
    for k in range(3):
        title = f"$\\phi_{k + 1}$, eigenvalue {projection.eigenvalues[k]:.4f}"
        show_function(axes[0][k], surface, projection.phi[:, k], ramp, title=title)
    show_image(
        axes[0][3],
        surface,
        projection.phi,
        _PHI_RADIUS,
        title=f"$\\Phi = (\\phi_1, \\phi_2, \\phi_3)$\n{_roundness(projection.phi)}",
    )
    return figure


def figure_7(runs: Runs) -> Any:
    """Algorithm 2 as a chart: each stage by its name in the records of runs, with its map of a dinosaur."""
    surface = runs.surface("Dino")
    one = runs.get(surface, "Algorithm 2")
    stages = [
        (name, x)
        for record, *pair in zip(one.result.rounds, one.starts, one.ends, strict=True)
        for name, x in zip((record.start, "Algorithm 1"), pair, strict=True)
    ]
    figure, (axes,) = page_figure(
        1, 1 + len(stages), "Fig. 7. Algorithm 2: star maps, while faces are folded", 1.7
    )
    show_source(axes[0], surface, title=named(surface))
    for ax, (name, x) in zip(axes[1:], stages, strict=True):
        foldings = int(folded_faces(x, surface.f).sum())
        show_image(ax, surface, x, title=f"→ {name}:\n{foldings:,} foldings")
    return figure


def figure_8(runs: Runs) -> Any:
    """The surfaces of Tables 2 and 3."""
    figure, axes = page_figure(3, 4, "Fig. 8. Surfaces that stand for those of Tables 2 and 3", 2.1)
    for ax, row in zip(axes.ravel(), (*TABLE_2, *TABLE_3), strict=True):
        surface = runs.surface(row.surface)
        show_source(ax, surface, title=f"{named(surface)}\n{len(surface.v):,} vertices")
    return figure


def figure_9(runs: Runs) -> Any:
    """Folded faces, map, u, and surface of the weighted eigenfunctions before and after each folding removal."""
    surface = runs.surface("Dino")
    ways = {
        "as printed, 1,000 iterations": "Algorithm 2 as printed, 1,000 iterations",
        "lai2014": "Algorithm 2",
    }
    states = [
        (f"{way},\n{f'after removal {step}' if step else 'before'}", x)
        for way, name in ways.items()
        for step, x in enumerate(runs.get(surface, name).ends)
    ]
    us = [relative_u(surface, x) for _, x in states]
    ramp = fitting(FACTORS, np.concatenate(us))
    title = f"Fig. 9. Algorithm 2 on {surface.relation}: folded faces, map, u, $Φ^u$ (circle: the sphere of Theorem 2)"
    figure, axes = page_figure(len(states), 4, title, 1.6)
    for k, (line, (state, x), u) in enumerate(zip(axes, states, us, strict=True)):
        folded = np.flatnonzero(folded_faces(x, surface.f))
        show_source(line[0], surface, x, title=f"{state}: {len(folded):,} folded faces")
        show_image(line[1], surface, x, title="map")
        show_function(line[2], surface, u, ramp, folded, title="u", bar=k == len(states) - 1)
        projection = weighted_eigen_projection(surface.v, surface.f, x)
        values = ", ".join(f"{value:.2g}" for value in projection.eigenvalues)
        show_image(
            line[3],
            surface,
            projection.phi,
            _PHI_RADIUS,
            title=f"eigenvalues {values}\n{_roundness(projection.phi)}",
        )
    return figure


def figure_10(runs: Runs) -> Any:
    """Algorithm 2, as printed, too, and the algorithm of Gu and Yau on surfaces with long, sharp features."""
    ways = (*SETTINGS, "gu-yau")
    title = "Fig. 10. Algorithm 2 and the algorithm of Gu and Yau, on the surfaces of Fig. 8"
    figure, axes = page_figure(len(FIG_10), 2 + len(ways), title, 1.8)
    for line, name in zip(axes, FIG_10, strict=True):
        surface = runs.surface(name)
        show_source(line[0], surface, title=name)
        results = _results(runs, surface, "Algorithm 2", ways)
        for ax, (way, result) in zip(line[1:], results.items(), strict=False):
            show_image(
                ax,
                surface,
                result.sphere,
                title=f"{way}:\n{result.certificate.foldings:,} foldings",
            )
        show_angles(line[-1], results)
    return figure


#: The figures by the names of their files.
FIGURES = {
    f"fig{k}": figure
    for k, figure in enumerate(
        (
            figure_1,
            figure_2,
            figure_3,
            figure_4,
            figure_5,
            figure_6,
            figure_7,
            figure_8,
            figure_9,
            figure_10,
        ),
        1,
    )
}


def _results(
    runs: Runs, surface: PaperSurface, algorithm: str, ways: Sequence[str]
) -> dict[str, SphereMap]:
    """The maps of some ways to run an algorithm."""
    return {way: runs.get(surface, WAYS[way].format(algorithm)).result for way in ways}


def named(surface: PaperSurface) -> str:
    """The paper's name, and the substitute of its surface."""
    return f"{surface.name}:\n{surface.relation}"


def dinosaurs(runs: Runs) -> list[PaperSurface]:
    """The folder's dinosaur, if there is one, and the sample: meshes of different quality behave differently."""
    found = [runs.surface("Dino"), runs.surface("Dino (sample)")]
    return found[found[0].source == found[1].source :]


def relative_u(surface: PaperSurface, x: FloatArray) -> FloatArray:
    """u of the conformal factor e^{2u}, eq. (14), for the surface scaled to the area of the sphere."""
    factor = conformal_factor(surface.v, surface.f, x)
    return np.asarray(0.5 * np.log(np.maximum(factor, 1e-30)) - _UNIT)


def _roundness(phi: FloatArray) -> str:
    """Distance of the surface of the eigenfunctions from the sphere of Theorem 2."""
    radius = np.linalg.norm(phi, axis=1) / _PHI_RADIUS
    return f"|Φ| from {radius.min():.3f} to {radius.max():.3f} of √(3/4π)"
