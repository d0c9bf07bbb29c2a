"""The paper's figures, and two that it lacks: the gradient on its way to rounding, and the residual of eq. (24)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ... import samples
from ...draw.folds import Clusters
from ...draw.palette import FOLDED, GUIDE, INK, LINES
from ...mesh.arrays import FloatArray
from ...mesh.check import Mesh, check_mesh
from ...mesh.measure import angle_defects
from ...operators.laplacian import build_operators
from ...paper.star_map import gauss_map, weighted_eigen_projection
from ...sphere.cayley import cayley_step
from ...verify.distortion import angle_differences, conformal_factor
from ...verify.signs import folded_faces
from .canvas import (
    TEXT,
    caption,
    function_scale,
    page_figure,
    show_angles,
    show_fold,
    show_function,
    show_map,
    show_shape,
    show_source,
)  # fmt: skip
from .runs import Outcome, Runs
from .surfaces import PaperSurface
from .tables import TABLE_1, TABLE_2

#: Surfaces on which Algorithm 1 runs until rounding ends it.
TO_THE_FLOOR = ("Hippocampus 2", "Maxplanck", "Brain")
FIG_10 = ("Dino", "Armadillo", "Bird 1", "Dilo")
#: Radius of the sphere that normalised eigenfunctions make: |phi|^2 = 3 / (4 pi).
_PHI_RADIUS = np.sqrt(3 / (4 * np.pi))
#: u of a surface of unit area, less u of the surface scaled to the area of the sphere.
_UNIT = 0.5 * np.log(4 * np.pi)


def figure_1(runs: Runs) -> Any:
    """A brain and its conformal map, in the brightness of the brain's faces."""
    surface = runs.surface("Brain")
    outcome = runs.get(surface, "default")
    figure, ((source, sphere),) = page_figure(1, 2, "Fig. 1. A brain and its conformal map to the unit sphere", 3.6)
    show_source(source, surface, title=surface.short_source)
    show_map(sphere, surface, outcome.sphere, title=f"mean angle difference {outcome.mean_angle:.2f} degrees")
    return figure


def figure_2(runs: Runs) -> Any:
    """The path of Theorem 1 beside the straight step, in the plane of F and A F at one vertex; needs no run."""
    figure, ((ax,),) = page_figure(1, 1, "Fig. 2. The path of Theorem 1 and the straight step", 5)
    F, AF = np.array([[0.0, 1.0, 0.0]]), np.array([[-1.0, 0.0, 0.0]])
    turn = np.linspace(0, 2 * np.pi, 200)
    ax.plot(np.cos(turn), np.sin(turn), color=GUIDE)
    path = np.array([cayley_step(F, AF, tau)[0] for tau in np.linspace(0, 1.5, 60)])
    ax.plot(path[:, 0], path[:, 1], color=LINES[0], linewidth=3)
    ax.plot([0, 1.5], [1, 1], color=FOLDED, linewidth=2)
    for tau in (0.5, 1.0, 1.5):
        straight, curved = (F - tau * AF)[0], cayley_step(F, AF, tau)[0]
        ax.plot([straight[0], curved[0]], [straight[1], curved[1]], color=GUIDE, linestyle=":")
        ax.plot(*straight[:2], "o", color=FOLDED)
        ax.plot(*curved[:2], "o", color=LINES[0])
        ax.annotate(f"F - {tau:g} AF", straight[:2], (0, 8), textcoords="offset points", ha="center")
        ax.annotate(f"Y[{tau:g}]", curved[:2], (-10, -14), textcoords="offset points", ha="right")
    ax.plot(0, 1, "o", color=INK)
    ax.annotate("F", (0, 1), (-4, 8), textcoords="offset points", ha="right")
    ax.annotate("unit sphere, in the plane of F and AF", (-0.62, -0.3))
    ax.annotate("off the sphere:\ninfeasible", (1.6, 0.85), color=FOLDED)
    ax.annotate("on it, for every step", (-0.28, 0.6), color=LINES[0])
    ax.set(aspect="equal", xlim=(-1.15, 2.2), ylim=(-1.15, 1.35))
    ax.axis("off")
    return figure


def figure_3(runs: Runs) -> Any:
    """Surfaces, their harmonic maps, and u on the surfaces."""
    title = "Fig. 3. Surfaces, maps by Algorithm 1 as printed, and u of $e^{2u}$"
    figure, axes = page_figure(3, len(TABLE_1), title, 2.4)
    for column, row in zip(axes.T, TABLE_1, strict=True):
        surface = runs.surface(row.surface)
        outcome = runs.get(surface, "Algorithm 1 as printed")
        show_source(column[0], surface, title=_named(surface))
        show_map(column[1], surface, outcome.sphere, title=_foldings(outcome))
        show_function(column[2], surface, _u(surface, outcome.sphere), title="u (0: areas as on average)")
    return figure


