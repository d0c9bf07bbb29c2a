"""The result: a map, its certificate, and how it came about."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..draw.markup import table
from ..errors import own_errstate
from ..mesh.arrays import FloatArray, IntArray
from ..mesh.check import Mesh
from ..verify.certificate import Certificate
from ..verify.distortion import angle_differences, area_distortion, conformal_factor
from .findings import Finding, angles, areas, energy, verdict
from .recording import plot_run
from .run import Round, Run, Status, Step


@dataclass(frozen=True, eq=False)
class SphereMap:
    """A map of a closed genus-0 mesh to the unit sphere.

    Attributes
    ----------
    mesh : Mesh
        The source, checked: what is measured of the map needs no further check.
    sphere : (n, 3) float64 array
        Images of the vertices, unit rows, in the input's order. Read-only, since the certificate is of these numbers:
        copy it to change it.
    certificate : Certificate
        Of ``sphere`` and ``faces``, in exact arithmetic.
    run : Run
        How the map came about. What it holds can be read from the map, too: ``result.energy`` is ``result.run.energy``.
    conformal : SphereMap, optional
        The conformal map that a balanced one started from.
    """

    mesh: Mesh
    sphere: FloatArray
    certificate: Certificate
    run: Run
    conformal: SphereMap | None = None

    def __post_init__(self) -> None:
        self.sphere.flags.writeable = False

    @property
    def vertices(self) -> FloatArray:
        """The source as it was given, (n, 3) float64."""
        return self.mesh.vertices

    @property
    def faces(self) -> IntArray:
        """The input's faces, (m, 3) int64; positively oriented (outward) on the sphere."""
        return self.mesh.f

    @property
    def energy(self) -> float:
        """Harmonic energy, equation (6); 4 pi for a smooth conformal map."""
        return self.run.energy

    @property
    def status(self) -> Status:
        """How the last minimisation ended."""
        return self.run.status

    @property
    def iterations(self) -> int:
        """Iterations of all stages together."""
        return self.run.iterations

    @property
    def seconds(self) -> float:
        """Wall time from arrays to result."""
        return self.run.seconds

    @property
    def timings(self) -> dict[str, float]:
        """Wall seconds by stage."""
        return self.run.timings

    @property
    def method(self) -> str:
        """The method's name."""
        return self.run.method

    @property
    def settings(self) -> dict[str, Any]:
        """The method's options that are not at their defaults."""
        return self.run.settings

    @property
    def history(self) -> tuple[Step, ...]:
        """Every iterate of every stage."""
        return self.run.history

    @property
    def rounds(self) -> tuple[Round, ...]:
        """Foldings before and after each round of folding removal."""
        return self.run.rounds

    @property
    def backend(self) -> str:
        """The factorisation that was used; empty where none was."""
        return self.run.backend

    @property
    def notes(self) -> tuple[str, ...]:
        """Remarks on the run."""
        return self.run.notes

    @property
    def gauge(self) -> str:
        """Where the map lies among its Moebius images: "centred", "turned", "poles", "given" or "free", see `Run`."""
        return self.run.gauge

    @property
    def stretch(self) -> float:
        """How many times limbs too deep for float64 are shortened; 1 if there is none."""
        return self.run.stretch

    @property
    def balance(self) -> float:
        """0 for a conformal map, 1 for an area-preserving one."""
        return self.run.balance

    @own_errstate
    def angle_differences(self) -> FloatArray:
        """Angle differences in degrees, image minus source.

        Returns
        -------
        (m, 3) float64 array
            As from `igl_spheremap.angle_differences`, without the rows of caps.
        """
        return angle_differences(self.vertices, self.faces[self.mesh.surface], self.sphere)

    @own_errstate
    def conformal_factor(self) -> FloatArray:
        """Conformal factor e^{2u} at the vertices, equation (14).

        Returns
        -------
        (n,) float64 array
            As from `igl_spheremap.conformal_factor`.
        """
        return conformal_factor(self.vertices, self.faces, self.sphere)

    @own_errstate
    def area_ratios(self) -> FloatArray:
        """Logarithm of image area over source area of every face, each surface having area 1.

        Returns
        -------
        (m,) float64 array
            As from `igl_spheremap.area_distortion`, without the rows of caps and their areas.
        """
        return area_distortion(self.vertices, self.faces[self.mesh.surface], self.sphere)

    def drop_caps(self) -> OpenMap:
        """The open surface and its image, without the caps that close its holes and cuts.

        Faces and vertices keep their order; what is certified of the whole map holds of a part: it is injective.

        Returns
        -------
        OpenMap
            The surface, the positions of its vertices on the sphere, and where they stand in this map.

        Examples
        --------
        >>> import igl_spheremap as ism
        >>> v, f = ism.samples.make("spheroid", n_vertices=500)
        >>> mesh = ism.repair_mesh(v, f[2:], holes="fill")
        >>> part = ism.spherical_conformal_map(mesh.v, mesh.f, caps=mesh.face_source < 0).drop_caps()
        >>> bool((part.v == v).all()), bool((part.f == f[2:]).all()), part.sphere.shape == v.shape
        (True, True, True)
        """
        kept = self.faces[self.mesh.surface]
        rows = np.unique(kept)
        return OpenMap(self.vertices[rows], np.searchsorted(rows, kept), self.sphere[rows], rows)

    def plot(self) -> Any:
        """Plot the course of the energy and the histogram of angle differences.

        Returns
        -------
        matplotlib.figure.Figure
            Notebooks show it; save it by its ``savefig``.

        Raises
        ------
        FileError
            If matplotlib is not installed.
        """
        return plot_run(self.history, None, self.angle_differences(), self.area_ratios(),
                        title=f"method {self.method}")

    def explain(self) -> str:
        """Say what was decided on the way to the map, and why.

        Returns
        -------
        str
            The method, and the plan of the repair if there was one; a line for each map on the way, with its folded
            faces and its mean angle difference in degrees; and the notes.

        Examples
        --------
        >>> import igl_spheremap as ism
        >>> print(ism.spherical_conformal_map(*ism.samples.make("sphere", n_vertices=500)).explain())
        auto: no face folds, and steps are predicted to gain less than 3.9 percent; so no steps are taken
        """
        lines = [f"{self.method}: {self.run.plan or self.status.value}"]
        lines += [f"{each.start}: {each.foldings_after:,} folded faces, {each.mean_angle_difference:.3g} degrees off"
                  for each in self.rounds]
        return "\n".join((*lines, *self.notes))

    def _repr_html_(self) -> str:
        """The figures as notebooks show them."""
        return table(result_rows(self))

    def __repr__(self) -> str:
        outcome = "folding-free" if self.certificate.folding_free else f"{self.certificate.foldings} foldings"
        return (f"SphereMap({len(self.vertices)} vertices, {len(self.faces)} faces, method={self.method!r}, {outcome}, "
                f"energy={self.energy:.6f}, {self.status.name}, {self.iterations} iterations, {self.seconds:.2f} s)")


