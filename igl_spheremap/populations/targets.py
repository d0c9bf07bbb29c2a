"""Where the sphere of each input goes."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from pathlib import Path

from ..io import format_of

_FIELD = re.compile(r"\{(folder|name|stem)\}")


def targets_of(pattern: str, sources: Sequence[str]) -> list[str]:
    """The pattern with the parts of each source's path; it is no format string, whose fields can do anything.

    Raises a ValueError unless each source has a target of its own, in a format that keeps the order of vertices.

    >>> targets_of("spheres/{stem}.ply", ["a/one.obj", "b/two.obj"])
    ['spheres/one.ply', 'spheres/two.ply']
    """
    if set("{}") & set(_FIELD.sub("", pattern)):
        raise ValueError(f"out {pattern}: known are {{folder}}, {{name}} and {{stem}}")
    targets = [_target(pattern, source) for source in sources]
    owner = {os.path.realpath(source): f"{source}, which is an input" for source in sources}
    for source, target in zip(sources, targets, strict=True):
        if not format_of(target).ordered:
            raise ValueError(f"out gives {target}, whose format keeps no vertex order; give .ply, .obj or .npz")
        place = os.path.realpath(target)
        if place in owner:
            raise ValueError(f"out gives {source} the target {owner[place]}; use {{folder}} or {{stem}}, and each "
                             "input once")
        owner[place] = f"{target}, which is that of {source}, too"
    return targets


def manifest_of(pattern: str) -> str:
    """The manifest's place, in the folder that the pattern gives to all targets.

    >>> manifest_of("spheres/{stem}.ply"), manifest_of("{folder}/lh.sphere.conformal")
    ('spheres/stem.ply.manifest.jsonl', 'folder_lh.sphere.conformal.manifest.jsonl')
    """
    folder = pattern.partition("{")[0].rpartition("/")[0]
    name = pattern.removeprefix(f"{folder}/").replace("{", "").replace("}", "").replace("/", "_")
    return str(Path(folder or ("/" if pattern.startswith("/") else ""), f"{name}.manifest.jsonl"))


def _target(pattern: str, source: str) -> str:
    path = Path(source)
    parts = {"folder": str(path.parent), "name": path.name, "stem": path.stem}
    return _FIELD.sub(lambda field: parts[field[1]], pattern)
