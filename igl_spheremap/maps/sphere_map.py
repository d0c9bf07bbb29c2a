"""The result: a map, its certificate, and how it came about."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from .. import wings
from ..errors import FoldingsRemain, Remedy
from ..gate import gate
from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..result.findings import Finding, angles, areas, energy, verdict
from ..result.result import Result
from ..result.run import Listener, Run, Status
from ..verify.certificate import Certificate
from ..verify.distortion import angle_differences, conformal_factor, log_area_ratios


@dataclass(frozen=True, eq=False, repr=False)
class SphereMap(Result):
    """A map of a closed genus-0 mesh to the unit sphere.

    Notebooks show it as a picture of the surface and its image above a table of its figures.

    Attributes
    ----------
    mesh : Mesh
        The source, checked: measures of the map need no further check.
    sphere : (n, 3) float64 array
        Images of the vertices, unit rows, in the input's order. Read-only, since the certificate is of these numbers:
        copy it to change it.
    certificate : Certificate
        Of ``sphere`` and ``faces``, in exact arithmetic.
    run : Run
        How the map came about. The map has its attributes, too: ``result.energy`` is ``result.run.energy``.
    conformal : SphereMap, optional
        The conformal map that a balanced one started from.
    """

    _in_words = (
        "a SphereMap, as balanced_spherical_map(v, f) makes one, "
        "and sphere_map(v, f, x) of positions x"
    )

    mesh: Mesh
    sphere: FloatArray
    certificate: Certificate
    run: Run
    conformal: SphereMap | None = None

    def __post_init__(self) -> None:
        self.sphere.flags.writeable = False

    @property
    def _images(self) -> FloatArray:
        return self.sphere

    @gate
    def angle_differences(self) -> FloatArray:
        """Angle differences in degrees, image minus source.

        Returns
        -------
        (m, 3) float64 array
            As from `igl_spheremap.angle_differences`, without the rows of caps.
        """
        return angle_differences(self.vertices, self.faces[self.mesh.surface], self.sphere)

    @gate
    def conformal_factor(self) -> FloatArray:
        """Conformal factor e^{2u} at the vertices, equation (14).

        Returns
        -------
        (n,) float64 array
            As from `igl_spheremap.conformal_factor`.
        """
        return conformal_factor(self.vertices, self.faces, self.sphere)

    @gate
    def log_area_ratios(self) -> FloatArray:
        """Natural logarithm of image area over source area of every face, each surface having area 1.

        Returns
        -------
        (m,) float64 array
            As from `igl_spheremap.log_area_ratios`, without the rows of caps and their areas.
        """
        return log_area_ratios(self.vertices, self.faces[self.mesh.surface], self.sphere)

    def plot(self) -> Any:
        """Plot the course of the energy, and histograms of angle differences and of logarithms of area ratios.

        Returns
        -------
        matplotlib.figure.Figure
            Notebooks show it; save it by its ``savefig``.

        Raises
        ------
        FileError
            If matplotlib is not installed.
        """
        return wings.plot(self)

    def _rebalanced(self, balance: float, listener: Listener | None) -> SphereMap:
        conformal = self._conformal_one()
        if balance == 0 or conformal.status is Status.STOPPED:
            return conformal
        if not (self.certificate.folding_free and conformal.certificate.folding_free):
            repair = Remedy("repair_foldings", given="v, f, x")
            raise FoldingsRemain(
                f"a map with foldings can't be balanced; remove them ({repair} does)", self
            )
        return wings.rebalanced(self, balance, listener)

    @gate
    def _repr_html_(self) -> str:
        """The map in a notebook."""
        return wings.notebook(self)


def map_findings(result: SphereMap) -> list[Finding]:
    """Findings on a map; the verdict comes last."""
    found = [
        energy(result.energy),
        angles(result.angle_differences()),
        areas(result.log_area_ratios()),
    ]
    if result.stretch != 1:
        without = Remedy(options={"gauge": "centred"})
        text = f"limbs too deep for float64 are mapped as if {result.stretch:.3g} times shorter"
        if result.gauge != "poles":
            text += f"; without {without} they may keep their angles"
        found.append(Finding("stretch", text, {}))
    return [*found, verdict(result.certificate, result.mesh.caps)]


#: Header of `round_rows`.
ROUNDS = ("round", "from", "folded faces", "iterations", "energy", "mean angle")


def round_rows(result: SphereMap) -> list[tuple[str, ...]]:
    """Figures of each round as texts, under the header `ROUNDS`; the last row is that of the result."""
    rows: list[tuple[str, ...]] = [
        (
            str(each.round),
            each.start,
            f"{each.foldings_before:,} -> {each.foldings_after:,}",
            f"{each.iterations:,}",
            f"{each.energy:.6f}",
            _measured(each.mean_angle_difference),
        )
        for each in result.rounds
    ]
    mean = angles(result.angle_differences()).numbers["angle_differences"]["mean"]
    outcome = (f"{result.energy:.6f}", f"{mean:.3g}")
    if rows and rows[-1][-2:] != outcome:  # balanced, polished or turned since
        folded = f"{result.rounds[-1].foldings_after:,} -> {result.certificate.foldings:,}"
        rows.append(("", "the last round", folded, "", *outcome))
    return rows


def _measured(degrees: float) -> str:
    """An angle as a text; if it was not measured, an empty one."""
    if math.isnan(degrees):
        return ""
    return f"{degrees:.3g}"
