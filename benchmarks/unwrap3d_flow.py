"""Area flow of u-unwrap3D in a Python of its own, as it needs libigl < 2.6 and numpy < 2.

Called by `balanced_maps.py` as ``PYTHON unwrap3d_flow.py meshtools.py IN.npz OUT.npz``. The package imports what its
flow does not use, so that the function is read from its file; scipy solves in place of pypardiso.
"""

import ast
import sys
import time
from pathlib import Path

import numpy as np
import trimesh

NAME, STEPS = "area_distortion_flow_relax_sphere", 50


def main(meshtools, source, target):
    """Flow from the sphere of the file, at the function's defaults."""
    text, scope = Path(meshtools).read_text(), {}
    part = next(node for node in ast.parse(text).body if getattr(node, "name", "") == NAME)
    exec(ast.get_source_segment(text, part), scope)
    with np.load(source) as data:
        sphere, body = (trimesh.Trimesh(data[key], data["f"], process=False) for key in ("x", "v"))
    began = time.process_time()
    steps = scope[NAME](sphere, body, max_iter=STEPS)[0]
    np.savez(target, x=steps[-1], steps=len(steps) - 1, seconds=time.process_time() - began)


if __name__ == "__main__":
    main(*sys.argv[1:])
