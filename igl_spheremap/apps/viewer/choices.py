"""Users' choices for a picture: size, up direction, subject of the colours. Imports no numpy, for help texts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...io.hemispheres import LEFT, RIGHT, structure_of

if TYPE_CHECKING:  # help and wrong lines load no numpy
    from ...gate import PathLike

#: Width and height in pixels of a window, and of one that shows three bodies in a row: many screens have 1366 by 768.
SIZE = (1280, 760)
ROW_SIZE = (SIZE[0], 480)
#: Different pictures of a video at most.
LENGTH = 120
#: Pictures a second of a video; a stop is held for a whole second.
RATE = 20
#: Megabytes of positions that a player keeps.
KEEP = 400.0
#: Directions that may be up; with the last two z is, and the surface is seen from its left or its right.
UPS = ("auto", "x", "-x", "y", "-y", "z", "-z", "left", "right")
_Y_UP = (".glb", ".gltf")
_NO_CUSTOM = (".obj", ".off", ".ply", ".stl", ".npz", "the given mesh")
#: Subjects of colours, in the order of the menus.
SUBJECTS = ("foldings", "angle differences", "area distortion", "checkerboard")
#: The words for them on the command line.
SHOWN = dict(zip(("foldings", "angles", "areas", "checkerboard"), SUBJECTS, strict=True))
#: Subjects of colours that a map carries from one surface to another.
CARRIED = ("checkerboard", "places", "distortion")

#: Effect of each option of a method, which the player shows beside it.
TIPS = {
    "delta": "Factor by which a refused step is shortened.",
    "gradient_tolerance": "The descent ends when the L2 norm of the tangential gradient is at most this.",
    "max_iterations": "Most iterations of each minimisation.",
    "may_fold": "Take steps that fold faces, too.",
    "plateau": "The descent ends, too, when its energy fell by less than this share over 100 iterations.",
    "rho": "Share of the predicted decrease that a step must reach.",
    "rounds": "How often foldings are removed at most; 0 is Algorithm 1 alone.",
    "step": "Step size, from 0 to 2, in units of 1 / (sum of the sizes of a vertex's row of the Laplacian).",
    "tau": "Step that the first iteration tries, the source having unit area.",
    "tolerance": "Steps end when the energy is this far above its minimum, in units of the discretisation error.",
    "tutte": "Make the Tutte (barycentric) map first; without it the descent starts at the Gauss map.",
    "tutte_plateau": "The Tutte map ends when its energy fell by less than this share over 100 iterations.",
    "xi": "Weight of earlier energies in the search: 0 is the monotone Armijo search, 1 averages over all iterates.",
}


@dataclass(frozen=True)
class Pictures:
    """Files of a program with a picture; without a file it is a window.

    Attributes
    ----------
    screenshot, video : str or path, optional
        Files of one picture, and of all frames.
    size : (int, int)
        Width and height in pixels.
    frame : int, optional
        The frame of `screenshot`.
    length, fps : int
        Different pictures of a video at most, and pictures a second.
    """

    screenshot: PathLike | None = None
    video: PathLike | None = None
    size: tuple[int, int] = SIZE
    frame: int | None = None
    length: int = LENGTH
    fps: int = RATE

    @property
    def offscreen(self) -> bool:
        """Whether there is no window."""
        return self.screenshot is not None or self.video is not None


def guess_up(name: str, structure: str | None = None) -> str:
    """The view of a surface: if its name, or the structure that its file names, tells its side, from that side.

    Else the direction that is up by the convention of the file's format; without one, "auto", the shape's.

    >>> guess_up("subjects/lh.pial"), guess_up("sub-01_hemi-R_pial.surf.gii"), guess_up("a.gii", "CortexLeft")
    ('left', 'right', 'left')
    >>> guess_up("100.L.white.32k_fs_LR.surf.gii"), guess_up("left_leg.obj"), guess_up("lh/brain.nii")
    ('left', 'auto', 'z')
    >>> guess_up("left/brain.gii"), guess_up("scene.glb"), guess_up("bunny.obj"), guess_up("sample:dino")
    ('z', 'y', 'auto', 'z')
    """
    if not structure:
        structure = structure_of(name).get("structure")
    if structure in (LEFT, RIGHT):
        return {LEFT: "left", RIGHT: "right"}[structure]
    if name.lower().endswith(_Y_UP):
        return "y"
    if name.lower().endswith(_NO_CUSTOM):
        return "auto"
    return "z"
