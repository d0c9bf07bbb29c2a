"""Align the landmarks of two cortical hemispheres on the sphere, first with foldings, then without.

The right hemisphere, mirrored, is mapped conformally; the left one is mapped so that its landmarks, ten that
have names and a hundred that are next to each other in space, come to lie on those of the right. Points have
no capacity in the plane: the harmonic energy is lowest where landmarks are pulled out like tents, which fold.
Descent along smooth fields that refuses foldings finds a bijection instead.

    python demos/align_landmarks.py
    python demos/align_landmarks.py --weight 1000 --others 0
    python demos/align_landmarks.py --screenshot landmarks.png

The hemispheres are those of fsaverage5 that nilearn ships; without it (or nibabel), two brain-like samples.
"""

from __future__ import annotations

import importlib.util
import sys
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import igl_spheremap as ism
from igl_spheremap.apps.viewer.app import open_for, run_app
from igl_spheremap.apps.viewer.body import follow
from igl_spheremap.apps.viewer.colouring import places
from igl_spheremap.apps.viewer.compare import Part, RowView
from igl_spheremap.draw.plot import fit, pose
from igl_spheremap.verify.signs import folded_faces

BLACK, WHITE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
#: Radii of the dots of landmarks and targets; the former are drawn nearer to the viewer, to be seen inside.
_SMALL, _LARGE, _NEARER = 0.016, 0.03, (0.0, 0.0, 0.04)

#: Places on a left hemisphere, in millimetres of MNI space: right, front, up.
PLACES = {
    "frontal pole": (-18, 65, 5),
    "occipital pole": (-15, -100, 0),
    "temporal pole": (-40, 18, -32),
    "hand knob": (-38, -25, 58),
    "superior parietal lobule": (-25, -65, 60),
    "inferior frontal gyrus": (-50, 25, 10),
    "temporo-parietal junction": (-55, -50, 25),
    "middle temporal gyrus": (-60, -25, -12),
    "anterior cingulate": (-5, 35, 15),
    "precuneus": (-6, -60, 40),
}


def hemispheres(others: int) -> tuple[ism.Mesh, ism.Mesh, NDArray[np.float64]]:
    """Two left hemispheres, and places near both: the named ones, and some vertices of the first."""
    folder = _fsaverage()
    if folder is None:
        left = ism.check_mesh(*ism.samples.make("brain", n_vertices=4000))
        right = ism.check_mesh(*ism.samples.make("brain", n_vertices=5000, depth=0.1))
        return left, right, _spread(left, len(PLACES) + others)
    left, right = (ism.read_mesh(folder / f"pial_{side}.gii.gz") for side in ("left", "right"))
    mirrored = ism.check_mesh(right.v * [-1, 1, 1], right.f[:, ::-1])
    mesh = ism.check_mesh(left.v, left.f)
    return mesh, mirrored, np.vstack((list(PLACES.values()), _spread(mesh, others)))


def _spread(mesh: ism.Mesh, count: int) -> NDArray[np.float64]:
    """Some vertices, evenly through their order."""
    return mesh.vertices[np.linspace(0, len(mesh.v) - 1, count).astype(int)]


def _fsaverage() -> Path | None:
    """The folder of nilearn's hemispheres."""
    if not all(importlib.util.find_spec(name) for name in ("nilearn", "nibabel")):
        return None
    (root,) = importlib.util.find_spec("nilearn").submodule_search_locations  # type: ignore[union-attr]
    folder = Path(root) / "datasets" / "data" / "fsaverage5"
    return folder if folder.is_dir() else None


def nearest(v: NDArray[np.float64], places: NDArray[np.float64]) -> NDArray[np.int64]:
    """The vertex next to each place."""
    return np.array([np.argmin(((v - place) ** 2).sum(axis=1)) for place in places])


