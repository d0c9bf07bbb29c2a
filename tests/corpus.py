"""Where the meshes of docs/corpus.md lie, if they do."""

import os
from pathlib import Path

#: The repository.
ROOT = Path(__file__).parents[1]
CORPUS = Path(os.environ.get("IGL_SPHEREMAP_MESHES", ROOT.parent / "shared" / "meshes"))
