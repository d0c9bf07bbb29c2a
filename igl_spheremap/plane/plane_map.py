"""Results of maps of disks to the plane: positions, certificate, and the record of the run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..draw.markup import table
from ..draw.plot import plot_plane
from ..draw.shown import Drawing, Shown, area_drawing
from ..gate import gate
from ..mesh.arrays import FloatArray, IntArray
from ..mesh.disk import Disk
from ..result.findings import Finding, angles, areas, edges, verdict
from ..result.result import Result, result_rows
from ..result.run import Run, Status
from ..sphere.rows import weighted_sum
from ..verify.certificate import Certificate
from ..verify.distortion import angle_differences, log_area_ratios, log_length_ratios


@dataclass(frozen=True, eq=False, repr=False)
class PlaneMap(Shown, Result):
    """A map of a surface with one boundary loop to the plane.

    Attributes
    ----------
    mesh : Disk
        The source, checked.
    plane : (n, 2) float64 array
        Images of the vertices, in the input's order.
    certificate : Certificate
        Of ``plane`` and ``faces``, in exact arithmetic.
    run : Run
        How the map came about.
    conformal : DiskMap, optional
        The conformal map that it started from.
    """

    _in_words = "a map as flatten(v, f) makes one"

    mesh: Disk
    plane: FloatArray
    certificate: Certificate
    run: Run
    conformal: PlaneMap | None = None

    def __post_init__(self) -> None:
        self.plane.flags.writeable = False

    @property
    def _images(self) -> FloatArray:
        return self.plane

    @property
    def rim(self) -> IntArray:
        """Vertices of the boundary loop (k,), counterclockwise in the plane."""
        return self.mesh.rim

    @property
    def image(self) -> FloatArray:
        """Images as points of space, (n, 3): x, y, and 0."""
        return in_space(self.plane)

    @property
    def _scaled(self) -> FloatArray:
        """The image with coordinates up to 1: squares of measures stay within float64."""
        return self.image / np.abs(self.plane).max()

    @gate
    def angle_differences(self) -> FloatArray:
        """Angle differences in degrees, image minus source.

        Returns
        -------
        (m, 3) float64 array
            Column k belongs to corner ``faces[:, k]``; zero for a conformal map. Caps have no rows.
        """
        return angle_differences(self.mesh.unit, self.faces[self.mesh.surface], self._scaled)

    @gate
    def log_area_ratios(self) -> FloatArray:
        """Natural logarithm of image area over source area of every face, each surface having area 1.

        Returns
        -------
        (m,) float64 array
            Zero for an area-preserving map. Caps have no rows.
        """
        return log_area_ratios(self.mesh.unit, self.faces[self.mesh.surface], self._scaled)

    @gate
    def log_length_ratios(self) -> FloatArray:
        """Natural logarithm of image length over source length of every edge, each surface having area 1.

        Returns
        -------
        (m, 3) float64 array
            Column k belongs to the edge opposite corner ``faces[:, k]``; zero for an isometry up to scale. Caps have
            no rows.
        """
        return log_length_ratios(self.mesh.unit, self.faces[self.mesh.surface], self._scaled)

    def plot(self, title: str = "") -> Any:
        """Plot the image, coloured by area ratios, and histograms of the map's changes of angles and areas.

        Parameters
        ----------
        title : str
            Above the figure.

        Returns
        -------
        matplotlib.figure.Figure
            Notebooks show it; save it by its ``savefig``.

        Raises
        ------
        FileError
            If matplotlib is not installed.
        """
        faces = self.faces[self.mesh.surface]
        return plot_plane(
            self.plane, faces, self.angle_differences(), self.log_area_ratios(), title
        )

    def _drawing(self) -> Drawing:
        return area_drawing(
            self.mesh, self._scaled, self.log_area_ratios(), self.certificate, "in the plane"
        )

    def _figures(self) -> str:
        return table(result_rows(self, plane_findings(self)))

    def _size(self) -> str:
        return f"{super()._size()}, {len(self.rim):,} on the rim"


def given_map(mesh: Disk, p: FloatArray) -> PlaneMap:
    """A map to the plane that another program made, or a file holds, with its certificate."""
    run = Run(Status.DONE, float("nan"), "given", gauge="given")
    return PlaneMap(mesh, p, Certificate.of_plane(p, mesh.f, mesh.rim), run)


def unit_square(p: FloatArray) -> tuple[FloatArray, dict[str, Any]]:
    """Texture coordinates uv of a map to the plane, and the numbers in files: ``uv = factor * (p - corner)``.

    The longer side of the image becomes 1.
    """
    corner = p.min(axis=0)
    size = float((p.max(axis=0) - corner).max())
    return (p - corner) / size, {"factor": 1 / size, "corner": corner.tolist()}


def in_space(p: FloatArray) -> FloatArray:
    """Points of the plane as points of space."""
    return np.column_stack((p, np.zeros(len(p))))


def plane_findings(result: PlaneMap) -> list[Finding]:
    """Findings on a map to the plane; the verdict comes last."""
    return [
        angles(result.angle_differences()),
        areas(result.log_area_ratios()),
        edges(result.log_length_ratios()),
        verdict(result.certificate, result.mesh.caps),
    ]


def upright(p: FloatArray, disk: Disk) -> FloatArray:
    """A map to the plane turned so that it agrees best with two of the surface's coordinates, as seen from either side.

    A surface in the plane z = 0 keeps its directions; one that faces downwards keeps that of x.
    """
    v, z = disk.unit - weighted_sum(disk.A, disk.unit), p[:, 0] + 1j * p[:, 1]
    slopes = [
        complex((disk.A * (v[:, i] + side * v[:, j]) * z).sum())
        for i, j in ((0, 1), (0, 2), (1, 2))
        for side in (-1j, 1j)
    ]
    largest = max(map(abs, slopes))
    # the first of the views that agree equally well, up to rounding
    slope = next(slope for slope in slopes if abs(slope) >= (1 - 1e-6) * largest)
    if slope:
        z = z * (abs(slope) / slope)
    return np.column_stack((z.real, z.imag))
