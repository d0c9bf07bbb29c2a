"""Colours of a surface: foldings and places, distortion of angles and areas."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from ...draw import palette
from ...features.feature_surface import FeatureSurface
from ...mesh.arrays import FloatArray, IntArray
from ...mesh.check import Mesh
from ...mesh.measure import face_areas
from ...paper.star_map import finite_conformal_factor
from ...sphere.rows import INFINITE, to_chart
from ...verify.distortion import angle_differences, log_area_ratios
from ...verify.signs import folded_faces
from .choices import SUBJECTS

Legend = palette.Ramp | tuple[str, palette.Colour]

#: Squares of a checkerboard around the sphere.
SQUARES = 24
FOLDED_MARKS = ("folded face (dot: small, ring: behind)", palette.FOLDED)
PLACE_LEGEND = ("same colour: same place", palette.SURFACE)
FOLDED_LEGEND = (f"{FOLDED_MARKS[0]}; same colour: same place", palette.FOLDED)
BOARD_LEGEND = ("squares of the sphere, the same on the surface", palette.CHECKS[0])
#: The scales of subjects.
SCALES = {"angle differences": palette.ANGLES, "area distortion": palette.AREAS}


@dataclass(frozen=True, eq=False)
class Colouring:
    """Colours of the faces, (m, 3), or a checkerboard; the faces that are painted over as folded, and the meaning."""

    colours: FloatArray
    folded: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    legends: Sequence[Legend] = ()
    checks: FloatArray | None = None


@lru_cache(maxsize=4)
def relief(mesh: Mesh, reach: float = 0.1, darkest: float = 0.72) -> FloatArray:
    """Brightness of the faces, darker in hollows: so the image shows the surface's places, as atlases of the cortex do.

    Hollows of about the size `reach` are seen, on a surface as large as the unit sphere; the deepest are `darkest`.
    """
    a, b, c = (mesh.unit[mesh.f[:, k]] for k in range(3))
    outward = np.copysign(1, np.einsum("ij,ij->", a, np.cross(b, c)))  # the sign of the volume
    hollow = -outward * FeatureSurface(mesh).depth(reach)[mesh.f].mean(axis=1)
    scale = float(np.percentile(np.abs(hollow), 80)) or 1.0
    return np.asarray(1 - (1 - darkest) * np.clip(0.5 + 0.5 * hollow / scale, 0, 1))


@lru_cache(maxsize=4)
def places(mesh: Mesh) -> FloatArray:
    """Colours by place on a surface: from end to end along its longest side, equal areas each."""
    side = int(np.argmax(np.ptp(mesh.unit, axis=0)))
    order = np.argsort(mesh.unit[mesh.f, side].mean(axis=1), kind="stable")
    rank = np.empty(len(mesh.f))
    rank[order] = np.cumsum(face_areas(mesh.unit, mesh.f)[order])
    return palette.pale("", 0, float(rank.max())).colours(rank) * relief(mesh)[:, None]


def measured(mesh: Mesh, x: FloatArray, subject: str) -> FloatArray:
    """The values at the faces of a subject that has `SCALES`."""
    if subject == "area distortion":
        return log_area_ratios(mesh.unit, mesh.f, x)
    return np.asarray(np.abs(angle_differences(mesh.unit, mesh.f, x)).mean(axis=1))


class Colours:
    """Subject of the colours, with a scale and poles of squares that stay while maps change."""

    def __init__(self, subject: str) -> None:
        if subject not in SUBJECTS:
            raise ValueError(f"unknown subject {subject!r}: choose one of {', '.join(SUBJECTS)}")
        self.subject, self.squares = subject, SQUARES
        #: The scales by their subjects.
        self.scales: dict[str, palette.Ramp] = {}
        self._tips: IntArray | None = None

    @property
    def state(self) -> tuple[object, ...]:
        """Facts that decide a map's colours."""
        return self.subject, self.squares, self.scales.get(self.subject)

    def of(
        self,
        mesh: Mesh,
        x: FloatArray,
        folded: IntArray | None = None,
        like: FloatArray | None = None,
    ) -> Colouring:
        """Colours for source and image alike; caps are grey. The legend says how much lies beyond the ends of a scale.

        Scale and poles fit the first map, or the map that it is `like`. `folded` saves the time to find
        the folded faces.
        """
        if folded is None:
            folded = np.flatnonzero(folded_faces(x, mesh.f))
        if like is None:
            like = x
        if self.subject == "checkerboard":
            if self._tips is None:
                self._tips = deepest_tips(mesh, like)
            return checkerboard(mesh, x, poles_at(x, self._tips), self.squares, folded)
        if self.subject == "foldings":
            meaning = PLACE_LEGEND
            if len(folded):
                meaning = FOLDED_LEGEND
            return Colouring(_without_caps(mesh, places(mesh)), folded, (meaning,))
        if self.subject not in self.scales:
            fitted = measured(mesh, like, self.subject)[mesh.surface]
            self.scales[self.subject] = palette.fitting(SCALES[self.subject], fitted)
        ramp, values = self.scales[self.subject], measured(mesh, x, self.subject)
        colours = _without_caps(mesh, ramp.colours(values))
        beyond = float((np.abs(values[mesh.surface]) > ramp.high).mean())
        if beyond >= 0.01:
            ramp = replace(ramp, label=f"{ramp.label}; {beyond:.0%} beyond")
        return Colouring(colours, folded, (ramp, *_marks(folded)))


