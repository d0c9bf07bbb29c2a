"""One surface on the stage: positions, face colours, folded faces brought to the front."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import style
from .window import MATERIAL

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
Legend = style.Ramp | tuple[str, style.Colour] | None

#: Folded faces are drawn this much farther out than the sphere, so that the faces over them don't hide them.
_LIFT = 1.012
#: Faces whose image is shorter than this, as a share of the radius, get a dot to be seen at all.
_TINY = 0.012
_DOT = 0.014


class Body:
    """A surface that fits into the unit ball.

    Parameters
    ----------
    name : str
        Of its structures in polyscope, unique on the stage.
    x : (n, 3) float64 array
        Positions: in the unit ball, x to the right, y up, z towards the viewer.
    f : (m, 3) int64 array
        Faces.
    lift : bool
        Bring folded faces to the front; for images, where they are under others.
    """

    def __init__(self, name: str, x: FloatArray, f: IntArray, *, lift: bool = False) -> None:
        import polyscope as ps

        self.name, self.f, self.lift = name, f, lift
        self.x = x
        self.caption = ""
        self.legend: Legend = None
        self.version = 0
        self.mesh = self._mesh(ps, name, x, f)
        self.points: dict[str, Any] = {}
        self._folded: Any = None
        self.paint(np.tile(style.SURFACE, (len(f), 1)))

    def set_positions(self, x: FloatArray) -> None:
        """Move the vertices.

        Parameters
        ----------
        x : (n, 3) float64 array
            In the unit ball.

        Returns
        -------
        None
        """
        self.x = x
        self.mesh.update_vertex_positions(x)
        self.version += 1

    def paint(self, colours: FloatArray, folded: IntArray | None = None) -> None:
        """Colour the faces, folded ones in their own colour.

        Parameters
        ----------
        colours : (m, 3) float64 array
            As they shall look.
        folded : int64 array, optional
            Indices of faces.

        Returns
        -------
        None
        """
        colours = colours.copy()
        folded = np.empty(0, dtype=np.int64) if folded is None else folded
        colours[folded] = style.FOLDED
        self.mesh.add_color_quantity("colour", style.linear(colours), defined_on="faces", enabled=True)
        if self.lift:
            self._bring_to_front(folded)
        self.version += 1

    def dots(self, label: str, positions: FloatArray, colour: style.Colour, radius: float = 0.03) -> None:
        """Show points on the surface, in place of those of that label; none takes them away.

        Parameters
        ----------
        label : str
            Of the set.
        positions : (k, 3) float64 array
            In the unit ball.
        colour : (float, float, float)
            As they shall look.
        radius : float
            Of a dot.

        Returns
        -------
        None
        """
        import polyscope as ps

        name = f"{self.name} {label}"
        old = self.points.pop(label, None)
        if old is not None:
            ps.remove_point_cloud(name)
        if len(positions):
            shown = tuple(style.linear(np.array(colour)))
            cloud = ps.register_point_cloud(name, positions, color=shown, material=MATERIAL)
            self.points[label] = cloud, radius
        self.version += 1

    def move(self, centre: FloatArray, radius: float, turn: FloatArray, zoom: float) -> None:
        """Put the body somewhere.

        Parameters
        ----------
        centre : (3,) float64 array
            Of the unit ball.
        radius : float
            Of the unit ball.
        turn : (3, 3) float64 array
            Rotation.
        zoom : float
            By which the radius was magnified; dots are not.

        Returns
        -------
        None
        """
        self._at(self.mesh, centre, radius, turn)
        if self._folded is not None:
            self._at(self._folded, centre, radius * _LIFT, turn)
        for cloud, size in self.points.values():
            cloud.set_radius(size * radius / zoom, relative=False)
            self._at(cloud, centre, radius * _LIFT, turn)

    def show_edges(self, width: float) -> None:
        """Draw the edges.

        Parameters
        ----------
        width : float
            0 hides them.

        Returns
        -------
        None
        """
        self.mesh.set_edge_width(width)
        if self._folded is not None:
            self._folded.set_edge_width(width)

    def remove(self) -> None:
        """Take the body off the stage."""
        import polyscope as ps

        for label in tuple(self.points):
            self.dots(label, np.empty((0, 3)), style.FOLDED)
        self._bring_to_front(np.empty(0, dtype=np.int64))
        ps.remove_surface_mesh(self.name)

    def _bring_to_front(self, folded: IntArray) -> None:
        import polyscope as ps

        if self._folded is not None:
            ps.remove_surface_mesh(f"{self.name} folded")
            self._folded = None
        tiny = np.empty((0, 3))
        if len(folded):
            corners = self.x[self.f[folded]]
            self._folded = self._mesh(
                ps, f"{self.name} folded", corners.reshape(-1, 3), np.arange(3 * len(folded)).reshape(-1, 3)
            )
            self._folded.set_edge_color((0.25, 0.02, 0.0))
            self._folded.set_edge_width(self.mesh.get_edge_width())
            self._folded.set_color(tuple(style.linear(np.array(style.FOLDED))))
            size = np.abs(corners - corners.mean(axis=1, keepdims=True)).max(axis=(1, 2))
            tiny = corners.mean(axis=1)[size < _TINY]
        self.dots("foldings", tiny, style.FOLDED, _DOT)

    @staticmethod
    def _mesh(ps: Any, name: str, x: FloatArray, f: IntArray) -> Any:
        mesh = ps.register_surface_mesh(name, x, f, material=MATERIAL)
        mesh.set_back_face_policy("identical")
        mesh.set_edge_color(tuple(style.linear(np.array(style.EDGES))))
        return mesh

    @staticmethod
    def _at(structure: Any, centre: FloatArray, radius: float, turn: FloatArray) -> None:
        matrix = np.eye(4)
        matrix[:3, :3] = radius * turn
        matrix[:3, 3] = centre
        structure.set_transform(matrix)
