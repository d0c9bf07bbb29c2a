"""Maps of a surface: the surface beside its image, or above several images, to be compared."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import numpy as np

from ...draw.plot import fit, pose
from ...maps.sphere_map import SphereMap
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import Mesh
from ...mesh.measure import face_areas
from ...result import findings
from ...result.run import Listener, title_of
from ...verify.distortion import angle_differences
from ...verify.signs import folded_faces
from .app import ColouredApp, SaveWidgets
from .background_run import ShownRun, Source
from .body import EDGE_WIDTH
from .choices import SUBJECTS
from .colouring import Colours, Legend
from .grid import MOUSE, Grid, Part
from .lens_view import LensView
from .widgets import panel, paragraph
from .window import imgui


class MapView(ColouredApp, LensView):
    """Maps (n, 3) of a surface by their captions, through one lens on foldings, or on the vertex that is picked.

    The frames are the `SUBJECTS` that colours can show. Several maps stand in columns, whose scale fits the best of
    them. With a `result` a slider goes on to maps of another balance.
    """

    def __init__(
        self,
        mesh: Mesh,
        maps: Mapping[str, FloatArray],
        *,
        up: str = "auto",
        subject: str = SUBJECTS[0],
        result: SphereMap | None = None,
        name: str = "map",
    ) -> None:
        self.mesh, self.subject, self.colours = mesh, subject, Colours(subject)
        self.turn = pose(mesh.unit, up)
        self._source = fit(mesh.unit, self.turn)
        if len(maps) > 1:
            self.power = 1.0
        self.result = result
        self._balance = 0.0
        if result is not None:
            self._balance = result.balance
        self._run: ShownRun | None = None
        self._save = SaveWidgets(self, name, None if result is None else lambda: self.result)
        self.grid = Grid()
        self.leave_lens()
        self._show_maps(maps)

    def _show_maps(self, maps: Mapping[str, FloatArray]) -> None:
        """Show other maps, with the lens on the clusters of the one with the fewest foldings."""
        self.maps, mesh = maps, self.mesh
        self._turned = [x @ self.turn.T for x in maps.values()]
        self._folded = [np.flatnonzero(folded_faces(x, mesh.f)) for x in maps.values()]
        self._angles = [
            float(np.abs(angle_differences(mesh.unit, mesh.f, x)[mesh.surface]).mean())
            for x in maps.values()
        ]
        #: The map that the lens is to fit: the one with the fewest foldings.
        self._aim = min(range(len(maps)), key=lambda k: len(self._folded[k]) or np.inf)
        self.find_clusters(mesh.f, self._folded[self._aim])
        #: Figures of the result, for the panel.
        self._facts: list[str] = []
        if self.result is not None:
            found = (
                findings.verdict(self.result.certificate, mesh.caps),
                findings.angles(self.result.angle_differences()),
                findings.areas(self.result.log_area_ratios()),
            )
            self._facts = [f"{one.label}: {one.text}" for one in found]
        self.refresh()

    def refresh(self) -> None:
        """Show the maps through the present lens, and figures of the vertex picked, or else of the result."""
        self.lines = self._facts
        if self.grid.picked is not None:
            self.lines = self._vertex_lines(self.grid.picked)
        self.show_subject(self.colours.subject)

    def show_subject(self, subject: str) -> None:
        """Colour surface and images by one of `SUBJECTS`, and apply the lens."""
        self.subject = self.colours.subject = subject
        lenses = self.lenses(self._turned, self.mesh.f, self._aim)
        like, several = list(self.maps.values())[int(np.argmin(self._angles))], len(self.maps) > 1
        sources, images = [], []
        explained: list[Legend] = []
        for k, (caption, x) in enumerate(self.maps.items()):
            colours = self.colours.of(self.mesh, x, self._folded[k], like)
            folds = count_foldings(len(self._folded[k]))
            above, below = caption, f"{folds}\nangles differ by {self._angles[k]:.3g} degrees"
            if not several:
                above = f"Source\n{len(self.mesh.v):,} vertices, {len(self.mesh.f):,} faces"
                below = f"{caption}\n{folds}"
            sources.append(
                Part(
                    above,
                    self._source,
                    self.mesh.f,
                    colours,
                    legends=[one for one in colours.legends if one not in explained],
                )
            )
            explained += colours.legends
            images.append(
                Part(
                    below,
                    self._turned[k],
                    self.mesh.f,
                    colours,
                    image=True,
                    lens=lenses[k],
                    edges=edge_width(self.mesh, subject),
                )
            )
        self.grid.show([sources, images] if several else [[sources[0], images[0]]])

    def _vertex_lines(self, vertex: int) -> list[str]:
        at = self.mesh.f == vertex
        around, own = at.any(axis=1), face_areas(self.mesh.unit, self.mesh.f)
        lines = [
            f"vertex {vertex:,} of {len(self.mesh.v):,}: "
            + ", ".join(f"{c:.4g}" for c in self.mesh.v[vertex])
        ]
        for caption, x in self.maps.items():
            angles = np.abs(angle_differences(self.mesh.unit, self.mesh.f, x)[at])
            image = face_areas(x, self.mesh.f)
            ratio = image[around].sum() / image.sum() / (own[around].sum() / own.sum())
            lines.append(
                f"{caption}: image {', '.join(f'{c:.4f}' for c in x[vertex])}; angles differ by "
                f"{angles.mean():.3g} degrees on average, {angles.max():.3g} at most; its faces have "
                f"{ratio:.3g} times their share of the area"
            )
        return lines

    def rebalance(self, balance: float) -> None:
        """Go on to the map of another balance, which a process of its own computes; `tick` takes it over."""
        assert self.result is not None
        self.close()
        self._balance = balance
        load = partial(_given, self.mesh.v, self.mesh.f)
        self._run = ShownRun().begin(load, partial(_rebalanced, self.result, balance))

    def _take_map(self) -> None:
        if self._run is None:
            return
        self._run.poll(0.01)
        if self._run.result is not None:
            self.result, self._run = self._run.result, None
            self._show_maps({caption_of(self.result): self.result.sphere})
        elif self._run.error is not None:
            self.message, self._run = str(self._run.error), None

    def close(self) -> None:
        if self._run is not None:
            self._run.close()
            self._run = None

    def tick(self) -> None:
        self._take_map()
        super().tick()

    def panel(self) -> None:
        if not self.grid.panel:
            return
        with panel("Map", self.grid.panel, MOUSE):
            if self.result is not None:
                self._balance_slider()
            self.view_widgets()
            self._save()
            imgui.Separator()
            for line in filter(None, (self.message, *self.lines)):
                paragraph(line)

    def _balance_slider(self) -> None:
        assert self.result is not None
        folding_free = self.result.certificate.folding_free
        imgui.BeginDisabled(not folding_free)
        _, self._balance = imgui.SliderFloat("balance", self._balance, 0.0, 1.0, "%.2f")
        if imgui.IsItemDeactivatedAfterEdit():
            self.rebalance(min(max(self._balance, 0.0), 1.0))
        imgui.EndDisabled()
        said = "0 keeps angles, 1 keeps areas"
        if not folding_free:
            said = "only of a map without folds"
        if self._run is not None:
            said = "starting"
            if len(self._run.frames) > 1:
                said = title_of(self._run.frames[-1].iterate)
        imgui.BeginDisabled(self._run is None)
        if imgui.Button("stop"):
            self.close()
        imgui.EndDisabled()
        imgui.SameLine()
        imgui.TextUnformatted(said)


def _given(v: FloatArray, f: IntArray) -> Source:
    return v, f


def _rebalanced(
    result: SphereMap, balance: float, v: FloatArray, f: IntArray, *, listener: Listener
) -> SphereMap:
    """The result at another balance, for a process of its own; v and f are the result's."""
    return result.rebalance(balance, listener=listener)


def edge_width(mesh: Mesh, subject: str, most: int = 15_000) -> float:
    """Width of the edges on images; 0 if there are too many, or they would hide a scale of colours."""
    if subject == SUBJECTS[0] and len(mesh.f) <= most:
        return EDGE_WIDTH
    return 0.0


def count_foldings(count: int) -> str:
    """A caption.

    >>> count_foldings(1), count_foldings(1200)
    ('1 folded face', '1,200 folded faces')
    """
    if count == 1:
        return "1 folded face"
    return f"{count:,} folded faces"


def caption_of(result: SphereMap) -> str:
    """Text on the making of a map."""
    balance = f", balance {result.balance:g}" if result.balance else ""
    return f"map ({result.method}{balance})"
