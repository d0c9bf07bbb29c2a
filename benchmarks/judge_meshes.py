"""The meshes of `judge`: 36 closed surfaces, 8 disks, and 6 pairs to map one onto the other."""

from __future__ import annotations

import re
import sys
import tempfile
from collections.abc import Iterator
from functools import cache
from operator import attrgetter
from pathlib import Path

import numpy as np
from bodies import random_body
from disks import cut

import igl_spheremap as ism

from .correspondences import body
from .gather import Part, gather, manifest

Mesh = tuple[np.ndarray, np.ndarray]

#: By class: samples, random bodies by their seeds, which nothing else has ("limbs": tests/bodies.py; "blob":
#: correspondences.py, with "+" meshed anew), parts of the manifest by the ends of their paths and components, and what
#: is cut from these about vertex 0, by its share of the area. The parts of a robot are every seventh of its wheel.
MESHES = {
    "sample": [
        f"sample:{name}:n_vertices=5000"
        for name in ("bunny", "dino", "dumbbell", "octopus", "spheroid", "spring")
    ],
    "limbs": [f"limbs:{seed}" for seed in range(47_000, 47_008)],
    "blob": [f"blob:{seed}" for seed in range(47_000, 47_006)],
    "brain": [
        "part:S1200.L.pial_MSMAll.32k_fs_LR.surf.gii:0",
        "part:S1200.R.white_MSMAll.32k_fs_LR.surf.gii:0",
        "part:conte69_32k_lh.gii:0",
        "part:conte69_32k_rh.gii:0",
        "part:fsaverage5/pial_right.gii.gz:0",
        "part:fsaverage5/white_right.gii.gz:0",
    ],
    "organ": [
        "part:Dmel.ply:1",
        "part:DsecI.ply:0",
        "part:DsecI.ply:3",
        "part:Dsim.ply:0",
        "part:Dsim.ply:2",
    ],
    "part": [
        "part:mjcf/assets/arducam.stl:3",
        "part:big_lens_d40.stl:0",
        "part:body_top_3dprint_collider_front_0.stl:0",
        "part:rubber_duck_toy_1k.obj:0",
        "part:urdf/assets/arducam.stl:36",
    ],
    "disk": [
        "part:T1.ply:1",
        "part:faces_big.obj:0",
        "cut:0.5:limbs:47008",
        "cut:0.9:blob:47006",
        "cut:0.5:part:fsaverage5/pial_right.gii.gz:0",
        "cut:0.15:part:conte69_32k_lh.gii:0",
        "cut:0.5:part:rubber_duck_toy_1k.obj:0",
        "cut:0.9:sample:bunny:n_vertices=5000",
    ],
    "map": [
        "blob:47010 onto blob:47011",
        "blob:47012 onto blob:47012+",
        "part:Dmel.ply:1 onto part:Dsim.ply:0",
        "part:fsaverage5/white_right.gii.gz:0 onto part:fsaverage5/pial_right.gii.gz:0",
        "sample:pear:n_vertices=1500 onto sample:spheroid:n_vertices=2000",
        "sample:bunny:n_vertices=2500 onto sample:dino:n_vertices=2500",
    ],
}


def write(folder: Path) -> None:
    """Write all as PLY files, the target of a map beside its source as NAME.target.ply, and a list of what they are."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parent) as place:
        made, lines = Path(place) / "meshes", ["mesh\tvertices\tfaces\twhat"]
        made.mkdir()
        for name, specs, meshes in _all(Path(place)):
            for end, (v, f) in zip((".ply", ".target.ply"), meshes, strict=False):
                ism.write_mesh(made / f"{name}{end}", v, f)
            lines.append(f"{name}\t{len(meshes[0][0])}\t{len(meshes[0][1])}\t{specs}")
            print(lines[-1], file=sys.stderr, flush=True)
        (made / "meshes.tsv").write_text("\n".join(lines) + "\n", encoding="utf-8")
        made.rename(folder)


def _all(place: Path) -> Iterator[tuple[str, str, list[Mesh]]]:
    """Names, what they are, and the surfaces: two where one is to be mapped onto the other."""
    specs = [
        (f"{kind}_{k}", spec) for kind, some in MESHES.items() for k, spec in enumerate(some, 1)
    ]
    parts = {name: _part(name) for _, spec in specs for name in re.findall(r"part:(\S+)", spec)}
    if gather(sorted(set(parts.values()), key=attrgetter("number")), place):
        raise SystemExit("parts are not what the manifest lists")

    @cache
    def mesh(spec: str) -> Mesh:
        kind, _, rest = spec.partition(":")
        if kind == "sample":
            return ism.samples.from_spec(rest)
        if kind == "limbs":
            return random_body(int(rest))
        if kind == "blob":
            return body(int(rest.rstrip("+")), rest.endswith("+"))
        if kind == "cut":
            share, _, whole = rest.partition(":")
            return cut(*mesh(whole), 0, float(share))
        v, f = ism.read_mesh(parts[rest].file(place))
        return v, f

    for name, spec in specs:
        yield name, spec, [mesh(each) for each in spec.split(" onto ")]


def _part(name: str) -> Part:
    """The part of the manifest by the end of its path and its component."""
    path, _, component = name.rpartition(":")
    found = [
        part
        for part in manifest()
        if part.path.endswith(f"/{path}") and part.component == int(component)
    ]
    if len(found) != 1:
        raise SystemExit(f"{len(found)} parts of the manifest are called {name}")
    return found[0]
