"""Repair of input meshes, on request only: faults of the lists first, then holes and handles."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

from numpy.typing import ArrayLike

from ..errors import MeshError, Remedy, check_number, within
from ..gate import takes_mesh
from ..mesh.arrays import BoolArray, FloatArray, IntArray, check_rows, check_triangles
from ..mesh.check import check_mesh, check_positions, checked
from . import LARGEST_WELD
from .refusal import repair_by
from .surface import Surface


@dataclass(frozen=True, eq=False)
class RepairedMesh:
    """A closed, outward oriented genus-0 mesh, or a disk, and what its rows were in the input. Unpacks to ``v, f``.

    Attributes
    ----------
    v : (n, 3) float64 array
        Vertices, rows of the input and new ones.
    f : (m, 3) int64 array
        Faces.
    vertex_source : (n,) int64 array
        Row of the input that each vertex comes from, -1 for the new vertices of caps.
    face_source : (m,) int64 array
        Row of the input that each face comes from, -1 for the faces of caps.
    vertex_image : (n_input,) int64 array
        Vertex that each row of the input became, -1 for those that were dropped. Where a row became several vertices
        (sheets that touched, a cut), the first of them.
    actions : tuple of str
        What was done, a phrase each; empty for a mesh that was sound.
    """

    v: FloatArray
    f: IntArray
    vertex_source: IntArray
    face_source: IntArray
    vertex_image: IntArray
    actions: tuple[str, ...]

    @property
    def caps(self) -> BoolArray | None:
        """The faces that are caps, (m,); None if there are none."""
        return self.face_source < 0 if (self.face_source < 0).any() else None

    def __iter__(self) -> Iterator[Any]:
        return iter((self.v, self.f))

    def __repr__(self) -> str:
        return f"RepairedMesh({len(self.v)} vertices, {len(self.f)} faces; {'; '.join(self.actions) or 'nothing done'})"


def asked_for(function: str, weld: float, keep_largest: bool, holes: str, handles: str) -> Remedy:
    """The repair with these options, which are checked."""
    for name, value, choices in (
        ("holes", holes, ("refuse", "fill")),
        ("handles", handles, ("refuse", "cut")),
    ):
        if value not in choices:
            raise ValueError(f"{name} is {value!r}; give {' or '.join(map(repr, choices))}")
    check_number(weld, "weld", most=LARGEST_WELD)
    return repair_by(
        function,
        weld=weld,
        keep_largest=keep_largest,
        holes=holes == "fill" and holes,
        handles=handles == "cut" and handles,
    )


@takes_mesh
def repair_mesh(
    v: ArrayLike,
    f: ArrayLike,
    *,
    weld: float = 0.0,
    keep_largest: bool = False,
    holes: Literal["refuse", "fill"] = "refuse",
    handles: Literal["refuse", "cut"] = "refuse",
) -> RepairedMesh:
    """Repair what keeps a surface from being a closed, oriented genus-0 mesh.

    Welds vertices along open edges that coincide, drops faces with a repeated index, surplus copies of faces and
    unreferenced vertices, makes the orientation consistent and outward, and separates sheets that touch at a
    vertex or meet in edges of an even number of faces. At such an edge each sheet keeps its own two faces; one that
    touches itself is separated by the angles of its faces. Coincident vertices elsewhere are left alone: thin sheets
    have them. New vertices and faces, which close holes and handles, are made on request only.

    Parameters
    ----------
    v, f : (n, 3) and (m, 3) array_like
        Positions and faces as of `check_mesh`, whose faults are to be repaired.
    weld : float
        Vertices along open edges are welded up to this distance, a share of the diagonal of the bounding box, at most
        .01; the first of each group gives its place. By default only those at the same place are.
    keep_largest : bool
        Keep the component with the most faces and drop the others; by default several are refused.
    holes : {"refuse", "fill"}
        "fill" closes each hole by a cap: rings of triangles that first continue the surface, then grow towards a
        centre. By default holes are refused.
    handles : {"refuse", "cut"}
        "cut" cuts each handle along a short loop, around it or through it, whichever is shorter, and fills both sides
        by caps, after the holes. Caps may run through the body: maps are as good. By default handles are refused.

    Returns
    -------
    RepairedMesh
        The mesh, index maps to the input and what was done. Maps take ``caps=mesh.face_source < 0``.

    Raises
    ------
    MeshError
        If that is not enough: holes and handles that are refused, surplus sheets, several components, NaN.
    ValueError
        If `holes` or `handles` is another word, or `weld` is out of range.

    See Also
    --------
    info : says what a repair would do.
    repair_disk : keeps one boundary loop.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1], [9, 9, 9]]
    >>> ism.repair_mesh(v, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 2, 3]]).actions
    ('dropped 1 unreferenced vertex', 'reversed 1 face to agree with neighbours')
    >>> ism.repair_mesh(v[:4], [[0, 1, 2], [0, 2, 3], [0, 3, 1]], holes="fill").actions
    ('filled 1 hole (3 edges) near (-0.333, -0.333, -0.333)',)
    """
    asked = asked_for("repair_mesh", weld, keep_largest, holes, handles)
    vertices, faces = check_rows(v, name="vertices"), check_triangles(f)
    low, high = int(faces.min()), int(faces.max())
    if low < 0 or high >= len(vertices):
        check_mesh(vertices, faces)  # raises
    work = Surface(vertices, faces)
    parts = work.clean(keep_largest, weld)
    try:
        if not work.sound or not len(work.f) or (work.rims and holes == "refuse"):
            checked(work.v, work.f, None, asked)  # raises
        check_positions(work.v)
        work.fill_holes()
        if handles == "cut" and (keep_largest or parts == 1):
            work.cut_handles()
        work.turn_outward()
        checked(work.v, work.f, None, asked)
    except MeshError as error:
        done = "; ".join(work.actions) or "nothing"
        raise within(error, f"repair (done: {done}) is not enough: ") from None
    return RepairedMesh(
        work.v, work.f, work.vertex_source, work.face_source, work.image, tuple(work.actions)
    )
