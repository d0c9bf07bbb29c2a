"""A page about a map: verdict, figures, pictures, curves, versions; one HTML file that needs no network."""

from __future__ import annotations

import io
import os
import platform
import tempfile
from collections.abc import Callable, Iterable
from html import escape
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from .._version import __version__
from ..draw.markup import (
    MOST_FACES,
    View,
    check_own_page,
    made_by,
    page,
    page_file,
    picture,
    scene,
    small_png,
    table,
)
from ..draw.palette import ANGLES, AREAS, FOLDED, fitting
from ..draw.plot import fit, pose
from ..draw.run import plot_run
from ..errors import DisplayError, import_optional
from ..io.replacing import make_folder, replacing
from ..maps.sphere_map import ROUNDS, SphereMap, map_findings, round_rows
from ..mesh.arrays import FloatArray
from ..mesh.check import Mesh
from ..mesh.measure import vertex_normals
from ..plane.plane_map import PlaneMap, plane_findings
from ..result.recording import Recording
from ..result.result import result_rows
from ..result.run import Stage, title_of
from ..verify.certificate import Certificate
from .viewer.app import present
from .viewer.choices import SUBJECTS
from .viewer.colouring import colouring
from .viewer.compare import plane_view
from .viewer.map_view import count_foldings
from .viewer.show import picture_of

_SIZE = (900, 470)  # pixels of a picture
_TURN = "Drag to turn, double-click to reset; click, then scroll to magnify what is in front."
_MARKS = "A dot marks folded faces that are too small to be seen, a ring those that lie behind."
_TOO_LARGE = "<p>A mesh of {:,} faces is too large to be turned in a page.</p>"
_CAPTIONS = {
    "foldings": "Folded faces are red; elsewhere the same colour is the same place.",
    "angle differences": "Mean size of the angle differences of each face.",
    "area distortion": "Logarithm of image area over source area of each face: purple where the map shrinks.",
    "checkerboard": "A checkerboard of the sphere, carried to the surface: squares stay squares where angles do.",
}


def write_report(
    place: str | os.PathLike[str], result: SphereMap, recording: Recording, *, source: str, command: str = "",
    up: str = "auto",
) -> Path:  # fmt: skip
    """Write a page, a file that ends in .html or `report.html` in a folder, made if it is missing; return its path.

    `source` names the surface, `command` is the command line that made the map, `up` says which way is up in
    the pictures. Needs matplotlib; without OpenGL the page says why it has no pictures.

    >>> import tempfile
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=300)
    >>> recording = Recording(f)
    >>> result = ism.spherical_conformal_map(v, f, listener=recording)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_report(folder, result, recording, source="spheroid").name
    'report.html'
    """
    mesh = result.mesh
    return _write_page(
        place,
        f"{source} on the sphere",
        result.certificate,
        command,
        [
            table(result_rows(result, map_findings(result))[1:]),
            "<h2>Rounds</h2>" + table(round_rows(result), ROUNDS) if result.rounds else "",
            "<h2>Before and after</h2>" if _began_folded(recording) else "<h2>The map</h2>",
            _scene(mesh, result.sphere, _began_folded(recording), up),
            "<h2>Pictures</h2>",
            *_pictures(mesh, result.sphere, recording, up),
            "<h2>Curves</h2>",
            _svg(
                plot_run(
                    recording.history,
                    recording.foldings,
                    result.angle_differences(),
                    result.log_area_ratios(),
                )
            ),
        ],
    )


def write_plane_report(
    place: str | os.PathLike[str],
    result: PlaneMap,
    *,
    source: str,
    command: str = "",
    up: str = "auto",
) -> Path:
    """`write_report` of a map to the plane."""
    disk = result.mesh
    return _write_page(
        place,
        f"{source} in the plane",
        result.certificate,
        command,
        [
            table(result_rows(result, plane_findings(result))[1:]),
            "<h2>The map</h2>",
            _plane_scene(result, up),
            "<h2>Pictures</h2>",
            *_drawn(
                [
                    lambda path: present(
                        lambda: plane_view(source, disk, result.plane, up), path, size=_SIZE
                    )
                ],
                [
                    "A checkerboard of the plane, carried to the surface: squares stay squares where angles do."
                ],
            ),
            "<h2>Angles and areas</h2>",
            _svg(result.plot()),
        ],
    )


def _write_page(
    place: str | os.PathLike[str],
    title: str,
    certificate: Certificate,
    command: str,
    parts: list[str],
) -> Path:
    verdict = "folded"
    if certificate.folding_free:
        verdict = "free"
    body = [
        f"<h1>{escape(title)}</h1>",
        made_by(command),
        f'<p class="verdict {verdict}">{escape(str(certificate))}</p>',
        *parts,
        "<h2>Versions</h2>",
        table(_versions()),
    ]
    path = page_file(place, "report.html")
    make_folder(path.parent)
    html = page(title, "\n".join(filter(None, body)))
    check_own_page(path)
    with replacing(path, force=True) as partial:
        partial.write_text(html, encoding="utf-8", errors="backslashreplace")
    return path


