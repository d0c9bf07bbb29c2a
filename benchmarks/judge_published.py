"""The spheres and plane maps that programs and data sets ship themselves, judged on their numbers as they are.

benchmarks/published.csv names the files: those of wheels come by pip, the others from GitHub at a commit, or from
clones, whose git directories are CLONES/OWNER+NAME/repo. None of them is a part of this repository.
"""

from __future__ import annotations

import csv
import subprocess
import urllib.parse
import urllib.request
import zipfile
from dataclasses import dataclass, replace
from itertools import groupby
from pathlib import Path, PurePosixPath

import numpy as np

import igl_spheremap as ism
from igl_spheremap.errors import one_line
from igl_spheremap.io.files import read_sphere
from igl_spheremap.io.plane_map import read_images, read_plane_map
from igl_spheremap.io.written_map import certify_radius

from .gather import download

MANIFEST = Path(__file__).with_name("published.csv")
COLUMNS = (
    "from",
    "file",
    "source",
    "vertices",
    "radius",
    "verdict",
    "folded faces",
    "degree",
    "angle, degrees",
)
#: Columns of the page, a line for all files of one origin and verdict.
SHOWN = (
    "from",
    "files",
    "vertices",
    "radius",
    "verdict",
    "folded faces",
    "degree",
    "angle, degrees",
)


@dataclass(frozen=True)
class Published:
    """A row of the manifest: whose file, a wheel or a repository and commit, paths of the map and of its surface."""

    whose: str
    source: str
    commit: str
    path: str
    surface: str
    kind: str

    def fetch(self, path: str, folder: Path, clones: Path | None) -> Path:
        """A file of the source, brought to a folder where it is not there yet."""
        place = folder / self.source.removesuffix(".whl").replace("/", "+") / path
        if place.exists():
            return place
        place.parent.mkdir(parents=True, exist_ok=True)
        if self.source.endswith(".whl"):
            wheel = folder / self.source
            if not wheel.exists():
                download(self.source, folder)
            place.write_bytes(zipfile.ZipFile(wheel).read(path))
        elif (
            clones is not None
            and (clone := clones / self.source.replace("/", "+") / "repo").is_dir()
        ):
            found = subprocess.run(
                ["git", f"--git-dir={clone}", "show", f"{self.commit}:{path}"],
                check=True,
                capture_output=True,
            )
            place.write_bytes(found.stdout)
        else:
            address = f"https://raw.githubusercontent.com/{self.source}/{self.commit}/{path}"
            with urllib.request.urlopen(urllib.parse.quote(address, safe=":/")) as data:
                place.write_bytes(data.read())
        return place

    def judged(self, folder: Path, clones: Path | None) -> dict[str, str]:
        """A row of the table; where there is nothing to judge its verdict says why."""
        row = {
            "from": self.whose,
            "file": PurePosixPath(self.path).name,
            "source": f"{self.source} {self.commit[:8]} {self.path}".replace("  ", " "),
        }
        path = Path(self.path)
        try:
            path = self.fetch(self.path, folder, clones)
            surface = (
                ism.read_mesh(self.fetch(self.surface, folder, clones)) if self.surface else None
            )
            return row | (_sphere if self.kind == "sphere" else _plane)(path, surface)
        except (ism.MeshError, ism.FileError) as error:
            return row | {
                "verdict": one_line(error)
                .replace(f"{path}", path.name)
                .split("; ")[0]
                .split(", e.g.")[0]
            }
        # no network, no clone, another wheel
        except (OSError, KeyError, subprocess.SubprocessError) as error:
            return row | {"verdict": f"not to be had: {one_line(error)[:80]}"}


def _sphere(path: Path, surface: ism.LoadedMesh | None) -> dict[str, str]:
    x, f = read_sphere(path)
    check = certify_radius(x, f)
    words = _verdict(replace(check, off_sphere=check.off_sphere[:0]))
    if len(check.off_sphere):
        radii = np.linalg.norm(x, axis=1)
        words += f", once scaled to the sphere: radii vary by {np.ptp(radii) / check.radius:.0e}"
    return _cells(
        len(x),
        f"{check.radius:.6g}",
        words,
        check,
        None if surface is None else ism.angle_differences(surface.v, f, x),
    )


def _plane(path: Path, surface: ism.LoadedMesh | None) -> dict[str, str]:
    own = surface is not None or read_images(path).has_surface
    flat = read_plane_map(path, surface=surface if own else ism.read_mesh(path))
    angles = flat.angle_differences() if own else None
    return _cells(len(flat.plane), "plane", _verdict(flat.certificate), flat.certificate, angles)


def _verdict(check: ism.Certificate) -> str:
    return {1: "homeomorphism", -1: "homeomorphism, mirrored"}.get(check.orientation or 0, "folded")


def _cells(
    n: int, radius: str, verdict: str, check: ism.Certificate, angles: np.ndarray | None
) -> dict[str, str]:
    return {
        "vertices": str(n),
        "radius": radius,
        "verdict": verdict,
        "folded faces": str(check.foldings),
        "degree": str(check.degree),
        "angle, degrees": "" if angles is None else f"{np.abs(angles).mean():.3g}",
    }


def judge_published(folder: Path, clones: Path | None) -> list[dict[str, str]]:
    """The rows of all files that the manifest names."""
    folder.mkdir(parents=True, exist_ok=True)
    with MANIFEST.open(newline="", encoding="utf-8") as file:
        return [Published(**row).judged(folder, clones) for row in csv.DictReader(file)]


def by_verdict(rows: list[dict[str, str]]) -> list[list[str]]:
    """Head and lines of the page: files of one origin and verdict, the least and the largest of their numbers."""
    lines = [list(SHOWN)]
    for (whose, verdict), some in groupby(sorted(rows, key=_origin), key=_origin):
        found = list(some)
        vertices, radius, folded, degree, angles = (
            _span([row.get(name, "") for row in found]) for name in SHOWN[2:] if name != "verdict"
        )
        lines.append([whose, str(len(found)), vertices, radius, verdict, folded, degree, angles])
    return lines


def _origin(row: dict[str, str]) -> tuple[str, str]:
    return f"{row['from']}{', plane' * (row.get('radius') == 'plane')}", row["verdict"].partition(
        ": radii"
    )[0]


def _span(cells: list[str]) -> str:
    """The least and the largest of some numbers, or what stands in their place."""
    known = [cell for cell in cells if cell]
    if not known or "plane" in known:
        return "".join(known[:1])
    numbers = sorted(map(float, known))
    return " to ".join(dict.fromkeys(f"{number:,.6g}" for number in (numbers[0], numbers[-1])))