def figure_4(runs: Runs) -> Any:
    """Harmonic energy by iteration, and histograms of angle differences."""
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    title = "Fig. 4. Algorithm 1 as printed: energy by iteration, logarithmic axes, and counts of angle differences"
    figure, axes = page_figure(2, len(TABLE_1), title, 2.2)
    for (energy, angles), row in zip(axes.T, TABLE_1, strict=True):
        surface = runs.surface(row.surface)
        outcome = runs.get(surface, "Algorithm 1 as printed")
        energy.loglog(1 + np.arange(len(outcome.energies)), outcome.energies, color=LINES[0])
        energy.axhline(4 * np.pi, color=GUIDE, linestyle=":", linewidth=1)
        energy.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        for axis in (energy.xaxis, energy.yaxis):
            axis.set_major_formatter(StrMethodFormatter("{x:,.0f}"))
            axis.set_minor_formatter(NullFormatter())
        energy.set_xlabel("iteration + 1", fontsize=TEXT)
        energy.set_ylabel("energy (dotted: 4π)", fontsize=TEXT)
        energy.tick_params(labelsize=TEXT)
        caption(energy, _named(surface))
        differences = _differences(surface, outcome)
        show_angles(angles, differences, np.abs(differences).max())
    return figure


def figure_5(runs: Runs) -> Any:
    """The faces of a dinosaur that Algorithm 1 folds."""
    found = dinosaurs(runs)
    figure, axes = page_figure(len(found), 4, "Fig. 5. Foldings of Algorithm 1 as printed from the Gauss map", 2.1)
    for line, surface in zip(axes, found, strict=True):
        x = runs.get(surface, "Algorithm 2 as printed").maps[0]
        folded = np.flatnonzero(folded_faces(x, surface.f))
        share = len(folded) / len(surface.f)
        show_source(line[0], surface, x, title=f"{surface.short_source}:\n{share:.0%} of the faces are folded")
        show_map(line[1], surface, x, title=f"map: {len(folded):,} of {len(surface.f):,}\nfaces folded")
        for ax in line[2:]:
            ax.axis("off")
        for ax, patch in zip(line[2:], Clusters.of(surface.f, folded), strict=False):
            show_fold(ax, surface, x, patch)
    return figure


def figure_6(runs: Runs) -> Any:
    """The first three nontrivial eigenfunctions of the sphere, and the surface that they make; needs no run."""
    v, f = samples.make("sphere", n_vertices=10_242)
    surface = PaperSurface("Sphere", v, f, "sample:sphere", "the same")
    projection = weighted_eigen_projection(v, f, v)
    figure, axes = page_figure(1, 4, "Fig. 6. Laplace-Beltrami eigenfunctions of the sphere, and their surface", 2.3)
    scale = function_scale(projection.phi.ravel())
    for k in range(3):
        title = f"$\\phi_{k + 1}$, eigenvalue {projection.eigenvalues[k]:.4f}"
        show_function(axes[0][k], surface, projection.phi[:, k], scale, title=title)
    show_shape(axes[0][3], surface, projection.phi, title=f"$\\Phi = (\\phi_1, \\phi_2, \\phi_3)$\n"
                                                          f"{_roundness(projection.phi)}")
    return figure


def figure_7(runs: Runs) -> Any:
    """Algorithm 2 as a chart: each stage by its name in the records of runs, with its map of a dinosaur."""
    surface = runs.surface("Dino", sample=True)
    outcome = runs.get(surface, "Algorithm 2 made safe")
    stages: list[tuple[str, FloatArray]] = []
    for record, x in zip(outcome.rounds, outcome.maps, strict=True):
        start = weighted_eigen_projection(surface.v, surface.f, stages[-1][1]).star_map if stages else None
        stages.append((record["start"], gauss_map(surface.v, surface.f) if start is None else start))
        stages.append(("Algorithm 1", x))
    figure, (axes,) = page_figure(1, 1 + len(stages), "Fig. 7. Algorithm 2", 2.2)
    figure.set_layout_engine(None)  # the usual one leaves no room for arrows between axes
    figure.subplots_adjust(0.01, 0.14, 0.99, 0.84, wspace=0.2)
    show_source(axes[0], surface, title=surface.short_source)
    for ax, (name, x) in zip(axes[1:], stages, strict=True):
        show_map(ax, surface, x, title=f"{name}\n{int(folded_faces(x, surface.f).sum()):,} foldings")
        _arrow(ax, (-0.11, 0.5), (0.0, 0.5))
        if name == "star map":
            _arrow(ax, (1.6, 0.0), (0.5, 0.0), bend=-0.2)
            ax.annotate("while faces are folded", (1.05, -0.22), xycoords="axes fraction", ha="center", va="center",
                        fontsize=TEXT)
    return figure


