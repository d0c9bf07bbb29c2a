"""What users choose of a picture: its size, which way is up, what colours show. Imports nothing, for the help texts."""

from __future__ import annotations

#: Width and height in pixels of a window, of the player's, of a registration's, of a comparison's and
#: of a map's between surfaces.
SIZE = (1000, 600)
PLAYER_SIZE = (1400, 640)
REGISTRATION_SIZE = (1200, 440)
COMPARISON_SIZE = (1400, 780)
CARRIED_SIZE = (1500, 560)
#: Different pictures of a video at the most.
LENGTH = 120
#: Pictures a second of a video; a stop is held for a whole second.
RATE = 20
#: Megabytes of positions that a player keeps.
KEEP = 400.0
#: Directions that may be up.
UPS = ("auto", "x", "-x", "y", "-y", "z", "-z")
_Y_UP = (".glb", ".gltf")
_NO_CUSTOM = (".obj", ".off", ".ply", ".stl", ".npz", "your mesh")
#: What colours can show, in the order of the menus.
SUBJECTS = ("foldings", "conformal factor", "angle differences", "area distortion", "checkerboard")
#: The words for them on the command line.
SHOWN = dict(zip(("foldings", "factor", "angles", "areas", "checkerboard"), SUBJECTS, strict=True))
#: What colours can show that a map carries from one surface to another.
CARRIED = ("checkerboard", "places", "distortion")


def guess_up(name: str) -> str:
    """The direction that is up by the custom of a file's format; "auto", the shape's, where there is none.

    >>> guess_up("lh.pial"), guess_up("scene.glb"), guess_up("bunny.obj"), guess_up("sample:dino")
    ('z', 'y', 'auto', 'z')
    """
    if name.lower().endswith(_Y_UP):
        return "y"
    return "auto" if name.lower().endswith(_NO_CUSTOM) else "z"