def _plane_scene(result: PlaneMap, up: str) -> str:
    """Surface and image coloured by area ratios, and the image by angle differences, to be turned."""
    disk, f, certificate = result.mesh, result.faces, result.certificate
    if len(f) > MOST_FACES:
        return _TOO_LARGE.format(len(f))
    ratios, differences = result.log_area_ratios(), np.abs(result.angle_differences()).mean(axis=1)
    angles, areas = fitting(ANGLES, differences), fitting(AREAS, ratios)
    folded = np.sort(np.concatenate((certificate.flipped, certificate.degenerate)))
    image = fit(result.image, np.eye(3))
    views = [
        View(caption, x, ramp.colours(values), folded, ramp, image=x is image)
        for caption, x, ramp, values in (
            ("Surface: areas", fit(disk.unit, pose(disk.unit, up)), areas, ratios),
            ("Image: areas", image, areas, ratios),
            ("Image: angles", image, angles, differences),
        )
    ]
    return f"{scene(f, views)}<p>{_TURN}</p>"


def _began_folded(recording: Recording) -> bool:
    """Whether a run began with the Gauss map, which folds most surfaces; others began with maps of their own."""
    return any(step.stage is Stage.GAUSS_MAP for step in recording.history[:1]) and bool(
        recording.foldings[0]
    )


def _scene(mesh: Mesh, sphere: FloatArray, before: bool, up: str) -> str:
    """Surface and result, to be turned, and between them the Gauss map if the run removed its foldings."""
    if len(mesh.f) > MOST_FACES:
        return _TOO_LARGE.format(len(mesh.f))
    turn = pose(mesh.unit, up)
    gauss = vertex_normals(mesh.unit, mesh.f)
    maps = []
    if before:
        maps.append(("Gauss map", gauss, colouring(mesh, gauss, SUBJECTS[0])))
    maps.append(("Result", sphere, colouring(mesh, sphere, SUBJECTS[0])))
    by = "folded by the Gauss map" if before else "folded"
    views = [
        View(
            "Surface",
            fit(mesh.unit, turn),
            maps[0][2].colours,
            maps[0][2].folded,
            (f"{by}; same colour: same place", FOLDED),
        )
    ]
    for name, x, colours in maps:
        views.append(
            View(
                f"{name}: {count_foldings(len(colours.folded))}",
                x @ turn.T,
                colours.colours,
                colours.folded,
                sphere=True,
                image=True,
            )
        )
    return f"{scene(mesh.f, views)}<p>{_TURN} {_MARKS}</p>"


def _pictures(mesh: Mesh, sphere: FloatArray, recording: Recording, up: str) -> list[str]:
    """The last iterate with foldings, and the result in the colours of each subject: what the scene does not show."""
    in_scene = len(mesh.f) <= MOST_FACES
    shots = [
        ("Result", sphere, subject)
        for subject in SUBJECTS
        if not (in_scene and subject == SUBJECTS[0])
    ]
    folded = [frame.iterate for frame in recording.frames if frame.foldings]
    if folded and folded[-1].stage is not Stage.GAUSS_MAP:
        shots.insert(0, (f"Last with foldings: {title_of(folded[-1])}", folded[-1].x, SUBJECTS[0]))
    if not in_scene and _began_folded(recording):
        shots.insert(0, ("Gauss map", vertex_normals(mesh.unit, mesh.f), SUBJECTS[0]))

    def draw(x: FloatArray, title: str, subject: str) -> Callable[[Path], object]:
        return lambda path: picture_of(mesh, {title: x}, path, subject=subject, up=up, size=_SIZE)

    return _drawn(
        [draw(x, title, subject) for title, x, subject in shots],
        [f"{title}. {_CAPTIONS[subject]}" for title, _, subject in shots],
    )


def _drawn(draws: Iterable[Callable[[Path], object]], captions: Iterable[str]) -> list[str]:
    """Pictures that functions of a path draw, or why there are none."""
    found = []
    try:
        for draw, caption in zip(draws, captions, strict=True):
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "picture.png"
                draw(path)
                found.append(picture(small_png(path), caption))
    except DisplayError as error:
        return [f"<p>No pictures: {escape(str(error))}</p>"]
    return found


def _svg(figure: Any) -> str:
    """A matplotlib figure as part of the page."""
    stream = io.StringIO()
    same_names = {"svg.hashsalt": "igl_spheremap"}
    with import_optional("matplotlib", "a report", "plot").rc_context(same_names):
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    text = stream.getvalue()
    return text[text.index("<svg") :]


def _versions() -> list[tuple[str, str]]:
    packages = ("libigl", "numpy", "scipy", "polyscope", "matplotlib")
    there = [name for name in packages if any(metadata.distributions(name=name))]
    return [
        ("python", platform.python_version()),
        ("system", f"{platform.system()} {platform.machine()}"),
        ("igl_spheremap", __version__),
        *((name, metadata.version(name)) for name in there),
    ]
