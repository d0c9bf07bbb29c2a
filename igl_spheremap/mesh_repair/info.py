"""What a mesh is before it is mapped: its parts and figures, why it can't be mapped, and what its repair would do."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..errors import MeshError, Remedy
from ..gate import takes_mesh
from ..mesh.arrays import check_rows, check_triangles, listed_words
from ..mesh.check import check_mesh
from ..mesh.disk import check_disk
from ..operators.laplacian import build_operators
from ..result.findings import Finding
from .quality import MeshQuality, mesh_quality
from .repair_mesh import repair_mesh
from .topology import Topology, topology_of, usable_faces

#: Components that a sentence describes one by one.
_DESCRIBED = 5


@dataclass(frozen=True)
class MeshInfo:
    """What `info` finds out about a mesh; ``print`` shows what the command line does.

    Attributes
    ----------
    vertices, faces : int
        Their numbers.
    not_finite : int
        Vertices with a NaN or infinite coordinate; their faces are in no figure of `quality`.
    topology : Topology
        Components with their boundary loops and handles, and faults of the lists.
    quality : MeshQuality or None
        Sizes, angles and coincident vertices; None where no face can be measured.
    maps_to : {"sphere", "plane"} or None
        What the mesh can be mapped to as it is: the sphere, the plane (`disk_conformal_map`, `flatten`), or nothing.
    error : str or None
        Why it can't be mapped to the sphere.
    repair : dict or None
        Options with which `repair_mesh` makes a mesh of it that can be; None where it can't, or nothing is to be done.
    actions : tuple of str
        What that repair does.
    weights : str or None
        Of the Laplacian, where the mesh can be mapped to the sphere: "cotangent", or what takes their place.
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
    """Measure any triangles: what they are, whether they can be mapped, and what `repair_mesh` would do.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions, any units, finite or not.
    f : (m, 3) array_like
        Faces as 0-based vertex indices, in range or not.

    Returns
    -------
    MeshInfo
        What ``igl-spheremap info`` prints.

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
    (Component(vertices=42, faces=79, boundary_loops=(3,), handles=0),)
    >>> found.maps_to, found.repair
    ('plane', {'holes': 'fill'})
    """
    vertices, faces = check_rows(v, name="vertices"), check_triangles(f)
    finite = np.asarray(np.isfinite(vertices).all(axis=1))
    measured = faces[usable_faces(faces, len(vertices))[1]]
    measured = measured[np.all(finite[measured], axis=1)]
    used, numbered = np.unique(measured, return_inverse=True)
    quality = mesh_quality(vertices[used], numbered.reshape(-1, 3)) if len(used) else None
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
        error, repair = str(fault), None if fault.remedy is None else fault.remedy.options
        with suppress(MeshError):
            check_disk(vertices, faces)
            maps_to = "plane"
    if repair is not None:
        try:
            actions = repair_mesh(vertices, faces, **repair).actions
        except MeshError:
            repair = None
    return MeshInfo(
        len(vertices),
        len(faces),
        int((~finite).sum()),
        topology,
        quality,
        maps_to,
        error,
        repair if actions else None,
        actions,
        weights,
        notes,
    )


def mesh_findings(found: MeshInfo) -> list[Finding]:
    """The sentences of a summary, and the numbers behind them."""
    known = {
        name: value for name, value in vars(found).items() if name not in ("topology", "quality")
    }
    quality = asdict(found.quality) if found.quality else {}
    verdict = {
        "sphere": "closed, oriented, connected, genus 0: it can be mapped to the sphere",
        "plane": "oriented, connected, one boundary loop, no handle: a disk, which can be mapped to the plane",
        None: f"it can't be mapped as it is: {found.error}",
    }
    rows = [
        Finding(
            "mesh",
            f"{_vertices(found.vertices)}, {_faces(found.faces)}",
            {**known, **asdict(found.topology), **quality},
        ),
        Finding("topology", verdict[found.maps_to], {}),
        *_parts(found.topology),
    ]
    if found.not_finite:
        rows.append(
            Finding("not finite", f"{_vertices(found.not_finite)}, which figures leave out", {})
        )
    if found.quality:
        rows += _figures(found.quality, found.topology.edges)
    rows += [Finding("note", note, {}) for note in found.notes]
    if found.repair is not None:
        repair = Remedy("repair_mesh", found.repair)
        rows.append(Finding("repair", f"{repair} would do this: {'; '.join(found.actions)}", {}))
    elif found.error is not None:
        rows.append(Finding("repair", "no repair makes it a closed surface of genus 0", {}))
    return rows


