"""Maps to the sphere as notebooks show them, and as plots."""

from __future__ import annotations

from typing import Any

from ..maps.sphere_map import SphereMap, map_findings
from ..result.result import result_rows
from .markup import table
from .run import plot_run
from .shown import Drawing, area_drawing, notebook_html


def notebook(result: SphereMap) -> str:
    """The surface and its image above a table of figures, as HTML."""
    return notebook_html(sphere_drawing(result), sphere_figures(result))


def sphere_drawing(result: SphereMap) -> Drawing:
    """The surface and its image, by logarithms of area ratios."""
    return area_drawing(
        result.mesh, result.sphere, result.log_area_ratios(), result.certificate, "on the sphere"
    )


def sphere_figures(result: SphereMap) -> str:
    """The map's figures as a table."""
    return table(result_rows(result, map_findings(result)))


def plot(result: SphereMap) -> Any:
    """The course of the energy, and histograms of angle differences and of logarithms of area ratios."""
    return plot_run(
        result.history,
        None,
        result.angle_differences(),
        result.log_area_ratios(),
        title=f"method {result.method}",
    )
