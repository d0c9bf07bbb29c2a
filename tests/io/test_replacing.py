"""Files appear whole or not at all."""

from __future__ import annotations

import os
import re
import socket
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from file_names import ALL, needs

from igl_spheremap import FileError
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.replacing import make_folder, remove_partial_files, replacing
from igl_spheremap.io.write_mesh import write_mesh


def test_nothing_is_overwritten_without_force(ball, tmp_path):
    path = tmp_path / "ball.obj"
    path.write_text("precious")
    with pytest.raises(FileError, match="exists already"):
        write_mesh(path, *ball)
    assert path.read_text() == "precious"
    write_mesh(path, *ball, force=True)
    assert os.listdir(tmp_path) == ["ball.obj"]


@pytest.mark.posix
def test_a_replaced_file_keeps_its_mode(ball, tmp_path):
    path = tmp_path / "ball.obj"
    path.touch(0o640)
    write_mesh(path, *ball, force=True)
    assert path.stat().st_mode & 0o777 == 0o640


@pytest.mark.posix
def test_a_link_is_replaced_and_what_it_points_to_is_kept(ball, tmp_path):
    """Whether it points to a file or to nowhere; a link to the folder is followed."""
    (tmp_path / "store").mkdir()
    (tmp_path / "store" / "real.obj").write_text("precious")
    for there in ("real.obj", "missing.obj"):
        link = tmp_path / "link.obj"
        link.symlink_to(tmp_path / "store" / there)
        with pytest.raises(FileError, match="exists already"):
            write_mesh(link, *ball)
        write_mesh(link, *ball, force=True)
        assert not link.is_symlink()
        assert np.array_equal(read_mesh(link).v, ball[0])
        link.unlink()
    assert os.listdir(tmp_path / "store") == ["real.obj"]
    assert (tmp_path / "store" / "real.obj").read_text() == "precious"
    (tmp_path / "other").symlink_to("store")
    write_mesh(tmp_path / "other" / "ball.obj", *ball)
    assert sorted(os.listdir(tmp_path / "store")) == ["ball.obj", "real.obj"]


@pytest.mark.parametrize("name", ALL)
def test_a_full_disk_leaves_nothing_behind(name, ball, tmp_path):
    """No file may grow beyond 64 bytes, as if the disk were full."""
    needs(name)
    resource = pytest.importorskip("resource", reason="no limits of resources here")
    # packages are loaded, and their caches written, before the limit
    write_mesh(tmp_path / name, *ball)
    before = (tmp_path / name).read_bytes()
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (64, limits[1]))
    try:
        with pytest.raises(FileError, match=r"File too large|No space left"):
            write_mesh(tmp_path / name, *ball, force=True)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert (tmp_path / name).read_bytes() == before
    assert os.listdir(tmp_path) == [name]


def test_a_failed_rename_leaves_nothing_behind(ball, tmp_path, monkeypatch):
    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(FileError, match="Permission denied"):
        write_mesh(tmp_path / "ball.obj", *ball)
    assert os.listdir(tmp_path) == []


def test_no_folder_and_no_file(ball, tmp_path):
    with pytest.raises(FileError, match="no folder"):
        write_mesh(tmp_path / "nowhere" / "ball.obj", *ball)
    (tmp_path / "folder.obj").mkdir()
    with pytest.raises(FileError, match="directory"):
        write_mesh(tmp_path / "folder.obj", *ball, force=True)
    if Path("/dev/full").exists():
        (tmp_path / "full.obj").symlink_to("/dev/full")
        with pytest.raises(FileError, match="not a regular file"):
            write_mesh(tmp_path / "full.obj", *ball, force=True)


def test_a_name_may_take_all_its_bytes(ball, tmp_path):
    name = "é" * ((255 - len(".ply")) // 2) + ".ply"
    assert len(name.encode()) >= 254
    write_mesh(tmp_path / name, *ball)
    assert np.array_equal(read_mesh(tmp_path / name).v, ball[0])
    assert len(os.listdir(tmp_path)) == 1


def test_threads_that_write_one_target_do_not_share_a_temporary_file(ball, tmp_path):
    """Eight threads at once: the file is one of theirs, whole."""
    v, f = ball
    start = threading.Barrier(8)

    def write(k):
        start.wait()
        for _ in range(5):
            write_mesh(tmp_path / "ball.ply", v * (k + 1), f, force=True)

    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(write, range(8))) == [None] * 8
    assert any(np.array_equal(read_mesh(tmp_path / "ball.ply").v, v * (k + 1)) for k in range(8))
    assert os.listdir(tmp_path) == ["ball.ply"]


def test_partial_files_are_unique_and_those_of_another_machine_are_kept(tmp_path):
    path = tmp_path / "ball.obj"
    with replacing(path, force=True) as first, replacing(path, force=True) as second:
        assert first.exists()
        assert second.exists()
        host = re.escape(re.sub(r"[^A-Za-z0-9.]", "-", socket.gethostname()))
        assert re.fullmatch(rf"\.part-{host}-{os.getpid()}-[0-9a-f]{{16}}-ball\.obj", first.name)
        assert first.name != second.name
    other = tmp_path / f".part-elsewhere-{os.getpid()}-0-ball.obj"
    own = tmp_path / first.name
    for left in (other, own):
        left.touch()
    remove_partial_files(path, os.getpid())
    assert sorted(os.listdir(tmp_path)) == [other.name, "ball.obj"]


@pytest.mark.posix
def test_a_link_at_the_place_of_a_partial_file_is_not_followed(ball, tmp_path, monkeypatch):
    monkeypatch.setattr("secrets.token_hex", lambda size: size * "ab")
    with replacing(tmp_path / "ball.obj") as partial:
        pass
    (tmp_path / "precious").write_text("precious")
    partial.symlink_to(tmp_path / "precious")
    with pytest.raises(FileError, match="File exists"):
        write_mesh(tmp_path / "ball.obj", *ball, force=True)
    assert partial.is_symlink()
    assert (tmp_path / "precious").read_text() == "precious"


@pytest.mark.posix
@pytest.mark.parametrize("mode", [0o600, 0o640, 0o666])
def test_a_partial_file_is_never_more_open_than_the_one_it_replaces(mode, tmp_path):
    path = tmp_path / "a.ply"
    path.write_text("old")
    path.chmod(mode)
    with replacing(path, force=True) as partial:
        assert partial.stat().st_mode & 0o777 & ~mode == 0
        partial.write_text("new")
    assert path.stat().st_mode & 0o777 == mode


@pytest.mark.posix
def test_a_link_is_taken_for_a_folder_only_at_a_name_that_the_user_gave(tmp_path):
    (tmp_path / "subjects").symlink_to(tmp_path)
    with pytest.raises(FileError, match="is a link"):
        make_folder(tmp_path / "subjects", follow=False)
