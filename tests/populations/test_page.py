"""The page of a population shows every map, the worst first, and folded faces in vermilion."""

import json
import os
import re
from concurrent.futures import ThreadPoolExecutor
from html import unescape
from pathlib import Path

import numpy as np
import pytest

from igl_spheremap import __version__
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.exits import Exit
from igl_spheremap.draw.palette import diverging
from igl_spheremap.errors import FileError
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.pictures import read_picture
from igl_spheremap.io.write_mesh import write_mesh
from igl_spheremap.maps.options import Auto
from igl_spheremap.populations.engine import Engine
from igl_spheremap.populations.job import Job, run_job
from igl_spheremap.populations.map_many import map_many
from igl_spheremap.populations.mapping import SphereMapping
from igl_spheremap.populations.page import area_ramp, draw_row, map_sheet, write_population_page
from igl_spheremap.populations.table import Row, plain, worst_first

pytest.importorskip("PIL")


def test_every_map_has_its_picture_and_its_page(desk, monkeypatch):
    sources = ["100.ply", "open.ply", "400.ply"]
    rows = mapped_here(sources, report="page")
    html = Path("page/index.html").read_text("utf-8")
    maps = cards(html)
    pictures = [one["picture"] for one in maps if one["picture"]]
    assert (len(maps), len(pictures)) == (3, 2)
    assert "2 of 3 maps are certified" in html
    assert maps[0]["row"]["source"] == "open.ply"
    assert "open surface" in maps[0]["row"]["notes"]
    assert maps[1]["row"] == plain(
        next(row for row in rows if row.source == maps[1]["row"]["source"])
    )
    assert len({one["key"] for one in maps}) == 3
    image = read_picture(Path("page", pictures[0]))
    assert image.shape[1] == 4 * image.shape[0]
    assert vermilion(image) == 0

    times = [os.stat(Path("page", name)).st_mtime_ns for name in pictures]
    assert mapped_here(sources, report="page")[0].resumed
    assert times == [os.stat(Path("page", name)).st_mtime_ns for name in pictures]
    assert rows[0].status == "certified"


def mapped_here(sources, target="{stem}.obj", **options):
    """`map_many` without a worker process."""
    with ThreadPoolExecutor(1) as executor:
        return map_many(sources, target, engine=Engine(executor=executor, processes=1), **options)


def cards(html):
    """The page's data of each map."""
    return json.loads(html.partition('class="cards">')[2].partition("</script>")[0])["cards"]


def vermilion(image):
    """Share of pixels of the colour of folded faces."""
    r, g, b = (image[..., k].astype(float) for k in range(3))
    return float(((r > 150) & (g < 0.4 * r) & (b < 0.1 * r)).mean())


def test_folded_faces_are_seen(desk):
    options = SphereMapping(Auto(), 0.0, None, force=False, folder=os.getcwd())
    row = run_job(Job("400.ply", "400.obj"), options).row
    x, f = read_mesh("400.obj")
    write_mesh("400.obj", x * np.where(np.arange(len(x)) % 50 == 0, -1, 1)[:, None], f, force=True)
    assert draw_row(row, "400.png", diverging("", 2.0), options)
    assert vermilion(read_picture("400.png")) > 0.01


def test_the_worst_come_first():
    good = [Row(f"good {angle}", "", mean_angle=angle) for angle in (0.9, 1.0, 1.1)]
    bad = [
        Row("bent", "", mean_angle=30.0),
        Row("folded", "", "folded", foldings=2),
        Row("none", "", "no mesh"),
    ]
    rows = [*good, *bad]
    assert [rows[k].source for k in worst_first(rows)][:3] == ["none", "folded", "bent"]


def test_a_population_without_maps_has_a_page(desk):
    for sources in ([], ["open.ply"]):
        assert len(mapped_here(sources, report="page")) == len(sources)
        assert f"0 of {len(sources)} maps are certified" in Path("page/index.html").read_text()


def test_a_page_of_others_is_kept(desk):
    os.mkdir("page")
    quoting = "<p>Pages of batch begin with <code><!DOCTYPE html>\n<!-- igl_spheremap --></code>"
    for mine in ("precious", "", quoting):
        Path("page/index.html").write_text(mine)
        with pytest.raises(FileError, match="is not a page of an earlier report"):
            map_many(["100.ply"], "{stem}.obj", engine=Engine(processes=1), report="page")
        assert Path("page/index.html").read_text() == mine
    assert not Path("100.obj").exists()


