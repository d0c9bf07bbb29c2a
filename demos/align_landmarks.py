"""Align the landmarks of two cortical hemispheres on the sphere, first with foldings, then without.

The right hemisphere, mirrored, is mapped conformally; the left one is mapped so that its landmarks, ten that
have names and a hundred that are next to each other in space, come to lie on those of the right. Points have
no capacity in the plane: the harmonic energy is lowest where landmarks are pulled out like tents, which fold.
Descent along smooth fields that refuses foldings finds a bijection instead.

    python demos/align_landmarks.py
    python demos/align_landmarks.py --weight 1000 --others 0

The hemispheres are those of fsaverage5 that nilearn ships; without it (or nibabel), two brain-like samples.
"""

from __future__ import annotations

import importlib.util
import sys
from argparse import ArgumentParser, RawDescriptionHelpFormatter
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import igl_spheremap as ism

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


def align(weight: float, others: int) -> dict[str, ism.SphereMap]:
    """The conformal map of the left hemisphere and its two landmark maps, by what they are."""
    left, right, places = hemispheres(others)
    target = ism.spherical_conformal_map(right.vertices, right.f).sphere[nearest(right.vertices, places)]
    landmarks = nearest(left.vertices, places)
    maps = {"conformal, turned and boosted": 0.0, "landmarks, free to fold": weight, "landmarks, confined": weight}
    results = {
        name: ism.landmark_map(
            left.vertices,
            left.f,
            landmarks,
            target,
            one,
            keep_injective=name.endswith("confined"),
            max_iterations=500 if one else 0,
        )
        for name, one in maps.items()
    }
    print(f"{len(left.v)} and {len(right.v)} vertices, {len(landmarks)} landmarks of weight {weight:g}")
    print(f"{'map':<32}{'miss: mean':>11}{'largest':>9}{'foldings':>10}{'angles':>8}{'energy':>9}{'seconds':>9}")
    for name, result in results.items():
        miss = np.degrees(2 * np.arcsin(np.linalg.norm(result.sphere[landmarks] - target, axis=1) / 2))
        print(
            f"{name:<32}{miss.mean():>11.2f}{miss.max():>9.2f}{result.certificate.foldings:>10}"
            f"{np.abs(result.angle_differences()).mean():>8.2f}{result.energy:>9.4f}{result.seconds:>9.1f}"
        )
    print("misses and mean angle differences in degrees")
    return results


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the demo."""
    parser = ArgumentParser(description=__doc__, formatter_class=RawDescriptionHelpFormatter)
    parser.add_argument("--weight", type=float, default=100.0, help="of squared chords (default 100)")
    parser.add_argument("--others", type=int, default=100, help="landmarks beside the ten named (default 100)")
    args = parser.parse_args(arguments)
    results = align(args.weight, args.others)
    return 0 if results["landmarks, confined"].certificate.folding_free else 3


if __name__ == "__main__":
    sys.exit(main())
