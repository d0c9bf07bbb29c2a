"""Videos: as many pictures as were written, each as long as asked, folded faces red after compression."""

import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from igl_spheremap.apps.viewer import window
from igl_spheremap.apps.viewer.window import check_video, open_video
from igl_spheremap.draw.palette import BACKGROUND, FOLDED
from igl_spheremap.errors import FileError

_HELD = [20, 1, 5, 20]


def _picture(k):
    """A red square at the k-th place, on a background of odd size."""
    image = np.tile(np.array(BACKGROUND), (121, 203, 1))
    image[40:80, 30 * k : 30 * k + 30] = FOLDED
    return np.rint(255 * image).astype(np.uint8)


def _red(image):
    r, g, b = (image[..., k].astype(int) for k in range(3))
    return np.argwhere((r > 150) & (g < 110) & (b < 90))


def _write(path):
    check_video(path)
    with open_video(path, 20) as write:
        for k, times in enumerate(_HELD):
            write(_picture(k), times)


def test_an_mp4_holds_each_picture_as_long_as_asked(tmp_path):
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    path = tmp_path / "run.mp4"
    _write(path)
    frames = ffmpeg.read_frames(str(path))
    facts = next(frames)
    width, height = facts["size"]
    assert (width, height, facts["fps"]) == (202, 120, 20.0)  # the codec takes even sizes only
    shown = [
        _red(np.frombuffer(frame, dtype=np.uint8).reshape(height, width, 3)) for frame in frames
    ]
    places = np.repeat(np.arange(len(_HELD)), _HELD)
    assert len(shown) == len(places)
    for k, red in zip(places, shown, strict=True):
        assert len(red) == pytest.approx(1200, rel=0.1)
        assert red.mean(axis=0) == pytest.approx([59.5, 30 * k + 14.5], abs=1)


def test_a_gif_holds_each_picture_as_long_as_asked(tmp_path):
    images = pytest.importorskip("PIL.Image")
    path = tmp_path / "run.gif"
    _write(path)
    with images.open(path) as video:
        assert video.n_frames == len(_HELD)
        for k, times in enumerate(_HELD):
            video.seek(k)
            assert video.info["duration"] == 50 * times
            assert len(_red(np.asarray(video.convert("RGB")))) == 1200


def test_panels_stay_grey_and_folded_faces_red_in_a_gif_of_light_colours(tmp_path):
    images = pytest.importorskip("PIL.Image")
    path = tmp_path / "run.gif"
    image = np.random.default_rng(1).integers(224, 256, (200, 300, 3), dtype=np.uint8)
    image[:, :20] = 240
    image[:20, 100:120] = np.rint(255 * np.array(FOLDED))
    with open_video(path, 20) as write:
        write(image, 1)
    with images.open(path) as video:
        shown = np.asarray(video.convert("RGB"))
    assert (shown[:, :20] == 240).all()
    assert len(_red(shown[:20, 100:120])) == 400


def test_a_video_is_a_file_of_a_known_kind(tmp_path):
    for name in ("file", "run.avi", "pictures/"):
        with pytest.raises(FileError, match=r"a video is a .gif or .mp4 file"):
            check_video(tmp_path / name)


@pytest.mark.parametrize("name", ["a.png", "a.jpg"])
def test_a_picture_that_a_full_disk_cut_off_is_an_error(name, tmp_path, monkeypatch):
    cut_off = SimpleNamespace(screenshot=lambda path, **_: Path(path).write_bytes(b"\x89PNG"))
    monkeypatch.setattr(window, "ps", cut_off)  # which reports nothing
    monkeypatch.setattr(window, "_settle", lambda: None)
    with pytest.raises(FileError, match="No space left"):
        window.save(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.posix
def test_the_ffmpeg_of_the_environment_comes_before_that_of_the_path(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    for name in ("ffmpeg", "mine"):
        (tmp_path / name).write_text("#!/bin/sh\nexit 1\n")
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert window.ffmpeg() == str(tmp_path / "ffmpeg")
    monkeypatch.setenv("IMAGEIO_FFMPEG_EXE", str(tmp_path / "mine"))
    assert window.ffmpeg() == str(tmp_path / "mine")
    with pytest.raises(FileError, match="ffmpeg wrote no"):
        _write(tmp_path / "run.mp4")
    assert not (tmp_path / "run.mp4").exists()
    monkeypatch.delenv("IMAGEIO_FFMPEG_EXE")
    monkeypatch.setenv("PATH", "")
    with pytest.raises(FileError, match=r"pip install imageio.ffmpeg"):
        check_video(tmp_path / "run.mp4")


def test_an_mp4_needs_the_extra_video_alone(tmp_path, monkeypatch):
    pytest.importorskip("imageio_ffmpeg")
    monkeypatch.setitem(sys.modules, "PIL.Image", None)
    _write(tmp_path / "run.mp4")
    with pytest.raises(FileError, match="pillow"):
        check_video(tmp_path / "run.gif")