def _parts(topology: Topology) -> list[Finding]:
    """Components, and what is wrong with the lists."""
    several = len(topology.components) > 1
    found = []
    for k, part in enumerate(topology.components[:_DESCRIBED]):
        loops = part.boundary_loops
        rim = (
            f"{_counted(len(loops), 'boundary loop')} of {listed_words(loops)} edges"
            if loops
            else "closed"
        )
        handles = "not orientable" if part.handles is None else _counted(part.handles, "handle")
        text = f"{_vertices(part.vertices)}, {_faces(part.faces)}, {rim}, {handles}"
        found.append(Finding(f"part {k + 1}" if several else "surface", text, {}))
    more = topology.components[_DESCRIBED:]
    if more:
        found.append(
            Finding(
                "",
                f"and {_counted(len(more), 'more part')}, of at most {_faces(more[0].faces)}",
                {},
            )
        )
    faults = [
        _counted(number, name, plural)
        for number, name, plural in (
            (
                topology.nonmanifold_edges,
                "edge of more than two faces",
                "edges of more than two faces",
            ),
            (
                topology.nonmanifold_vertices,
                "vertex where sheets touch",
                "vertices where sheets touch",
            ),
            (
                topology.reversed_edges,
                "edge along which both faces run in the same direction",
                "edges along which both faces run in the same direction",
            ),
            (
                topology.out_of_range,
                "face with an index out of range",
                "faces with an index out of range",
            ),
            (
                topology.repeated_indices,
                "face with a repeated index",
                "faces with a repeated index",
            ),
            (topology.copies, "copy of another face", "copies of other faces"),
            (topology.unreferenced, "vertex in no face", "vertices in no face"),
        )
        if number
    ]
    if faults:
        found.append(Finding("faults", "; ".join(faults), {}))
    return found


def _figures(quality: MeshQuality, edges: int) -> list[Finding]:
    """Sizes, edges, angles and weights."""
    volume = (
        f", volume {abs(quality.volume):.4g}{' (oriented inwards)' * (quality.volume < 0)}"
        if np.isfinite(quality.volume)
        else ""
    )
    return [
        Finding(
            "size",
            f"{' x '.join(f'{side:.4g}' for side in quality.extent)}, area {quality.area:.4g}{volume}",
            {},
        ),
        Finding(
            "edges",
            f"{edges}, {quality.shortest_edge:.3g} to {quality.longest_edge:.3g} long, mean "
            f"{quality.mean_edge:.3g}; at most {quality.largest_valence} at a vertex",
            {},
        ),
        Finding(
            "angles",
            f"{quality.smallest_angle:.3g} to {quality.largest_angle:.4g} degrees; "
            f"{_counted(quality.slivers, 'sliver')} below 1 degree, {_faces(quality.zero_area_faces)} of zero area",
            {},
        ),
        Finding(
            "vertices",
            f"{quality.coincident_vertices} at the place of another one, {quality.near_vertices} more "
            "within a millionth of the size of the mesh",
            {},
        ),
        Finding(
            "weights",
            f"{quality.non_delaunay_edges} of {edges} edges are not Delaunay: negative weights there",
            {},
        ),
    ]


def _counted(number: int, name: str, plural: str | None = None) -> str:
    return f"{number or 'no'} {name if number == 1 else plural or name + 's'}"


def _vertices(number: int) -> str:
    return _counted(number, "vertex", "vertices")


def _faces(number: int) -> str:
    return _counted(number, "face")