def figure_8(runs: Runs) -> Any:
    """The surfaces of Table 2."""
    figure, axes = page_figure(2, 4, "Fig. 8. The surfaces of Table 2", 2.1)
    for ax in axes.ravel()[len(TABLE_2) :]:
        ax.axis("off")
    for ax, row in zip(axes.ravel(), TABLE_2, strict=False):
        surface = runs.surface(row.surface)
        show_source(ax, surface, title=f"{_named(surface)}\n{len(surface.v):,} vertices")
    return figure


def figure_9(runs: Runs) -> Any:
    """Folded faces, map, u, and surface of the weighted eigenfunctions before and after each folding removal."""
    surface = runs.surface("Dino", sample=True)
    ways = ("as printed", "made safe")
    states = [(f"{way}, {f'after removal {step}' if step else 'before'}", x) for way in ways
              for step, x in enumerate(runs.get(surface, f"Algorithm 2 {way}").maps)]
    us = [_u(surface, x) for _, x in states]
    scale = function_scale(*us)
    figure, axes = page_figure(len(states), 4, "Fig. 9. Algorithm 2: folded faces, map, u, surface of $Φ^u$", 1.5)
    for k, (line, (state, x), u) in enumerate(zip(axes, states, us, strict=True)):
        _removal(line, surface, state, x, u, scale, k == len(states) - 1)
    return figure


def _removal(
    line: Any, surface: PaperSurface, state: str, x: FloatArray, u: FloatArray, scale: Any, last: bool
) -> None:
    """One row of Fig. 9: the state after a step of Algorithm 2."""
    folded = np.flatnonzero(folded_faces(x, surface.f))
    show_source(line[0], surface, x, title=f"{state}:\n{len(folded):,} folded faces")
    show_map(line[1], surface, x, title="map")
    show_function(line[2], surface, u, scale, title="u", box=folded, bar=last)
    projection = weighted_eigen_projection(surface.v, surface.f, x)
    values = ", ".join(f"{value:.3f}" for value in projection.eigenvalues)
    show_shape(line[3], surface, projection.phi, title=f"eigenvalues {values}\n{_roundness(projection.phi)}")


def figure_10(runs: Runs) -> Any:
    """The algorithm of Gu and Yau and Algorithm 2 on surfaces with long, sharp features."""
    title = "Fig. 10. Surfaces; Gu-Yau; Algorithm 2 made safe (vermilion: folded)"
    figure, axes = page_figure(len(FIG_10), 5, title, 1.8)
    for line, name in zip(axes, FIG_10, strict=True):
        surface = runs.surface(name)
        show_source(line[0], surface, title=_named(surface))
        outcomes = {method: runs.get(surface, method) for method in ("Gu-Yau", "Algorithm 2 made safe")}
        differences = [_differences(surface, outcome) for outcome in outcomes.values()]
        reach = max(np.abs(each).max() for each in differences)
        for axes_of, (method, outcome), each in zip((line[1:3], line[3:]), outcomes.items(), differences, strict=True):
            show_map(axes_of[0], surface, outcome.sphere, title=f"{method}:\n{_foldings(outcome)}")
            show_angles(axes_of[1], each, reach)
            axes_of[1].set_ylabel("")
    return figure


