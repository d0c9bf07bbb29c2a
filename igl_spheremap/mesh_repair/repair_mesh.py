"""Repair of input meshes, on request only: faults of the lists first, then holes and handles."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

from numpy.typing import ArrayLike

from ..errors import MeshError, Remedy, check_number, within
from ..gate import takes_mesh
from ..mesh.arrays import BoolArray, FloatArray, IntArray, check_rows
from ..mesh.check import check_indices, checked
from . import LARGEST_WELD, REPAIRS
from .polygons import triangulated
from .refusal import Refusal, repair_by
from .surface import Surface


@dataclass(frozen=True, eq=False)
class RepairedMesh:
    """A closed, outward oriented genus-0 mesh, or a disk, with its rows in the input. Unpacks to ``v, f``.

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
        Vertex that each row of the input became, -1 for those that were dropped. If a row became several vertices
        (sheets that touched, a cut), the first of them.
    actions : tuple of str
        The repairs, a phrase each; empty for a sound mesh.
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
        caps = self.face_source < 0
        if not caps.any():
            return None
        return caps

    def __iter__(self) -> Iterator[Any]:
        return iter((self.v, self.f))

    def __repr__(self) -> str:
        done = "nothing done"
        if self.actions:
            done = "; ".join(self.actions)
        return f"RepairedMesh({len(self.v)} vertices, {len(self.f)} faces; {done})"


def asked_for(function: str, **options: Any) -> Remedy:
    """The repair with these options, which are checked."""
    for name, word in (("holes", "fill"), ("handles", "cut")):
        if options[name] not in ("refuse", word):
            raise ValueError(f"{name} is {options[name]!r}; give 'refuse' or '{word}'")
    check_number(options["weld"], "weld", most=LARGEST_WELD)
    return repair_by(function, options)


def repaired(
    v: FloatArray,
    f: ArrayLike,
    asked: Remedy,
    steps: Callable[[Surface], None],
    check: Callable[..., object],
) -> RepairedMesh:
    """Repair all that needs no new geometry, then take further steps, and check the result.

    Errors list the repairs done by then, and suggest calls with the options `asked` of this one.
    """
    options: dict[str, Any] = REPAIRS | dict(asked.options)
    closed = asked.function == "repair_mesh"
    work = Surface(v, *triangulated(v, f), closed=closed)
    check_indices(work.f, len(v))
    try:
        work.clean(options["keep_largest"], options["weld"])
        if closed and not len(work.f):
            raise MeshError("no face is left; give a closed triangle mesh")
        if work.sound and (options["keep_largest"] or work.parts == 1):
            steps(work)
        check(work.f, work.v, partial(Refusal, asked=asked, work=work))
    except MeshError as error:
        if work.actions:
            error = within(error, f"repair (done: {'; '.join(work.actions)}) is not enough: ")
        raise error from None
    return RepairedMesh(
        work.v, work.f, work.vertex_source, work.face_source, work.image, tuple(work.actions)
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
    """Repair faults that keep a surface from being a closed, oriented genus-0 mesh.

    Cuts polygons into triangles in their planes, welds vertices along open edges that coincide, and splits faces on
    whose open edges other vertices lie (T-junctions). Drops faces with a repeated index, surplus copies of faces,
    vertices with NaN and the faces at them, and unreferenced vertices. Makes the orientation consistent and outward.
    Separates sheets that touch at a vertex or meet in an edge: each keeps its own two faces there, and the angles of
    its faces separate one that touches itself. Faces without a partner at an edge are dropped. Coincident vertices
    elsewhere are left alone: thin sheets have them. New vertices and faces, which close holes and handles, are made on
    request only.

    Parameters
    ----------
    v : (n, 3) array_like
        Positions as of `check_mesh`, any units.
    f : (m, 3) array_like
        Faces as of `check_mesh`, or polygons: (m, k) indices, or PyVista's row with each face's number of corners.
    weld : float
        Vertices along open edges are welded up to this distance, a share of the diagonal of the bounding box, at most
        .01, and lie on open edges up to it. The first of each group gives its place. By default only those at the same
        place are.
    keep_largest : bool
        Keep the largest component and drop the others, whose share of the area `actions` say; by default several are
        refused. The largest is the one of most volume, or, if none is closed, of most area.
    holes : {"refuse", "fill"}
        "fill" closes each hole by a cap: rings of triangles that first continue the surface, then grow towards a
        centre. By default holes are refused.
    handles : {"refuse", "cut"}
        "cut" cuts each handle along a short loop, around it or through it, whichever is shorter, and fills both sides
        by caps, after the holes. Caps may run through the body: maps are as good. By default handles are refused.

    Returns
    -------
    RepairedMesh
        The mesh, index maps to the input and the actions. Maps take ``caps=mesh.face_source < 0``.

    Raises
    ------
    MeshError
        If the repair does not suffice: holes, handles or several components that are refused, or no orientation.
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
    ('reversed 1 face to agree with neighbours', 'dropped 1 unreferenced vertex')
    >>> ism.repair_mesh(v[:4], [[0, 1, 2], [0, 2, 3], [0, 3, 1]], holes="fill").actions
    ('filled 1 hole (3 edges) near (-0.333, -0.333, -0.333)',)
    """

    def steps(work: Surface) -> None:
        if holes == "fill":
            work.fill_holes()
        if not work.rims:
            if handles == "cut":
                work.cut_handles()
            work.turn_outward()

    asked = asked_for(
        "repair_mesh", weld=weld, keep_largest=keep_largest, holes=holes, handles=handles
    )
    return repaired(
        check_rows(v, name="vertices"),
        f,
        asked,
        steps,
        lambda f, v, refusal: checked(v, f, None, refusal),
    )