@dataclass(frozen=True, eq=False)
class Alignment:
    """The left hemisphere, its landmarks, their targets (k, 3), and maps by what they are."""

    mesh: ism.Mesh
    landmarks: NDArray[np.int64]
    targets: NDArray[np.float64]
    maps: dict[str, ism.SphereMap]

    def misses(self, result: ism.SphereMap) -> NDArray[np.float64]:
        """Degrees from each landmark to its target."""
        chord = np.linalg.norm(result.sphere[self.landmarks] - self.targets, axis=1)
        return np.degrees(2 * np.arcsin(chord / 2))

    def view(self) -> RowView:
        """The surface with its landmarks, and each map with landmarks and targets."""
        colours, turn = places(self.mesh), pose(self.mesh.v)
        surface = fit(self.mesh.v, turn)
        marks = {"landmarks": (surface[self.landmarks], BLACK, _SMALL)}
        caption = f"{len(self.landmarks)} landmarks\n{len(surface):,} vertices"
        parts = [Part(caption, surface, self.mesh.f, colours, dots=marks)]
        folded = {name: np.flatnonzero(folded_faces(result.sphere, self.mesh.f)) for name, result in self.maps.items()}
        worst = max(folded, key=lambda name: len(folded[name]))
        turn = follow(self.maps[worst].sphere @ turn.T, self.mesh.f, folded[worst]).axes() @ turn  # foldings in front
        for name, result in self.maps.items():
            x = result.sphere @ turn.T
            dots = {"targets": (self.targets @ turn.T, WHITE, _LARGE),
                    "landmarks": (x[self.landmarks] + _NEARER, BLACK, _SMALL)}
            caption = f"{name}\n{self.misses(result).mean():.1f} degrees off, {len(folded[name]):,} folded faces"
            parts.append(Part(caption, x, self.mesh.f, colours, folded[name], dots))
        return RowView(parts, ("landmark (its target is white; folded faces are red)", BLACK))


def align(weight: float, others: int) -> Alignment:
    """The conformal map of the left hemisphere and its two landmark maps, by what they are."""
    left, right, places = hemispheres(others)
    target = ism.spherical_conformal_map(right.vertices, right.f).sphere[nearest(right.vertices, places)]
    landmarks = nearest(left.vertices, places)
    maps = {"conformal, best Moebius map": 0.0, "landmarks, may fold": weight, "landmarks, may not fold": weight}
    results = {
        name: ism.landmark_map(
            left.vertices,
            left.f,
            landmarks,
            target,
            one,
            keep_injective=name.endswith("may not fold"),
            max_iterations=500 if one else 0,
        )
        for name, one in maps.items()
    }
    alignment = Alignment(left, landmarks, target, results)
    print(f"{len(left.v)} and {len(right.v)} vertices, {len(landmarks)} landmarks of weight {weight:g}")
    print(f"{'map':<32}{'miss: mean':>11}{'largest':>9}{'foldings':>10}{'angles':>8}{'energy':>9}{'seconds':>9}")
    for name, result in results.items():
        miss = alignment.misses(result)
        print(
            f"{name:<32}{miss.mean():>11.2f}{miss.max():>9.2f}{result.certificate.foldings:>10}"
            f"{np.abs(result.angle_differences()).mean():>8.2f}{result.energy:>9.4f}{result.seconds:>9.1f}"
        )
    print("misses and mean angle differences in degrees")
    return alignment


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the demo."""
    parser = ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument("--weight", type=float, default=100.0, help="of squared chords (default 100)")
    parser.add_argument("--others", type=int, default=100, help="landmarks beside the ten named (default 100)")
    parser.add_argument("--screenshot", metavar="OUT.png", help="write a picture of the maps; needs no display")
    args = parser.parse_args(arguments)
    if args.screenshot:
        args.video, args.frame, args.size = None, None, (1400, 440)
        open_for(args, "Align landmarks")
    alignment = align(args.weight, args.others)
    if args.screenshot:
        run_app(alignment.view(), args)
    return 0 if alignment.maps["landmarks, may not fold"].certificate.folding_free else 3


if __name__ == "__main__":
    sys.exit(main())
