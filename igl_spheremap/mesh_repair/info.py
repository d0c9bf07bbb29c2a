"""Description of a mesh before it is mapped: its parts and figures, why it can't be mapped, and the effect of a
repair."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError, Remedy
from ..gate import takes_mesh
from ..mesh.arrays import check_rows, listed_words, plural
from ..mesh.check import check_mesh
from ..mesh.disk import check_disk
from ..operators.laplacian import build_operators
from ..result.findings import Finding
from .polygons import triangulated
from .quality import MeshQuality, mesh_quality
from .repair_mesh import repair_mesh
from .topology import Topology, topology_of, usable_faces


@dataclass(frozen=True)
class MeshInfo:
    """Findings of `info` on a mesh; ``print`` shows them as the command line does.

    Attributes
    ----------
    vertices, faces : int
        Their numbers.
    not_finite : int
        Vertices with a NaN or infinite coordinate; their faces are in no figure of `quality`.
    topology : Topology
        Components with their boundary loops and handles, and faults of the lists.
    quality : MeshQuality or None
        Sizes, angles and coincident vertices; None if no face can be measured.
    maps_to : {"sphere", "plane"} or None
        Target of its maps as it is: the sphere, the plane (`disk_conformal_map`, `flatten`), or nothing.
    error : str or None
        Why it can't be mapped to the sphere.
    repair : dict or None
        Options with which `repair_mesh` makes a mesh of it that can be; None if it can't, or need not.
    actions : tuple of str
        The actions of that repair.
    weights : str or None
        Of the Laplacian, if the mesh can be mapped to the sphere: "cotangent", or their substitute.
    notes : tuple of str
        Why these are not the first choice.
    """

    vertices: int
    faces: int
    not_finite: int
    topology: Topology
    quality: MeshQuality | None
    maps_to: str | None
    error: str | None
    repair: Mapping[str, Any] | None
    actions: tuple[str, ...]
    weights: str | None
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        return f"MeshInfo({self.vertices} vertices, {self.faces} faces, maps_to={self.maps_to!r})"

    def __str__(self) -> str:
        return "\n".join(f"{row.label:<13}{row.text}" for row in mesh_findings(self))


@takes_mesh
def info(v: ArrayLike, f: ArrayLike) -> MeshInfo:
    """Measure any triangles: their topology, whether they can be mapped, and the effect of `repair_mesh`.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions, any units, finite or not.
    f : (m, 3) array_like
        Faces as 0-based vertex indices, in range or not; or polygons as of `repair_mesh`.

    Returns
    -------
    MeshInfo
        The report that ``igl-spheremap info`` prints.

    Raises
    ------
    MeshError
        If the arrays are not of that shape, or there are no faces.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.sphere(42)
    >>> found = ism.info(v, f[1:])
    >>> found.topology.components
    (Component(vertices=42, faces=79, boundary_loops=(3,), handles=0, part=None),)
    >>> found.maps_to, found.repair
    ('plane', {'holes': 'fill'})
    """
    vertices = check_rows(v, name="vertices")
    faces = triangulated(vertices, f)[0]
    finite = np.asarray(np.isfinite(vertices).all(axis=1))
    measured = faces[usable_faces(faces, len(vertices))[1]]
    measured = measured[np.all(finite[measured], axis=1)]
    used, numbered = np.unique(measured, return_inverse=True)
    quality: MeshQuality | None = None
    if len(used):
        quality = mesh_quality(vertices[used], numbered.reshape(-1, 3))
    topology = topology_of(faces, len(vertices))
    maps_to: str | None = None
    error: str | None = None
    weights: str | None = None
    repair: Mapping[str, Any] | None = {}
    notes: tuple[str, ...] = ()
    actions: tuple[str, ...] = ()
    try:
        operators = build_operators(check_mesh(vertices, faces))
        maps_to, weights, notes = "sphere", operators.weights, operators.notes
    except MeshError as fault:
        error, repair = str(fault), None
        if fault.remedy is not None:
            repair = fault.remedy.options
        with suppress(MeshError):
            check_disk(vertices, faces)
            maps_to = "plane"
    if repair is not None:
        try:
            actions = repair_mesh(vertices, faces, **repair).actions
        except MeshError:
            repair = None
    if not actions:
        repair = None
    return MeshInfo(
        len(vertices), len(faces), int((~finite).sum()), topology, quality, maps_to, error, repair,
        actions, weights, notes,
    )  # fmt: skip


def mesh_findings(found: MeshInfo) -> list[Finding]:
    """The sentences of a summary, and the numbers behind them."""
    numbers = {key: value for key, value in vars(found).items() if key not in _RECORDS}
    numbers |= asdict(found.topology)
    if found.quality:
        numbers |= asdict(found.quality)
    size = f"{_vertices(found.vertices)}, {plural(found.faces, 'face')}"
    rows = [
        Finding("mesh", size, numbers),
        _text("topology", _VERDICTS.get(found.maps_to, f"{_NO_MAP}{found.error}")),
        *_parts(found.topology),
    ]
    if found.not_finite:
        rows.append(_text("not finite", f"{_vertices(found.not_finite)}, which figures leave out"))
    if found.quality:
        rows += _figures(found.quality, found.topology.edges)
    rows += [_text("note", note) for note in found.notes]
    if found.repair is not None:
        repair = Remedy("repair_mesh", found.repair)
        rows.append(_text("repair", f"{repair} would do this: {'; '.join(found.actions)}"))
    elif found.error is not None:
        rows.append(_text("repair", "no repair makes it a closed surface of genus 0"))
    return rows


#: The fields of `MeshInfo` whose own fields are listed.
_RECORDS = ("topology", "quality")
_VERDICTS: dict[str | None, str] = {
    "sphere": "closed, oriented, connected, genus 0: it can be mapped to the sphere",
    "plane": "oriented, connected, one boundary loop, no handle: a disk, which can be mapped to the plane",
}
_NO_MAP = "it can't be mapped as it is: "
#: Faults of the lists: the fields of `Topology`, and the things counted.
_FAULTS = (
    ("nonmanifold_edges", "edge of more than two faces", "edges of more than two faces"),
    ("nonmanifold_vertices", "vertex where sheets touch", "vertices where sheets touch"),
    (
        "reversed_edges",
        "edge along which both faces run in the same direction",
        "edges along which both faces run in the same direction",
    ),
    ("out_of_range", "face with an index out of range", "faces with an index out of range"),
    ("repeated_indices", "face with a repeated index", "faces with a repeated index"),
    ("copies", "copy of another face", "copies of other faces"),
    ("unreferenced", "vertex in no face", "vertices in no face"),
)


def _parts(topology: Topology, described: int = 5) -> list[Finding]:
    """Components, the first of them one by one, and faults of the lists."""
    several = len(topology.components) > 1
    found = []
    for part in topology.components[:described]:
        label = "surface"
        if several and part.part is None:
            label = "open part"
        elif several:
            label = f"part {part.part}"
        rim, handles = "closed", "not orientable"
        if part.boundary_loops:
            loops = plural(len(part.boundary_loops), "boundary loop")
            rim = f"{loops} of {listed_words(part.boundary_loops)} edges"
        if part.handles is not None:
            handles = plural(part.handles, "handle")
        size = f"{_vertices(part.vertices)}, {plural(part.faces, 'face')}"
        found.append(_text(label, f"{size}, {rim}, {handles}"))
    more = topology.components[described:]
    if more:
        largest = plural(more[0].faces, "face")
        found.append(_text("", f"and {plural(len(more), 'more part')}, of at most {largest}"))
    counts = [(getattr(topology, name), one, several_) for name, one, several_ in _FAULTS]
    faults = [plural(*each) for each in counts if each[0]]
    if faults:
        found.append(_text("faults", "; ".join(faults)))
    return found


def _figures(quality: MeshQuality, edges: int) -> list[Finding]:
    """Sizes, edges, angles and weights."""
    size = " x ".join(f"{side:.4g}" for side in quality.extent) + f", area {quality.area:.4g}"
    if np.isfinite(quality.volume):
        size += f", volume {abs(quality.volume):.4g}"
        if quality.volume < 0:
            size += " (oriented inwards)"
    return [
        _text("size", size),
        _text(
            "edges",
            f"{edges}, {quality.shortest_edge:.3g} to {quality.longest_edge:.3g} long, mean "
            f"{quality.mean_edge:.3g}; at most {quality.largest_valence} at a vertex",
        ),
        _text(
            "angles",
            f"{quality.smallest_angle:.3g} to {quality.largest_angle:.4g} degrees; "
            f"{plural(quality.slivers, 'sliver')} below 1 degree, "
            f"{plural(quality.zero_area_faces, 'face')} of zero area",
        ),
        _text(
            "vertices",
            f"{quality.coincident_vertices} at the place of another one, {quality.near_vertices} more "
            "within a millionth of the size of the mesh",
        ),
        _text(
            "weights",
            f"{quality.non_delaunay_edges} of {edges} edges are not Delaunay: negative weights there",
        ),
    ]


def _text(label: str, text: str) -> Finding:
    """A sentence without numbers of its own."""
    return Finding(label, text, {})


def _vertices(number: int) -> str:
    return plural(number, "vertex", "vertices")