def gradient(runs: Runs) -> Any:
    """The norm of the gradient A F by iteration of Algorithm 1, until rounding ends its fall."""
    figure, ((ax,),) = page_figure(1, 1, "Algorithm 1 without a stopping rule: gradient by iteration", 3.5)
    curves = []
    for colour, name in zip(LINES, TO_THE_FLOOR, strict=False):
        surface = runs.surface(name)
        norms = runs.get(surface, "Algorithm 1 without a stopping rule").residuals
        ax.loglog(1 + np.arange(len(norms)), norms, color=colour, alpha=0.25, linewidth=0.5)
        curves += ax.loglog(1 + np.arange(len(norms)), np.minimum.accumulate(norms), color=colour,
                            label=f"{name}:\n{surface.short_source},\nleast {norms.min():.1e}")
    ax.axhline(1e-3, color=GUIDE, linestyle=":")
    ax.annotate("tolerance of this package, 1e-3", (1, 1e-3), (0, 3), textcoords="offset points", fontsize=TEXT)
    ax.set_xlabel("iteration + 1", fontsize=TEXT)
    ax.set_ylabel("L2 norm of A F (bold: the least so far)", fontsize=TEXT)
    ax.tick_params(labelsize=TEXT)
    curves.sort(key=lambda curve: -curve.get_ydata()[-1])  # in the order in which they end
    ax.legend(handles=curves, fontsize=TEXT, loc="lower left", bbox_to_anchor=(1, 0), frameon=False, labelspacing=1.2)
    return figure


def equation_24(runs: Runs) -> Any:
    """u of eq. (14), u that solves eq. (24) with its right-hand side, and the difference of the two."""
    figure, axes = page_figure(3, len(TABLE_1), "Eq. (24): u of the map by (14), u that solves (24), difference", 2.5)
    for column, row in zip(axes.T, TABLE_1, strict=True):
        surface = runs.surface(row.surface)
        mesh = check_mesh(surface.v, surface.f)
        u = _u(surface, runs.get(surface, "default").sphere)
        error = curvature_error(mesh, u + _UNIT)
        scale = function_scale(u, u - error)
        show_function(column[0], surface, u, scale, title=f"{_named(surface)}\nu of (14)")
        show_function(column[1], surface, u - error, scale, title="u that solves (24)")
        show_function(column[2], surface, error, title=f"difference: mean size {mesh.A @ np.abs(error):.2g}")
    return figure


def curvature_error(mesh: Mesh, u: FloatArray) -> FloatArray:
    """u less the solution w of L w = A e^{2u} - K of the same mean: eq. (24) with K the angle defects."""
    operators = build_operators(mesh, "auto")
    K = angle_defects(mesh.angles, mesh.f, len(mesh.v))
    residual = operators.L @ u + K - mesh.A * np.exp(2 * u)  # eq. (24)
    error = operators.factor.solve(residual - mesh.A * residual.sum())
    return np.asarray(error - mesh.A @ error)


#: The figures by the names of their files.
FIGURES = {
    "fig1": figure_1,
    "fig2": figure_2,
    "fig3": figure_3,
    "fig4": figure_4,
    "fig5": figure_5,
    "fig6": figure_6,
    "fig7": figure_7,
    "fig8": figure_8,
    "fig9": figure_9,
    "fig10": figure_10,
    "gradient": gradient,
    "eq24": equation_24,
}


def _named(surface: PaperSurface) -> str:
    return f"{surface.name}\n{surface.short_source}"


def _arrow(ax: Any, start: tuple[float, float], end: tuple[float, float], bend: float = 0.0) -> None:
    """An arrow in fractions of the axes, which may lead out of them."""
    style = {"arrowstyle": "-|>", "color": INK, "linewidth": 1.5, "connectionstyle": f"arc3,rad={bend}"}
    ax.annotate("", end, start, xycoords="axes fraction", textcoords="axes fraction", annotation_clip=False,
                arrowprops=style)


def _foldings(outcome: Outcome) -> str:
    return "no map" if outcome.foldings < 0 else f"{outcome.foldings:,} foldings"


def _differences(surface: PaperSurface, outcome: Outcome) -> FloatArray:
    """Angle differences of a run's result in degrees; NaN if there is no map."""
    return angle_differences(surface.v, surface.f, outcome.sphere)


def dinosaurs(runs: Runs) -> list[PaperSurface]:
    """The folder's dinosaur, if there is one, and the sample: meshes of different quality behave differently."""
    found = [runs.surface("Dino"), runs.surface("Dino", sample=True)]
    return found[found[0].source == found[1].source :]


def _u(surface: PaperSurface, x: FloatArray) -> FloatArray:
    """u of the conformal factor e^{2u}, eq. (14), for the surface scaled to the area of the sphere."""
    factor = conformal_factor(surface.v, surface.f, x)
    return np.asarray(0.5 * np.log(np.maximum(factor, 1e-30)) - _UNIT)


def _roundness(phi: FloatArray) -> str:
    """How far the surface of the eigenfunctions is from the sphere of Theorem 2."""
    radius = np.linalg.norm(phi, axis=1) / _PHI_RADIUS
    return f"|Φ| from {radius.min():.3f} to {radius.max():.3f} of √(3/4π)"