@pytest.mark.posix
def test_a_link_among_the_pictures_is_not_followed(desk):
    mapped_here(["100.ply"], report="page")
    (picture,) = Path("page/subjects").iterdir()
    Path("thesis.tex").write_text("precious")
    for newer in (False, True):
        picture.unlink()
        picture.symlink_to(Path("thesis.tex").absolute())
        os.utime("thesis.tex", (2e9, 2e9) if newer else (1e9, 1e9))
        mapped_here(["100.ply"], report="page")
        assert Path("thesis.tex").read_text() == "precious"
        assert read_picture(picture).size > 0
        assert not picture.is_symlink()
    picture.unlink()
    Path("page/subjects").rmdir()
    Path("page/subjects").symlink_to(Path().absolute())
    with pytest.raises(FileError, match="is a link"):
        mapped_here(["100.ply"], report="page")


def test_names_are_text_and_not_markup(desk):
    os.rename("100.ply", name := "<b>&'.ply")
    mapped_here([name], "x.obj", report="page")
    assert "<b>&" not in Path("page/index.html").read_text("utf-8")


def test_colours_reach_as_far_as_most_of_the_maps_do():
    """By a few steps: areas that are nearly kept are pale in all populations."""

    def reach(size):
        return area_ramp(
            [Row("", "", mean_area=size * factor) for factor in (0.9, 1.0, 1.0, 1.0, 50.0, np.nan)]
        ).high

    for size in (1.0, 3.0):
        assert size <= reach(size) <= 2.5 * size
    assert reach(0.15) == reach(0.01) == area_ramp([]).high > 0


def test_hemispheres_are_seen_from_their_side_first(desk):
    """Faces folded on the left of the head are red in the first view of a left hemisphere, the last of a right one."""
    for side in ("lh", "rh"):
        v, f = read_mesh("400.ply")
        write_mesh(f"{side}.white.ply", v, f)
        options = SphereMapping(Auto(), 0.0, None, force=False, folder=os.getcwd())
        row = run_job(Job(f"{side}.white.ply", f"{side}.obj"), options).row
        x, _ = read_mesh(f"{side}.obj")
        left = f[np.argsort(v[f, 0].mean(axis=1))[:9]]
        x[np.unique(left)] *= -1
        write_mesh(f"{side}.obj", x, f, force=True)
        assert draw_row(row, f"{side}.png", diverging("", 2.0), options)
        image = read_picture(f"{side}.png")
        first, last = (
            vermilion(image[:, start : start + len(image)]) for start in (0, 2 * len(image))
        )
        assert (first > 2 * last) == (side == "lh")


def test_the_page_says_when_by_which_version_and_how_it_was_made(desk):
    words = "batch 100.ply open.ply --out {stem}.obj --report page --jobs 1 --quiet"
    assert main(words.split()) == Exit.NO_MESH
    html = Path("page/index.html").read_text("utf-8")
    made = html.partition('<p class="made">')[2].partition("</p>")[0]
    assert re.match(rf"\d{{4}}-\d\d-\d\d \d\d:\d\d UTC, igl_spheremap {__version__}<br>", made)
    assert f"igl-spheremap {words}" in unescape(made).replace("'", "")
    assert "--repair" in html  # hints on the page of the shell are flags
    assert "repair_mesh" not in html


def test_a_page_that_ends_in_html_is_one_file(desk):
    mapped_here(["100.ply"], report="maps.html")
    assert cards(Path("maps.html").read_text("utf-8"))[0]["picture"].startswith(
        "data:image/png;base64,"
    )
    assert not Path("subjects").exists()
    with pytest.raises(ValueError, match=r"maps.pdf: give a file that ends in .html, or a folder"):
        map_many(["100.ply"], "{stem}.obj", engine=Engine(processes=1), report="maps.pdf")


def test_outliers_are_in_a_bar_of_their_own_and_say_why(desk):
    """And the bars hold every map once."""
    angles = [*np.linspace(1, 2, 12), 20.0]
    rows = [
        Row(f"here/sub-{k}_x.ply", f"{k}.obj", "failed", mean_angle=angle)
        for k, angle in enumerate(angles)
    ]
    options = SphereMapping(Auto(), 0.0, None, force=False, folder=os.getcwd())
    html = write_population_page("a.html", rows, map_sheet(rows, options), 1).read_text("utf-8")
    bars = re.findall(r'data-figure="mean_angle" data-low="([\d.]+)" data-high="([\d.]*)"', html)
    held = [
        [row.source for row in rows if float(low) <= row.mean_angle < float(high or np.inf)]
        for low, high in bars
    ]
    assert sorted(source for bar in held for source in bar) == sorted(row.source for row in rows)
    assert held[-1] == ["here/sub-12_x.ply"]
    reasons = {one["row"]["source"]: one["reasons"] for one in cards(html)}
    assert reasons.pop("here/sub-12_x.ply") == [f"mean angle 20 > {float(bars[-1][0]):.3g}"]
    assert set(map(len, reasons.values())) == {0}
    assert "in here/ that end in .ply" in html
    assert cards(html)[0]["name"] == "sub-12_x"
