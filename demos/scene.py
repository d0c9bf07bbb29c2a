"""The scene of demos that draw with polyscope's own calls; not a demo itself."""

from pathlib import Path

import numpy as np
import polyscope as ps


def begin_scene(picture):
    """Start polyscope; it needs no display if a picture is to be written."""
    ps.set_verbosity(0)
    ps.set_use_prefs_file(False)
    ps.set_allow_headless_backends(True)
    ps.init()
    if picture is None and ps.is_headless():
        raise RuntimeError("there is no display; name a picture to be written, such as demo.png")
    ps.set_up_dir("z_up")
    ps.set_front_dir("neg_y_front")
    ps.set_ground_plane_mode("none")


def end_scene(picture):
    """Look at the scene along y; open the window, or write the picture."""
    low, high = np.array(ps.get_bounding_box())
    width, depth, height = high - low
    columns, rows = ps.get_window_size()
    covered = 0
    if picture is None:
        covered = 310  # pixels of polyscope's panel at the left
    seen = max(height, width * rows / (columns - covered))
    far = depth / 2 + 1.3 * seen  # polyscope sees 45 degrees from top to bottom
    middle = (low + high) / 2 - [covered / 2 * seen / rows, 0, 0]
    ps.look_at(middle - [0, far, 0], middle)
    if picture:
        ps.screenshot(picture)
        if not Path(picture).exists():
            raise RuntimeError(f"{picture} can't be written; give a .png or .jpg file")
    else:
        ps.show()