def _without_caps(mesh: Mesh, colours: FloatArray) -> FloatArray:
    if mesh.caps is None:
        return colours
    return np.where(mesh.caps[:, None], palette.SURFACE, colours)


def checkerboard(
    mesh: Mesh,
    x: FloatArray,
    poles: FloatArray | None = None,
    squares: int = SQUARES,
    folded: IntArray | None = None,
) -> Colouring:
    """A checkerboard of the sphere on source and image alike, with this many squares around its poles (2, 3).

    By default the poles are at the most shrunk limbs, so that these show squares down to the tip.
    """
    if folded is None:
        folded = np.flatnonzero(folded_faces(x, mesh.f))
    if poles is None:
        poles = poles_at(x, deepest_tips(mesh, x))
    corners = squares * mercator_corners(x, mesh.f, poles)
    if mesh.caps is not None:
        corners[mesh.caps.repeat(3)] = 0.5
    return Colouring(
        np.tile(palette.SURFACE, (len(mesh.f), 1)), folded, (BOARD_LEGEND, *_marks(folded)), corners
    )


def _marks(folded: IntArray) -> tuple[Legend, ...]:
    """The meaning of folded faces, if any."""
    if not len(folded):
        return ()
    return (FOLDED_MARKS,)


def deepest_tips(mesh: Mesh, x: FloatArray, apart: float = 0.5) -> IntArray:
    """Vertices at the tips of the two limbs that a map shrinks most, apart by this cosine or more if possible.

    A chart with its poles there gives limbs squares down to the tip.
    """
    factor = finite_conformal_factor(mesh, x)[0]
    first = int(np.argmin(factor))
    second = int(np.argmin(np.where(x @ x[first] < apart, factor, np.inf)))
    return np.array([first, second])


def poles_at(x: FloatArray, tips: IntArray, apart: float = 0.5) -> FloatArray:
    """The images (2, 3) of two vertices as poles; if they are nearer than this cosine, the first and its opposite."""
    first, second = x[tips]
    if first @ second >= apart:
        second = -first
    return np.vstack((first, second))


def mercator_corners(y: FloatArray, f: IntArray, poles: FloatArray) -> FloatArray:
    """Longitude and Mercator latitude (3 m, 2) of each corner of each face, in turns around the poles (2, 3).

    The north pole is first; the two need not be opposite to one another. A face across the date line has longitudes
    beyond it: there is no jump inside a face. A vertex at a pole has its neighbour's latitude.

    >>> import numpy as np
    >>> y = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0.6, 0.8]])
    >>> poles = np.array([[0.0, 0, 1], [0, 0, -1]])
    >>> turns = mercator_corners(y, np.array([[0, 1, 2]]), poles)
    >>> float(turns[1, 0] - turns[0, 0]), bool(np.isclose(turns[2, 1], np.arctanh(0.8) / (2 * np.pi)))
    (0.25, True)
    """
    north, south = poles
    z = to_chart(y, -south[None, :]) - to_chart(north[None, :], -south[None, :])
    # cotangent of half the angle from the south, where the poles are opposite
    radius = np.abs(z) / 2
    proper = (radius > 0) & (radius < INFINITE / 2)  # of vertices that lie at no pole
    radius = np.clip(radius, radius[proper].min(), radius[proper].max())
    longitude = (np.angle(z) / (2 * np.pi))[f]
    longitude = longitude - np.rint(longitude - longitude[:, :1])
    latitude = -np.log(radius) / (2 * np.pi)
    return np.column_stack((longitude.ravel(), latitude[f].ravel()))
