"""The folder, if any, of the meshes of docs/corpus.md."""

import os
from pathlib import Path

#: The repository.
ROOT = Path(__file__).parents[1]
CORPUS = Path(os.environ.get("IGL_SPHEREMAP_MESHES", ROOT.parent / "shared" / "meshes"))
