"""``python -m igl_spheremap``."""

import sys

from .cli import main

sys.exit(main())
