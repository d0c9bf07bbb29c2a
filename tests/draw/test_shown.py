"""Results in notebooks: pictures that any reader of PNG files decodes, red only at folded faces."""

import base64
import io
import re

import numpy as np
import pytest
from disks import half

import igl_spheremap as ism
from igl_spheremap.draw.plot import pose
from igl_spheremap.resampling.locate import Location
from igl_spheremap.shapes.correspondence.surface_map import SurfaceMap
from igl_spheremap.shapes.groups.group import Group, Member
from igl_spheremap.shapes.groups.series import Series

images = pytest.importorskip("PIL.Image", reason="Pillow is not installed")
V, F = ism.samples.sphere(642)
BALL = ism.sphere_map(V, F, V)


@pytest.fixture(autouse=True)
def small(monkeypatch):
    """Pictures of a tenth of the pixels."""
    monkeypatch.setattr("igl_spheremap.draw.shown._SIZE", 96)


def shown(result):
    """The pixels of the picture, and its caption."""
    text = result._repr_html_()
    assert "<table>" in text
    data = base64.b64decode(re.search('src="data:image/png;base64,([^"]+)"', text)[1])
    with images.open(io.BytesIO(data)) as image:
        image.load()
        return np.asarray(image), re.search("<figcaption>(.*)</figcaption>", text)[1]


def red(pixels):
    """Places of vermilion, in columns and rows: no scale of colours has it, in whatever light."""
    r, g, b = np.moveaxis(pixels.astype(int), -1, 0)
    return np.argwhere((r > 2 * g) & (r > 2 * b))


@pytest.mark.parametrize("side", [1, -1])
def test_red_is_where_faces_are_folded_and_nowhere_else(side):
    def stop(_):
        raise StopIteration

    towards = side * pose(V)[2]
    tip = int(np.argmax(V @ towards))
    x = V.copy()
    star = F[(tip == F).any(axis=1)]
    x[tip] = 2 * V[star[0]].sum(axis=0) - 5 * V[tip]  # out of its star, through a side
    folded = ism.algorithm_1(V, F, start=x, method=ism.Lai2014(gauge="free"), listener=stop)
    assert 0 < folded.certificate.foldings < 12
    pixels, caption = shown(folded)
    height, width = pixels.shape[:2]
    assert width == 2 * height
    assert f"{folded.certificate.foldings} folded faces are red" in caption
    for panel in np.split(pixels, 2, axis=1):
        assert len(red(panel)) > 0 if side == 1 else len(red(panel)) == 0
        assert np.abs(red(panel) - height / 2).max(initial=0) < height / 4


def test_the_same_map_gives_the_same_picture():
    first, again = (shown(ism.sphere_map(V, F, V))[0] for _ in range(2))
    assert np.array_equal(first, again)
    assert not len(red(first))


def group():
    """Balls of three sizes."""
    shapes, one = np.multiply.outer([0.9, 1.0, 1.1], V), np.ones(len(V))
    members = tuple(Member(str(k), None, 1.0, 1.0, 1.0) for k in range(3))
    return Group(
        V,
        F,
        V,
        shapes,
        V[None],
        np.array([0.01]),
        np.array([[-0.1], [0], [0.1]]),
        members,
        one,
        0.1 * one,
        np.empty((len(V), 0)),
        np.empty((len(V), 0)),
        {},
        (),
    )


def series():
    """A ball that doubles."""
    return Series(
        np.array([V, 2 * V]),
        F,
        V,
        np.ones((2, len(V))),
        np.empty((2, len(V), 0)),
        (BALL, BALL),
        V[:, 0],
    )


@pytest.mark.parametrize(
    ("make", "bodies"),
    [
        (lambda: ism.flatten(*half(V, F)[:2]), 2),
        (lambda: ism.resample(BALL, "ico:2"), 2),
        (lambda: ism.shapes.spherical_harmonics(BALL, degree=4), 3),
        (lambda: ism.shapes.spherical_harmonics(BALL, V[:, :2], degree=4), 1),
        (
            lambda: SurfaceMap(
                BALL, BALL, np.array([0]), Location(np.array([0]), np.array([[1.0, 0, 0]]))
            ),
            2,
        ),
        (group, 3),
        (series, 2),
    ],
)
def test_every_body_is_in_the_picture(make, bodies):
    pixels, _ = shown(make())
    assert pixels.shape[1] == bodies * pixels.shape[0]
    middle = pixels[len(pixels) // 2, len(pixels) // 2 :: len(pixels)]
    assert (middle < 255).any(axis=1).all()
    assert (pixels[[0, -1], [0, -1]] == 255).all()