class OpenMap(NamedTuple):
    """A part of a surface and its image on the unit sphere, see `SphereMap.drop_caps`.

    Attributes
    ----------
    v : (k, 3) float64 array
        Vertices of the surface.
    f : (l, 3) int64 array
        Its faces, indices of these vertices.
    sphere : (k, 3) float64 array
        Images of the vertices, unit rows.
    vertex_source : (k,) int64 array
        Row of each vertex in the map that it is a part of.
    """

    v: FloatArray
    f: IntArray
    sphere: FloatArray
    vertex_source: IntArray


def run_findings(result: SphereMap) -> list[Finding]:
    """How a map was made: the method's line, and the notes."""
    options = ", ".join(f"{key} = {value}" for key, value in result.settings.items() if key != "balance")
    made = "".join((result.method, f" ({options})" if options else "", f", {result.backend}" if result.backend else ""))
    plural = "s" * (result.iterations != 1)
    text = f"{made}: {result.iterations} iteration{plural}, {result.seconds:.2f} s; {result.status.value}"
    run = {
        "method": result.method, "settings": result.settings, "backend": result.backend, "timings": result.timings,
        "iterations": result.iterations, "seconds": result.seconds, "status": result.status.name,
        "rounds": [entry.__dict__ | {"status": entry.status.name} for entry in result.rounds],
    }  # fmt: skip
    notes = [Finding("note", note, {}) for note in result.notes]
    return [Finding("method", text, run), *notes]


def map_findings(result: SphereMap) -> list[Finding]:
    """What is known of a map; the verdict comes last."""
    found = [energy(result.energy), angles(result.angle_differences()), areas(result.area_ratios())]
    if result.balance:
        text = f"{result.balance:g} on the way from conformal (0) to area-preserving (1)"
        found.append(Finding("balance", text, {}))
    if result.stretch != 1:
        advice = "" if result.gauge == "poles" else '; without gauge="centred" they may keep their angles'
        text = f"limbs too deep for float64 are mapped as if {result.stretch:.3g} times shorter{advice}"
        found.append(Finding("stretch", text, {}))
    return [*found, verdict(result.certificate, result.mesh.caps)]


def result_rows(result: SphereMap) -> list[tuple[str, str]]:
    """All findings as labels and texts, the verdict first."""
    *known, certificate = map_findings(result)
    size = Finding("mesh", f"{len(result.vertices):,} vertices, {len(result.faces):,} faces", {})
    return [(found.label, found.text) for found in (certificate, size, *known, *run_findings(result))]


ROUNDS = ("round", "from", "folded faces", "iterations", "energy", "mean angle")


def round_rows(result: SphereMap) -> list[tuple[str, ...]]:
    """Figures of each round as texts, under the header `ROUNDS`; the last row is that of the result."""
    rows: list[tuple[str, ...]] = [
        (str(each.round), each.start, f"{each.foldings_before:,} -> {each.foldings_after:,}", f"{each.iterations:,}",
         f"{each.energy:.6f}", f"{each.mean_angle_difference:.3g}")
        for each in result.rounds
    ]
    mean = angles(result.angle_differences()).numbers["angle_differences"]["mean"]
    outcome = (f"{result.energy:.6f}", f"{mean:.3g}")
    if rows and rows[-1][-2:] != outcome:  # balanced, polished or turned since
        folded = f"{result.rounds[-1].foldings_after:,} -> {result.certificate.foldings:,}"
        rows.append(("", "the last round", folded, "", *outcome))
    return rows
