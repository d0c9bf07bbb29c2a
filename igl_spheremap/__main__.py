"""``python -m igl_spheremap``."""

import sys

from .apps.cli import main

sys.exit(main())
