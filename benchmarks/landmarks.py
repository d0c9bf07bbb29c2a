"""Align landmarks of the two hemispheres of fsaverage5, which nilearn ships: the table of docs/benchmarks.md.

    python -m benchmarks landmarks
    python -m benchmarks landmarks --weight 1000 --others 0

The right hemisphere, mirrored, is mapped conformally; the left one is mapped so that its landmarks, ten that have names
and others that are next to each other in space, come to lie on those of the right.
"""

import numpy as np

import igl_spheremap as ism

from .common import fsaverage5, parser

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


def hemispheres():
    """Vertices and faces of the left hemisphere, and of the right one mirrored."""
    left, right = (
        ism.read_mesh(fsaverage5() / f"pial_{side}.gii.gz") for side in ("left", "right")
    )
    return (left.v, left.f), (right.v * [-1, 1, 1], right.f[:, ::-1])


def nearest(v, places):
    """The vertex next to each place."""
    return np.array([np.argmin(((v - place) ** 2).sum(axis=1)) for place in places])


def main(argv: list[str]) -> None:
    """Print the table."""
    arguments = parser(__doc__)
    arguments.add_argument(
        "--weight", type=float, default=100.0, help="of squared chords (default 100)"
    )
    arguments.add_argument(
        "--others", type=int, default=100, help="landmarks beside the ten named (default 100)"
    )
    args = arguments.parse_args(argv)
    (v, f), (w, g) = hemispheres()
    places = np.vstack(
        (list(PLACES.values()), v[np.linspace(0, len(v) - 1, args.others).astype(int)])
    )
    targets = ism.spherical_conformal_map(w, g).sphere[nearest(w, places)]
    landmarks = nearest(v, places)
    print(
        "| map of the left hemisphere | miss: mean, largest | foldings | mean angle difference | energy |"
    )
    print("|---|---|---|---|---|")
    for name, weight, injective in (
        ("conformal, best Moebius map", 0.0, True),
        ("with landmarks, may fold", args.weight, False),
        ("with landmarks, may not fold", args.weight, True),
    ):
        result = ism.landmark_map(
            v,
            f,
            landmarks,
            targets,
            landmark_weights=weight,
            may_fold=not injective,
            max_iterations=500 if weight else 0,
        )
        chord = np.linalg.norm(result.sphere[landmarks] - targets, axis=1)
        miss = np.degrees(2 * np.arcsin(chord / 2))
        print(
            f"| {name} | {miss.mean():.2f}, {miss.max():.2f} | {result.certificate.foldings} | "
            f"{np.abs(result.angle_differences()).mean():.2f} | {result.energy:.3f} |"
        )
