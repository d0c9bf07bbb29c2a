"""Reports, plots, and results in notebooks."""

import base64
import ctypes
import json
import os
import re
import sys
from argparse import Namespace
from html.parser import HTMLParser

import numpy as np
import pytest
from disks import half
from drawing import command, needs_drawing
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.exits import UsageError
from igl_spheremap.apps.cli.output import check_report
from igl_spheremap.apps.report import write_report
from igl_spheremap.apps.viewer import window
from igl_spheremap.draw.markup import View, page, scene, table
from igl_spheremap.draw.palette import FOLDED, SURFACE
from igl_spheremap.errors import DisplayError
from igl_spheremap.io.pages import page_file
from igl_spheremap.verify.distortion import angle_figures
from igl_spheremap.verify.signs import folded_faces

pytest.importorskip("matplotlib", reason="matplotlib is not installed")


@pytest.fixture(scope="module")
def result():
    v, f = ism.samples.make("dino", n_vertices=1500)
    return ism.spherical_conformal_map(v, f)


class Balance(HTMLParser):
    """Every tag that opens closes, in order."""

    VOID = ("meta", "img", "br")

    def __init__(self, text):
        super().__init__()
        self.open, self.seen = [], []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.seen.append((tag, dict(attributes)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_pages_escape_what_they_are_given():
    text = page("<title>", table([("<b>", "a & b")], header=("<i>", "x")))
    tags = [tag for tag, _ in Balance(text).seen]
    assert "b" not in tags
    assert "i" not in tags
    assert "a &amp; b" in text


def test_notebooks_see_the_figures_of_the_result(result):
    text = result._repr_html_()
    Balance(text)
    assert f"{len(result.vertices):,} vertices" in text
    assert f"{angle_figures(result.angle_differences())['mean']:.3g} degrees" in text
    assert str(result.certificate) in text


def test_the_plot_shows_the_history_and_every_angle(result):
    figure = result.plot()
    energy, *histograms = figure.axes
    (line,) = energy.get_lines()[:1]
    assert len(line.get_ydata()) == len(result.history)
    for histogram, of in zip(histograms, ("corners", "faces"), strict=True):
        (bars,) = histogram.patches
        shares = bars.get_data().values
        assert shares.sum() == pytest.approx(100)
        assert min(shares[0], shares[-1]) >= 0.25  # those at the ends hold what lies beyond
        assert histogram.get_ylabel().startswith(f"percent of the {of}")
        assert histogram.get_xlabel()
    assert figure._repr_png_().startswith(b"\x89PNG")


@needs_drawing
def test_the_report_is_one_page_without_a_network(tmp_path):
    command(
        "map",
        "sample:dino:n_vertices=1200",
        tmp_path / "out.obj",
        "--method",
        "lai2014",
        "--report",
        tmp_path / "report",
        "--json",
        tmp_path / "figures.json",
    )
    text = (tmp_path / "report" / "report.html").read_text("utf-8")
    assert [path.name for path in (tmp_path / "report").iterdir()] == ["report.html"]
    tags = Balance(text).seen
    links = [
        value
        for _, attributes in tags
        for name, value in attributes.items()
        if name in ("src", "href", "srcset")
    ]
    assert all(link.startswith(("data:", "#")) for link in links)
    assert not re.search(r"@import|url\((?!#)", text)
    pictures = [attributes["src"] for tag, attributes in tags if tag == "img"]
    assert len(pictures) == len(set(pictures)) == 4
    for picture in pictures:
        assert base64.b64decode(picture.partition(",")[2]).startswith(b"\x89PNG")
    assert sum(tag == "svg" for tag, _ in tags) == 1
    assert "folding-free: every face is positively oriented" in text
    header = text.partition('<p class="made">')[2].partition("</p>")[0]
    assert re.match(
        rf"\d{{4}}-\d\d-\d\d \d\d:\d\d UTC, igl_spheremap {ism.__version__}<br>", header
    )
    assert (
        f"igl-spheremap map sample:dino:n_vertices=1200 {tmp_path / 'out.obj'} --method lai2014"
        in header
    )
    assert len(text) < 1_500_000


@needs_drawing
@pytest.mark.parametrize("name", ["disk", "flatten"])
def test_the_report_of_a_plane_map_has_its_figures_and_a_scene(tmp_path, name):
    v, f, _ = half(*icosphere(3))
    ism.write_mesh(tmp_path / "<face>.ply", v, f)
    command(name, tmp_path / "<face>.ply", tmp_path / "out.obj", "--report", tmp_path / "page.html")
    text = (tmp_path / "page.html").read_text("utf-8")
    tags = Balance(text).seen
    assert [tag for tag, _ in tags].count("svg") == 1
    assert [attributes["src"][:21] for tag, attributes in tags if tag == "img"] == [
        "data:image/png;base64"
    ]
    (views,) = [
        json.loads(attributes["data-scene"])["views"]
        for _, attributes in tags
        if "data-scene" in attributes
    ]
    assert [view["caption"] for view in views] == [
        "Surface: areas",
        "Image: areas",
        "Image: angles",
    ]
    colours = [
        np.frombuffer(base64.b64decode(view["colours"]), np.uint8).reshape(-1, 3) for view in views
    ]
    assert all(len(each) == len(f) for each in colours)
    areas, _, angles = (
        re.findall(r"[\w./ ]+(?= <span)|(?<=</span>)[\w./ ]+", view["legend"]) for view in views
    )
    assert float(areas[0].partition("/")[2]) == float(areas[1]) > 1
    assert angles[0].strip() == "0"
    assert np.array_equal(*colours[:2])
    assert (
        "folding-free: every face is positively oriented and the boundary crosses itself nowhere"
        in text
    )
    assert "<h1>&lt;face&gt;.ply in the plane</h1>" in text
    assert "Before" not in text  # there is one map
    assert f"igl-spheremap {name} " in text


def test_a_scene_has_every_folded_face_and_its_marks():
    """Those of a cluster side by side; none where folded faces cover much of the sphere."""
    v, f = icosphere(3)
    flipped = v.copy()
    pairs = f[[0, 1000], :2]
    flipped[pairs] = v[pairs[:, ::-1]]
    for x, few in ((flipped, True), (-v, False)):
        folded = np.flatnonzero(folded_faces(x, f))
        text = scene(
            f, [View("a sphere", x, np.ones((len(f), 3)), folded, sphere=True, image=True)]
        )
        (view,) = json.loads(dict(Balance(text).seen[0][1])["data-scene"])["views"]
        kept, starts = (
            np.frombuffer(base64.b64decode(view[key]), "<u4") for key in ("folded", "starts")
        )
        colours = np.frombuffer(base64.b64decode(view["colours"]), np.uint8).reshape(-1, 3)
        assert np.array_equal(kept, folded)
        assert np.array_equal(np.flatnonzero((colours != 255).any(axis=1)), folded)
        assert len(starts) == (2 if few else 0)
        outward = np.frombuffer(base64.b64decode(view["outward"]), "<f4").reshape(-1, 3)
        assert len(outward) == (len(folded) if few else 0)


@needs_drawing
@pytest.mark.parametrize(("name", "colour"), [("pear", SURFACE), ("dumbbell", FOLDED)])
def test_the_legend_of_a_report_names_the_colour_of_foldings_if_there_are_any(
    tmp_path, name, colour
):
    """The Gauss map, at which the run begins, folds the dumbbell alone."""
    path = tmp_path / "report.html"
    surface = f"sample:{name}:n_vertices=300"
    command("map", surface, tmp_path / "a.npz", "--method", "lai2014", "--report", path)
    legend = re.search(r"rgb\(([\d ]+)\)[^(]*same colour: same place", path.read_text("utf-8"))
    assert np.array(legend[1].split(), int) == pytest.approx(255 * np.array(colour), abs=1)


@pytest.mark.parametrize("name", ["page.pdf", "out.obj", "there"])
def test_a_report_is_a_page_or_a_folder(tmp_path, name, capsys):
    """Said before the work starts."""
    (tmp_path / "there").write_text("a file")
    words = [
        "map",
        "sample:sphere:n_vertices=200",
        str(tmp_path / "out.obj"),
        "--report",
        str(tmp_path / name),
    ]
    assert main(words) == 64
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["there"]


@pytest.mark.parametrize("place", ["mine.html", "folder"])
def test_a_page_that_no_report_wrote_is_kept(tmp_path, place, capsys):
    """Though it quotes a report's first lines; said before the work starts. An earlier report is replaced."""
    path = page_file(tmp_path / place, "report.html")
    path.parent.mkdir(exist_ok=True)
    for mine in ("<h1>Mine</h1>", f"<pre>{page('a', 'b')}</pre>"):
        path.write_text(mine)
        words = ["map", "sample:sphere:n_vertices=60", str(tmp_path / "out.obj")]
        assert main([*words, "--report", str(tmp_path / place)]) > 0
        assert "is kept" in capsys.readouterr().err
        assert path.read_text() == mine
        assert not (tmp_path / "out.obj").exists()
    path.write_text(page("a", "b"))
    assert check_report(Namespace(report=str(tmp_path / place), json=None)) is None


def test_a_report_goes_into_a_folder_that_is_there(tmp_path):
    """Again and again; a file of the name of an output is refused."""
    assert check_report(Namespace(report=str(tmp_path))) is None
    assert page_file(tmp_path, "report.html") == tmp_path / "report.html"
    assert page_file(f"{tmp_path}/v1.2/", "report.html") == tmp_path / "v1.2" / "report.html"
    page = str(tmp_path / "x.HTML")
    with pytest.raises(UsageError, match="would be lost"):
        check_report(Namespace(report=page, json=page))


def test_a_report_without_opengl_names_why_it_has_no_pictures(tmp_path, monkeypatch):
    def missing(name):
        raise OSError(name)

    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(ctypes, "CDLL", missing)
    monkeypatch.setattr(window, "_offscreen", None)  # as in a process that has drawn nothing
    words = [
        "map",
        "sample:sphere:n_vertices=200",
        str(tmp_path / "out.obj"),
        "--report",
        str(tmp_path / "report"),
    ]
    assert main([*words, "-q"]) == 0
    assert "No pictures: libEGL.so.1 is missing" in (tmp_path / "report" / "report.html").read_text(
        "utf-8"
    )


@pytest.mark.parametrize(("name", "start"), [("a.png", b"\x89PNG"), ("a.svg", b"<?xml")])
def test_curves_are_drawn_in_the_format_that_is_named(tmp_path, name, start):
    words = [
        "map",
        "sample:sphere:n_vertices=200",
        str(tmp_path / "out.obj"),
        "--plot",
        str(tmp_path / name),
    ]
    assert main([*words, "-q"]) == 0
    assert (tmp_path / name).read_bytes().startswith(start)


def test_a_plot_of_no_known_format_is_refused_before_the_work(tmp_path, capsys):
    words = [
        "map",
        "sample:sphere:n_vertices=200",
        str(tmp_path / "out.obj"),
        "--plot",
        str(tmp_path / "a.doc"),
    ]
    assert main(words) == 64
    assert len(capsys.readouterr().err.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


@needs_drawing
def test_view_draws_a_map_that_is_given(tmp_path):
    source, sphere = "sample:dino:n_vertices=1200", tmp_path / "sphere.npz"
    assert main(["map", source, str(sphere), "-q"]) == 0
    pictures = [tmp_path / f"{k}.png" for k in range(2)]
    for picture, words in zip(pictures, ([source, sphere], [sphere]), strict=True):
        command("view", *words, "--screenshot", picture, "--show", "angles")
        assert picture.stat().st_size > 20_000


def test_view_without_a_display_is_one_line(monkeypatch, capsys):
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(window, "_offscreen", None)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert main(["view", "sample:sphere"]) == 71
    err = capsys.readouterr().err
    assert len(err.splitlines()) == 1
    assert "(--screenshot OUT.png, --video OUT.gif)" in err
    result = ism.spherical_conformal_map(*ism.samples.sphere(42))
    with pytest.raises(
        DisplayError, match=r"\(screenshot\(result, 'map.png'\), play\(v, f, out='run.gif'\)\)"
    ):
        ism.show(result)


def test_a_report_that_cannot_be_written_leaves_the_one_before(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise DisplayError("no screen")

    # pictures take a process of their own
    monkeypatch.setattr("igl_spheremap.apps.report.picture_of", refuse)
    v, f = ism.samples.make("spheroid", n_vertices=300)
    recording = ism.Recording(f)
    result = ism.spherical_conformal_map(v, f, listener=recording)
    write_report(tmp_path, result, recording, source="first")
    before = (tmp_path / "report.html").read_bytes()

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", full)  # the last step of writing
    with pytest.raises(ism.FileError, match=r"report.html: No space left"):
        write_report(tmp_path, result, recording, source="second")
    assert (tmp_path / "report.html").read_bytes() == before
    assert os.listdir(tmp_path) == ["report.html"]
