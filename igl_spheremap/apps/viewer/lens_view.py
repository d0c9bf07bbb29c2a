"""One lens on all maps of a window: its place, its power, and the widgets for it and for colours."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...draw.folds import Clusters
from ...draw.lens import Lens, follow, follow_vertex
from ...mesh.arrays import FloatArray, IntArray
from .app import App
from .colouring import Colours
from .grid import magnification
from .widgets import colour_widgets, tip
from .window import imgui, pressed


class LensView(App):
    """An app with a lens on the vertex that is picked, else on a cluster of folded faces, else on what is in front."""

    colours: Colours
    #: Power of the lens; None: as fits its target.
    power: float | None = None

    def leave_lens(self) -> None:
        """Take the lens off its target, as for another surface."""
        none = np.empty(0, dtype=np.int64)
        #: Clusters of folded faces, and the faces of the one that the lens is on.
        self.clusters, self._aimed = Clusters(none, none), none
        #: Turn of the grid when the lens was aimed, which brings its place to the front.
        self._facing = np.eye(3)
        #: The present lens.
        self.lens = Lens()
        self.grid.picked = None

    def refresh(self) -> None:
        """Show the maps through the present lens."""
        raise NotImplementedError

    def find_clusters(self, f: IntArray, folded: IntArray) -> None:
        """Find clusters of folded faces; the lens stays on its own, or goes to the largest."""
        self.clusters = Clusters.of(f, folded)
        cluster = self.cluster
        self._aimed = folded[:0]
        if self.clusters:
            self._aimed = self.clusters[cluster]

    @property
    def cluster(self) -> int:
        """The lens' cluster of folded faces: that which continues its last one, or the largest."""
        if not self.clusters:
            return 0
        shared = np.isin(self.clusters.faces, self._aimed)
        return int(np.argmax(self.clusters.sums(shared.astype(np.float64))))

    def lenses(self, maps: Sequence[FloatArray], f: IntArray, aim: int = 0) -> list[Lens]:
        """Lenses of one power on the same place of all maps; a power of None fits the map `aim`."""
        vertex, power = self.grid.picked, self.power
        if vertex is None and len(self._aimed):
            found = follow(maps, f, self._aimed, aim, power, self._facing)
        else:
            if vertex is None:
                vertex = int(np.argmax(maps[aim] @ self._facing[2]))
                if power is None:
                    power = 1.0
            found = follow_vertex(maps, f, vertex, aim, power, self._facing)
        self.lens = found[aim]
        return found

    def look(self, power: float | None = None, cluster: int | None = None) -> None:
        """Magnify by a power, None for the fitting one; on a given cluster, and no longer on the vertex picked."""
        self.power, self._facing = power, self.grid.turn
        if cluster is not None:
            self._aimed, self.grid.picked = self.clusters[cluster], None
        self.refresh()

    def pick(self, vertex: int | None) -> None:
        """Mark a vertex; the lens goes to it with its present power. Without one, the power fits again."""
        power = self.power
        if vertex is not None:
            power = self.lens.power
        elif self.grid.picked is not None:
            # at the power of a limb's tip the rest of the sphere would be a speck
            power = None
        super().pick(vertex)
        self.look(power)

    def view_widgets(self) -> None:
        """Choose colours, the power of the lens, and its cluster of folded faces."""
        if colour_widgets(self.colours):
            self.refresh()
        lens, sizes = self.lens, self.clusters.sizes
        imgui.BeginDisabled(lens.limit == 1)
        moved, chosen = imgui.SliderFloat(
            "lens",
            lens.power,
            1.0,
            lens.limit,
            magnification(lens.power),
            imgui.ImGuiSliderFlags_Logarithmic,
        )
        imgui.EndDisabled()
        tip(
            "A Moebius map, which keeps angles, magnifies what the small sphere circles. At its end that fills the "
            "view: the faces around a vertex, or a cluster of folded faces. L: the whole sphere, and back."
        )
        if moved:
            self.look(min(max(float(chosen), 1.0), lens.limit))
        said, last = "nothing folds", max(len(sizes), 2)
        if len(sizes):
            said = f"%d of {len(sizes):,}: {sizes[self.cluster]:,} faces"
        imgui.BeginDisabled(len(sizes) < 2)
        picked, place = imgui.SliderInt("cluster", self.cluster + 1, 1, last, said)
        imgui.EndDisabled()
        tip("Which cluster of folded faces is magnified, the largest first.")
        if picked:
            self.look(None, min(max(place, 1), len(sizes)) - 1)
        toggled = pressed("L")
        if imgui.Button("whole sphere") or (toggled and lens.power > 1):
            self.look(1.0)
        imgui.SameLine()
        if imgui.Button("fit") or (toggled and lens.power == 1):
            self.look(None)
        tip("As strong as shows all of the cluster, or what is around the vertex that was picked.")
