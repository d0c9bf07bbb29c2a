"""The result: a map, its certificate, and how it came about."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ..draw.markup import table
from ..mesh.arrays import FloatArray, IntArray
from ..verify.certificate import Certificate
from ..verify.distortion import angle_differences, area_distortion, conformal_factor
from .findings import Finding, angles, areas, energy, verdict
from .recording import plot_run
from .run import Round, Status, Step


@dataclass(frozen=True, eq=False)
class SphereMap:
    """A map of a closed genus-0 mesh to the unit sphere.

    Attributes
    ----------
    vertices : (n, 3) float64 array
        The source as it was given.
    faces : (m, 3) int64 array
        The input's faces; positively oriented (outward) on the sphere.
    sphere : (n, 3) float64 array
        Images of the vertices, unit rows, in the input's order.
    certificate : Certificate
        Of ``sphere`` and ``faces``, in exact arithmetic.
    energy : float
        Harmonic energy, eq. (6); 4 pi for a smooth conformal map.
    status : Status
        How the last minimisation ended.
    iterations : int
        Iterations of all stages together.
    seconds : float
        Wall time from arrays to result.
    method : str
        The method's name.
    history : tuple of Step
        Every iterate of every stage.
    rounds : tuple of Round
        Foldings before and after each round of folding removal.
    backend : str
        The factorisation that was used; empty where none was.
    notes : tuple of str
        Remarks on the run, such as other edge weights where the mesh's own can't be used.
    settings : dict
        The method's options that are not at their defaults.
    gauge : str
        "centred": Moebius-centred on the source's area (or on weights given to `SphereMapper.map`) and turned to the
        Gauss map; a note says where that would fold huge faces, so that the map is not quite centred. "turned", of
        balanced maps: turned to the Gauss map only. "poles", of bodies with limbs beyond float64: the tips of the
        deepest, three at the most, at ends of the axes. "given", of `sphere_map` and `repair_foldings`: as it was
        given. "free", of landmark maps, and of p-harmonic maps with p above 2: as the minimisation left it.
    balance : float
        0 for a conformal map, 1 for an area-preserving one, see `igl_spheremap.balanced_spherical_map`.
    conformal : SphereMap, optional
        The conformal map that a balanced one started from.
    stretch : float
        Limbs too deep for float64 are mapped as if up to so many times shorter, so that angles are off there; 1 if
        there is none.
    timings : dict
        Wall seconds by stage ("check", "Laplacian", "factorisation", "solves", "start", "steps", "gauge",
        "certificate", "repair", ...), each without what other stages took inside it. Files don't keep them.
    """

    vertices: FloatArray
    faces: IntArray
    sphere: FloatArray
    certificate: Certificate
    energy: float
    status: Status
    iterations: int
    seconds: float
    method: str
    history: tuple[Step, ...] = ()
    rounds: tuple[Round, ...] = ()
    backend: str = ""
    notes: tuple[str, ...] = ()
    settings: dict[str, Any] = field(default_factory=dict)
    gauge: str = "centred"
    stretch: float = 1.0
    balance: float = 0.0
    conformal: SphereMap | None = None
    timings: dict[str, float] = field(default_factory=dict, compare=False)

    def angle_differences(self) -> FloatArray:
        """Angle differences in degrees, image minus source.

        Returns
        -------
        (m, 3) float64 array
            As from `igl_spheremap.angle_differences`.
        """
        return angle_differences(self.vertices, self.faces, self.sphere)

    def conformal_factor(self) -> FloatArray:
        """Conformal factor e^{2u} at the vertices, equation (14).

        Returns
        -------
        (n,) float64 array
            As from `igl_spheremap.conformal_factor`.
        """
        return conformal_factor(self.vertices, self.faces, self.sphere)

    def area_ratios(self) -> FloatArray:
        """Logarithm of image area over source area of every face, each surface having area 1.

        Returns
        -------
        (m,) float64 array
            As from `igl_spheremap.area_distortion`.
        """
        return area_distortion(self.vertices, self.faces, self.sphere)

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
        return plot_run(self.history, None, self.angle_differences(), title=f"method {self.method}")

    def _repr_html_(self) -> str:
        """The figures as notebooks show them."""
        return table(result_rows(self))

    def __repr__(self) -> str:
        outcome = "folding-free" if self.certificate.folding_free else f"{self.certificate.foldings} foldings"
        return (f"SphereMap({len(self.vertices)} vertices, {len(self.faces)} faces, method={self.method!r}, {outcome}, "
                f"energy={self.energy:.6f}, {self.status.name}, {self.iterations} iterations, {self.seconds:.2f} s)")


def run_findings(result: SphereMap) -> list[Finding]:
    """How a map was made: the method's line, and the notes."""
    options = ", ".join(f"{key} = {value}" for key, value in result.settings.items() if key != "balance")
    made = "".join((result.method, f" ({options})" if options else "", f", {result.backend}" if result.backend else ""))
    text = f"{made}: {result.iterations} iterations, {result.seconds:.2f} s; {result.status.value}"
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
    return [*found, verdict(result.certificate)]


def result_rows(result: SphereMap) -> list[tuple[str, str]]:
    """All findings as labels and texts, the verdict first."""
    *known, certificate = map_findings(result)
    size = Finding("mesh", f"{len(result.vertices):,} vertices, {len(result.faces):,} faces", {})
    return [(found.label, found.text) for found in (certificate, size, *known, *run_findings(result))]


ROUNDS = ("round", "from", "folded faces", "iterations", "energy", "mean angle")


def round_rows(result: SphereMap) -> list[tuple[str, ...]]:
    """Figures of each round as texts, under the header `ROUNDS`."""
    return [
        (str(each.round), each.start, f"{each.foldings_before:,} -> {each.foldings_after:,}", f"{each.iterations:,}",
         f"{each.energy:.6f}", f"{each.mean_angle_difference:.3g}")
        for each in result.rounds
    ]
