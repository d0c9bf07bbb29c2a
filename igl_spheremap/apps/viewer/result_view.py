"""A finished map: the source beside the sphere."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from ...draw.folds import Clusters
from ...draw.palette import INK
from ...draw.plot import SIDES, fit, pose
from ...maps.given_sphere import sphere_map
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import Mesh
from ...mesh.measure import face_areas
from ...result import findings
from ...result.run import Listener, title_of
from ...sphere.moebius import moebius
from ...verify.distortion import angle_differences
from ...verify.signs import folded_faces
from .app import ColouredApp, Colours, SaveWidgets, lens_widgets, panel, paragraph, tip
from .background_run import BackgroundRun, Source
from .body import EDGE_WIDTH, Body, Lens, follow
from .choices import SUBJECTS
from .grid import PANEL, Grid, LensedSphere, packed
from .window import imgui, ps

#: Edges are drawn on images of at most this many faces; beyond they would be all that is seen.
_EDGES = 15_000
#: Moebius maps of more than this strength leave nothing to see.
_STRONGEST = 0.95
#: Radius of the handle of the Moebius map in pixels; a click moves the mouse by less.
_HANDLE = 9.0
#: The vertex that was picked, on both sides: magenta, which no scale has and which isn't the red of foldings.
_PICKED = (0.85, 0.0, 0.55)
#: Seconds of each frame that a window spends on a map that is being computed.
_POLL = 0.01


class ResultView(ColouredApp):
    """Source and sphere side by side, the sphere through a lens on the foldings if there are any.

    The frames are the `SUBJECTS` that colours can show. With a `result` there is a panel, whose slider goes on to
    maps of another balance; a Moebius map can follow the map, and a vertex be picked on either side. The lens is on the
    vertex that is picked, else on a cluster of folded faces.
    """

    def __init__(
        self,
        mesh: Mesh,
        x: FloatArray,
        caption: str = "map",
        *,
        up: str = "auto",
        subject: str = SUBJECTS[0],
        panel: bool = True,
        result: SphereMap | None = None,
        name: str = "sphere",
    ) -> None:
        self.mesh, self.subject, self.colours = mesh, subject, Colours(subject)
        self._up = up
        #: How much the lens magnifies; None: as fits what it is on.
        self.power: float | None = None
        self._cluster = 0
        #: How the grid was turned when the lens was aimed, which brings its place to the front.
        self._facing = np.eye(3)
        self.result = result
        self.picked: int | None = None
        self._balance = 0.0 if result is None else result.balance
        self._run: BackgroundRun | None = None
        self._held, self._moebius = False, False
        self._clicked = np.zeros(2)
        self._save = SaveWidgets(self, name, self._shown_map)
        self.grid = Grid(1, 2, panel=PANEL if panel and result is not None else 0)
        self.turn = pose(mesh.unit, up)
        self.source = self.grid.place(0, 0, Body("source", fit(mesh.unit, self.turn), mesh.f))
        self.sphere = LensedSphere(self.grid, 0, 1, mesh.f, x @ self.turn.T)
        for body in (self.source, self.sphere.body):
            body.mesh.set_selection_mode("vertices_only")
        self.source.caption = f"Source\n{len(mesh.v):,} vertices, {len(mesh.f):,} faces"
        self._show_map(x, caption)

    def _show_map(self, x: FloatArray, caption: str) -> None:
        """Show another map, with the lens that fits it."""
        self.map, self._caption, self.power = x, caption, None
        self._map_rows = [] if self.result is None else [
            (found.label, found.text)
            for found in (
                findings.verdict(self.result.certificate, self.mesh.caps),
                findings.angles(self.result.angle_differences()),
                findings.areas(self.result.log_area_ratios()),
            )
        ]
        self.move(np.zeros(3))

    def move(self, centre: FloatArray) -> None:
        """Follow the map by the Moebius map that takes `centre`, a point of the unit ball, to the middle."""
        self.centre = centre
        self.x = moebius(self.map, centre) if centre.any() else self.map
        self._clusters = Clusters.of(self.mesh.f, np.flatnonzero(folded_faces(self.x, self.mesh.f)))
        self._cluster = min(self._cluster, max(len(self._clusters) - 1, 0))
        self.show_subject(self.subject)

    def look(self, power: float | None = None, cluster: int | None = None) -> None:
        """Magnify by a power, None by what fits; on a cluster if it is given, and no longer on the vertex picked."""
        self.power, self._facing = power, self.grid.turn
        if cluster is not None:
            self._cluster = cluster
            self.picked = None
        self.show_subject(self.subject)

    def _aim(self, x: FloatArray) -> Lens:
        """The lens on a map as it is seen: on the vertex that is picked, else on folded faces, else on the front."""
        if self.picked is not None:
            faces = np.flatnonzero((self.mesh.f == self.picked).any(axis=1))
        else:
            faces = self._clusters[self._cluster] if self._clusters else np.empty(0, dtype=np.int64)
        (lens,) = follow([x], self.mesh.f, faces, power=self.power, facing=self._facing)
        if self.picked is not None:
            return replace(lens, place=x[self.picked])
        return lens if len(faces) else Lens(self._facing[2], self.power or 1.0, self._facing)

    def show_subject(self, subject: str) -> None:
        """Colour both by one of `SUBJECTS`, and apply the lens."""
        self.subject = self.colours.subject = subject
        folded, x = np.sort(self._clusters.faces), self.x @ self.turn.T
        colours = self.colours.of(self.mesh, self.x, folded)
        self.sphere.show(x, self._aim(x), colours, edge_width(self.mesh, subject))
        colours.apply(self.source, self.sphere.body)
        strength = float(np.linalg.norm(self.centre))
        moved = f"{self._caption}, then a Moebius map of strength {strength:.2f}" if strength else self._caption
        self.sphere.body.caption = f"{moved}\n{count_foldings(len(folded))}"
        self._mark(self.picked)

    def pick(self, vertex: int | None) -> None:
        """Mark a vertex on both sides; the lens follows it, as strong as it is. Without one, it is what fits again."""
        magnified = self.sphere.lens.power
        if vertex is not None:
            self.power = magnified
        elif self.picked is not None:
            self.power = None  # at the power of a limb's tip the rest of the sphere would be a speck
        self.picked, self._facing = vertex, self.grid.turn
        if magnified > 1:
            self.show_subject(self.subject)
        else:
            self._mark(vertex)

    def _mark(self, vertex: int | None) -> None:
        self._rows = self._map_rows if vertex is None else self.vertex_rows(vertex)
        rows = [] if vertex is None else [vertex]
        for body in (self.source, self.sphere.body):
            body.dots("picked", body.x[rows], _PICKED)

    def vertex_rows(self, vertex: int) -> list[tuple[str, str]]:
        """Figures of a vertex as labels and texts."""
        at = self.mesh.f == vertex
        around = at.any(axis=1)
        angles = np.abs(angle_differences(self.mesh.unit, self.mesh.f, self.x)[at])
        own, image = (face_areas(v, self.mesh.f) for v in (self.mesh.unit, self.x))
        ratio = image[around].sum() / image.sum() / (own[around].sum() / own.sum())
        return [
            ("vertex", f"{vertex:,} of {len(self.mesh.v):,}"),
            ("source", ", ".join(f"{c:.4g}" for c in self.mesh.v[vertex])),
            ("image", ", ".join(f"{c:.4f}" for c in self.x[vertex])),
            ("angle differences", f"{angles.mean():.3g} degrees on average, {angles.max():.3g} at most"),
            ("area ratio", f"its faces have {ratio:.3g} times their share of the area"),
        ]

    def rebalance(self, balance: float) -> None:
        """Go on to the map of another balance, which a process of its own computes; `tick` takes it over."""
        assert self.result is not None
        self.close()
        self._balance = balance
        load, solve = partial(_given, self.mesh.v, self.mesh.f), partial(_rebalanced, self.result, balance)
        self._run = BackgroundRun(load, solve)

    def prepare(self, listener: Listener | None = None) -> None:
        if self._run is not None:
            self._run.wait()
            self._take_map()

    def _take_map(self) -> None:
        if self._run is None:
            return
        self._run.poll(_POLL)
        if self._run.result is not None:
            self.result, self._run = self._run.result, None
            self._show_map(self.result.sphere, caption_of(self.result))
        elif self._run.error is not None:
            self.message, self._run = str(self._run.error), None

    def close(self) -> None:
        if self._run is not None:
            self._run.close()
            self._run = None

    def tick(self) -> None:
        self._take_map()
        if imgui.GetIO().WantCaptureMouse:
            return
        mouse = np.array(imgui.GetMousePos())
        if imgui.IsMouseClicked(0):
            self._clicked = mouse
            self._held = self._handle_is_shown() and bool(np.linalg.norm(mouse - self.handle()) < 2 * _HANDLE)
        if imgui.IsMouseReleased(0):
            if not self._held and np.linalg.norm(mouse - self._clicked) < _HANDLE / 2:
                self.pick_at(mouse)
            self._held = False
        self.grid.locked = self._held
        if self._held and imgui.IsMouseDragging(0, 0.0):
            self.drag_to(mouse)

    def pick_at(self, pixel: FloatArray) -> None:
        """Pick the vertex that is seen at a pixel, on either side; none where there is none."""
        hit = ps.pick(screen_coords=tuple(pixel))
        seen = hit.is_hit and hit.structure_name in (self.source.name, self.sphere.body.name)
        self.pick(int(hit.structure_data["index"]) if seen else None)

    def _handle_is_shown(self) -> bool:
        return bool(self.grid.panel) and self._moebius and self.sphere.lens.power <= 1

    def handle(self) -> FloatArray:
        """Where the handle of the Moebius map is, in pixels."""
        return self.grid.pixels(self.grid.frame((0, 1)), self.turn @ self.centre)

    def drag_to(self, mouse: FloatArray) -> None:
        """Put the handle under the mouse, as deep in the ball as it was."""
        centre = self.turn.T @ self.grid.from_pixels(0, 1, mouse, self.turn @ self.centre)
        self.move(centre * min(1.0, _STRONGEST / max(float(np.linalg.norm(centre)), 1e-12)))

    def panel(self) -> None:
        self.sphere.annotate()
        if not self.grid.panel:
            return
        assert self.result is not None
        canvas = imgui.GetForegroundDrawList()
        if self._handle_is_shown():
            canvas.AddCircleFilled(tuple(self.handle()), _HANDLE, packed((1.0, 1.0, 1.0)))
            canvas.AddCircle(tuple(self.handle()), _HANDLE, packed(INK), 0, 2.0)
        if self.picked is not None:  # a ring is seen on the far side, too
            for column, body in enumerate((self.source, self.sphere.body)):
                place = self.grid.pixels(self.grid.frame((0, column)), body.x[self.picked])
                canvas.AddCircle(tuple(place), _HANDLE, packed(_PICKED), 0, 2.0)
        with panel("Map", self.grid.panel):
            self._balance_slider()
            self._view_widgets()
            self._save()
            imgui.Separator()
            self._moebius_widgets()
            imgui.Separator()
            for line in filter(None, (self.message, *(f"{label}: {text}" for label, text in self._rows))):
                paragraph(line)
            imgui.Separator()
            paragraph("Click a vertex to see its image and its figures, and beside it to forget it. Drag to turn both, "
                      "drag with the right button to shift, scroll to zoom, double-click to reset.")

    def _balance_slider(self) -> None:
        assert self.result is not None
        imgui.BeginDisabled(not self.result.certificate.folding_free)
        _, self._balance = imgui.SliderFloat("balance", self._balance, 0.0, 1.0, "%.2f")
        if imgui.IsItemDeactivatedAfterEdit():
            self.rebalance(min(max(self._balance, 0.0), 1.0))
        imgui.EndDisabled()
        tip("0 keeps angles, 1 keeps areas. Maps that fold have none.")
        said = "0 keeps angles, 1 keeps areas"
        if self._run is not None:
            said = title_of(self._run.frames[-1].iterate) if len(self._run.frames) > 1 else "starting"
        imgui.BeginDisabled(self._run is None)
        if imgui.Button("stop"):
            self.close()
        imgui.EndDisabled()
        imgui.SameLine()
        imgui.TextUnformatted(said)

    def _view_widgets(self) -> None:
        if self.colours.widgets():
            self.show_subject(self.colours.subject)
        self._side_buttons()
        if chosen := lens_widgets(self.sphere.lens.power, self._clusters.sizes, self._cluster):
            self.look(*chosen)

    def _side_buttons(self) -> None:
        """Show the outer or the inner side of half a brain."""
        if self._up not in SIDES:
            return
        for name, angle in (("lateral", 0.0), ("medial", np.pi)):
            if imgui.Button(name):
                self.grid.turn = np.eye(3)
                self.grid.rotate(angle, 0.0)
            imgui.SameLine()
        imgui.TextUnformatted("side")

    def _moebius_widgets(self) -> None:
        """The Moebius map: its handle, how far it is moved, and back."""
        self._moebius = bool(imgui.TreeNode("Moebius map"))
        if not self._moebius:
            return
        strength = float(np.linalg.norm(self.centre))
        ahead = self.centre / strength if strength else np.array([0.0, 0.0, 1.0])
        moved, strength = imgui.SliderFloat("strength", strength, 0.0, _STRONGEST)
        if moved:
            self.move(max(strength, 1e-3) * ahead)
        if imgui.Button("reset"):
            self.move(np.zeros(3))
        paragraph("Drag the white handle: what is under it grows.")
        imgui.TreePop()

    def _shown_map(self) -> SphereMap | None:
        """What the button writes: the map after the Moebius map, if there is one."""
        return sphere_map(self.mesh.v, self.mesh.f, self.x) if self.centre.any() else self.result


def _given(v: FloatArray, f: IntArray) -> Source:
    return v, f


def _rebalanced(result: SphereMap, balance: float, v: FloatArray, f: IntArray, *, listener: Listener) -> SphereMap:
    """What a process computes while the window stays alive; v and f are those of the result."""
    return result.rebalance(balance, listener=listener)


def edge_width(mesh: Mesh, subject: str) -> float:
    """Width of the edges on images; 0 where there are too many, or where they would hide a scale of colours."""
    return EDGE_WIDTH if subject == SUBJECTS[0] and len(mesh.f) <= _EDGES else 0.0


def count_foldings(count: int) -> str:
    """A caption.

    >>> count_foldings(1), count_foldings(1200)
    ('1 folded face', '1,200 folded faces')
    """
    return f"{count:,} folded face{'s' * (count != 1)}"


def caption_of(result: SphereMap) -> str:
    """How a map was made."""
    balance = f", balance {result.balance:g}" if result.balance else ""
    return f"map ({result.method}{balance})"
