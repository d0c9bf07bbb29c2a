"""Watch foldings go: each step of Algorithms 1 and 2 before and after, through one lens.

The command `igl-spheremap play` does the same, and has the same options.

    python demos/folding_removal.py
    python demos/folding_removal.py dinosaur.obj --up y --method lai2014
    python demos/folding_removal.py sample:bird --screenshot bird.png
    python demos/folding_removal.py --video dino.gif
"""

from __future__ import annotations

import sys

from igl_spheremap.apps.cli import main

if __name__ == "__main__":
    sys.exit(main(["play", *sys.argv[1:]]))
