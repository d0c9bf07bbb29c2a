"""A page about a map: verdict, figures, pictures, curves, versions; one HTML file that needs no network."""

from __future__ import annotations

import io
import platform
import tempfile
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from html import escape
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from .._version import __version__
from ..draw.markup import MOST_FACES, View, picture, scene, small_png, table, top
from ..draw.palette import ANGLES, AREAS, FOLDED, fitting
from ..draw.plot import fit, pose
from ..draw.run import plot_run
from ..errors import DisplayError, import_optional
from ..gate import PathLike
from ..io.pages import page_file, write_page
from ..io.replacing import make_folder
from ..maps.sphere_map import ROUNDS, SphereMap, map_findings, round_rows
from ..mesh.arrays import FloatArray, IntArray
from ..mesh.check import Mesh
from ..mesh.measure import vertex_normals
from ..plane.plane_map import PlaneMap, plane_findings
from ..result.recording import Recording
from ..result.result import result_rows
from ..result.run import Stage, title_of
from ..verify.certificate import Certificate
from .viewer.app import present
from .viewer.choices import SUBJECTS
from .viewer.colouring import Colours
from .viewer.compare import plane_view
from .viewer.map_view import count_foldings
from .viewer.show import picture_of

_SIZE = (900, 470)  # pixels of a picture
_TURN = "Drag to turn, double-click to reset; click, then scroll to magnify what is in front."
_MARKS = "A dot marks folded faces that are too small to be seen, a ring those that lie behind."
_CAPTIONS = {
    "foldings": "Folded faces are red; elsewhere the same colour is the same place.",
    "angle differences": "Mean size of the angle differences of each face.",
    "area distortion": "Logarithm of image area over source area of each face: purple where the map shrinks.",
    "checkerboard": "A checkerboard of the sphere, carried to the surface: squares stay squares where angles do.",
}


def write_report(
    place: PathLike, result: SphereMap, recording: Recording, *, source: str, command: str = "",
    up: str = "auto",
) -> Path:  # fmt: skip
    """Write a page, a file that ends in .html or `report.html` in a folder, made if it is missing; return its path.

    `source` names the surface, `command` is the command line that made the map, `up` is the up direction of the
    pictures. Needs matplotlib; without OpenGL the page says why it has no pictures.

    >>> import tempfile
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=300)
    >>> recording = Recording(f)
    >>> result = ism.spherical_conformal_map(v, f, listener=recording)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_report(folder, result, recording, source="spheroid").name
    'report.html'
    """
    mesh, folded = result.mesh, _began_folded(recording)
    rounds, heading = [], "<h2>The map</h2>"
    if result.rounds:
        rounds = ["<h2>Rounds</h2>" + table(round_rows(result), ROUNDS)]
    if folded:
        heading = "<h2>Before and after</h2>"
    curves = plot_run(
        recording.history,
        recording.foldings,
        result.angle_differences(),
        result.log_area_ratios(),
    )
    return _write_report(
        place,
        f"{source} on the sphere",
        result.certificate,
        command,
        table(result_rows(result, map_findings(result))[1:]),
        *rounds,
        heading,
        _scene(mesh.f, _views(mesh, result.sphere, folded, up), f"{_TURN} {_MARKS}"),
        "<h2>Pictures</h2>",
        *_drawn(_pictures(mesh, result.sphere, recording, up)),
        "<h2>Curves</h2>",
        _svg(curves),
    )


def write_plane_report(
    place: PathLike,
    result: PlaneMap,
    *,
    source: str,
    command: str = "",
    up: str = "auto",
) -> Path:
    """`write_report` of a map to the plane."""

    def draw(path: Path) -> None:
        present(lambda: plane_view(source, result.mesh, result.plane, up), path, size=_SIZE)

    caption = (
        "A checkerboard of the plane, carried to the surface: squares stay squares where angles do."
    )
    return _write_report(
        place,
        f"{source} in the plane",
        result.certificate,
        command,
        table(result_rows(result, plane_findings(result))[1:]),
        "<h2>The map</h2>",
        _scene(result.faces, _plane_views(result, up), _TURN),
        "<h2>Pictures</h2>",
        *_drawn([(caption, draw)]),
        "<h2>Angles and areas</h2>",
        _svg(result.plot()),
    )


