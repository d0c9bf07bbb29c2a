"""The call of all demos; not a demo itself.

python demos/NAME.py [FILE|sample:NAME] [PICTURE.png]: either or both, in any order. Without a picture a window opens.
"""

import sys
from pathlib import Path

PICTURES = (".png", ".jpg", ".gif", ".mp4")


def run(demo, surface):
    """Call a demo with the name of a surface, this one by default, and that of a picture or None."""
    script, *words = sys.argv
    if {"-h", "--help"} & set(words):
        print(sys.modules["__main__"].__doc__)
        return
    pictures = [word for word in words if word.lower().endswith(PICTURES)]
    surfaces = [word for word in words if word not in pictures]
    name = Path(script).name
    if len(pictures) > 1 or len(surfaces) > 1:
        sys.exit(f"{name}: give at most one surface and one picture")
    for picture in pictures:
        if not Path(picture).parent.is_dir():
            sys.exit(f"{name}: there is no folder for {picture}")
    surfaces.append(surface)
    pictures.append(None)
    try:
        demo(surfaces[0], pictures[0])
    except KeyboardInterrupt:
        sys.exit(130)
    except (OSError, RuntimeError, ValueError) as error:  # errors of the package and of polyscope
        sys.exit(f"{name}: {error}")