def _write_report(
    place: PathLike, title: str, certificate: Certificate, command: str, *parts: str
) -> Path:
    """Write a page with a verdict, these parts, and the versions of its programs; return its path."""
    verdict = "folded"
    if certificate.folding_free:
        verdict = "free"
    path = page_file(place, "report.html")
    make_folder(path.parent)
    write_page(
        path,
        title,
        top(title, command),
        f'<p class="verdict {verdict}">{escape(str(certificate))}</p>',
        *parts,
        "<h2>Versions</h2>",
        table(_versions()),
    )
    return path


def _scene(f: IntArray, views: Iterator[View], said: str) -> str:
    """Views of the same faces, to be turned, unless there are too many for a page."""
    if len(f) > MOST_FACES:
        return f"<p>A mesh of {len(f):,} faces is too large to be turned in a page.</p>"
    return f"{scene(f, list(views))}<p>{said}</p>"


def _plane_views(result: PlaneMap, up: str) -> Iterator[View]:
    """Surface and image coloured by area ratios, and the image by angle differences."""
    disk, certificate = result.mesh, result.certificate
    ratios, differences = result.log_area_ratios(), np.abs(result.angle_differences()).mean(axis=1)
    angles, areas = fitting(ANGLES, differences), fitting(AREAS, ratios)
    folded = np.sort(np.concatenate((certificate.flipped, certificate.degenerate)))
    image = fit(result.image, np.eye(3))
    for caption, x, ramp, values in (
        ("Surface: areas", fit(disk.unit, pose(disk.unit, up)), areas, ratios),
        ("Image: areas", image, areas, ratios),
        ("Image: angles", image, angles, differences),
    ):
        yield View(caption, x, ramp.colours(values), folded, ramp, image=x is image)


def _began_folded(recording: Recording) -> bool:
    """Whether a run began with the Gauss map, which folds most surfaces; others began with maps of their own."""
    return any(step.stage is Stage.GAUSS_MAP for step in recording.history[:1]) and bool(
        recording.foldings[0]
    )


def _views(mesh: Mesh, sphere: FloatArray, before: bool, up: str) -> Iterator[View]:
    """Surface and result; if the run removed foldings of the Gauss map, this between them."""
    turn, maps = pose(mesh.unit, up), [("Result", sphere)]
    if before:
        maps.insert(0, ("Gauss map", vertex_normals(mesh.unit, mesh.f)))
    coloured = [(name, x, Colours(SUBJECTS[0]).of(mesh, x)) for name, x in maps]
    first = coloured[0][2]
    (legend,) = first.legends
    if before:
        legend = ("folded by the Gauss map; same colour: same place", FOLDED)
    yield View("Surface", fit(mesh.unit, turn), first.colours, first.folded, legend)
    for name, x, colours in coloured:
        caption = f"{name}: {count_foldings(len(colours.folded))}"
        yield View(caption, x @ turn.T, colours.colours, colours.folded, sphere=True, image=True)


def _pictures(
    mesh: Mesh, sphere: FloatArray, recording: Recording, up: str
) -> Iterator[tuple[str, Callable[[Path], object]]]:
    """Pictures beyond the scene: the last iterate with foldings, and the result in the colours of each subject.

    Each is a caption, and a function that draws it to a path.
    """

    def shot(title: str, x: FloatArray, subject: str) -> tuple[str, Callable[[Path], object]]:
        draw = partial(picture_of, mesh, {title: x}, subject=subject, up=up, size=_SIZE)
        return f"{title}. {_CAPTIONS[subject]}", draw

    shown = len(mesh.f) <= MOST_FACES
    folded = [frame.iterate for frame in recording.frames if frame.foldings]
    if not shown and _began_folded(recording):
        yield shot("Gauss map", vertex_normals(mesh.unit, mesh.f), SUBJECTS[0])
    if folded and folded[-1].stage is not Stage.GAUSS_MAP:
        yield shot(f"Last with foldings: {title_of(folded[-1])}", folded[-1].x, SUBJECTS[0])
    for subject in SUBJECTS:
        if not shown or subject != SUBJECTS[0]:
            yield shot("Result", sphere, subject)


def _drawn(pictures: Iterable[tuple[str, Callable[[Path], object]]]) -> list[str]:
    """Pictures, each of a caption and a function that draws it to a path, or why there are none."""
    found = []
    try:
        for caption, draw in pictures:
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
