"""Common ground of readers: regular files, bounded memory, one line for any failure."""

from __future__ import annotations

import base64
import gzip
import os
import tracemalloc
import warnings
import zipfile
import zlib
from pathlib import Path

import numpy as np
import pytest
from file_names import needs

from igl_spheremap import FileError, MeshError
from igl_spheremap.io.files import read_mesh, read_sphere
from igl_spheremap.io.reading import beside, check_regular
from igl_spheremap.io.scalars import read_scalars
from igl_spheremap.io.write_mesh import write_mesh
from igl_spheremap.io.written_map import read_map, read_mark
from igl_spheremap.shapes.harmonics.files import read_coefficients

READERS = [read_mesh, read_sphere, read_map, read_scalars, read_mark]


@pytest.mark.posix
@pytest.mark.parametrize(
    "reader", [*READERS, read_coefficients], ids=lambda reader: reader.__name__
)
def test_what_is_no_regular_file_is_refused_without_reading_it(reader, tmp_path):
    """A pipe would be waited for, a device read without end."""
    (tmp_path / "zero.npz").symlink_to("/dev/zero")
    os.mkfifo(tmp_path / "pipe.npz")
    for name in ("zero.npz", "pipe.npz"):
        with pytest.raises(FileError, match=f"can't read .*{name}: it is a device or a pipe"):
            reader(tmp_path / name)
    (tmp_path / "folder.npz").mkdir()
    with pytest.raises(FileError, match="it is a directory"):
        reader(tmp_path / "folder.npz")
    with pytest.raises(FileError, match="No such file"):
        reader(tmp_path / "missing.npz")


def peak_of(reader, path):
    """Largest memory in use while a reader refuses a file."""
    tracemalloc.start()
    try:
        with pytest.raises(MeshError, match="expand to"):
            reader(path)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(
    "reader", [read_mesh, read_sphere, read_map, read_scalars], ids=lambda reader: reader.__name__
)
def test_archives_that_expand_are_refused_in_little_memory(reader, tmp_path):
    """20 kB that hold 20 MB of zeros."""
    path = tmp_path / "bomb.npz"
    zeros = np.zeros(20 << 20, dtype=np.uint8)
    np.savez_compressed(path, vertices=zeros, faces=zeros[:3], json=zeros[:3])
    assert path.stat().st_size < 40_000
    assert peak_of(reader, path) < 8 << 20


def test_an_archive_that_lies_about_its_sizes_is_refused_in_little_memory(tmp_path):
    """The directory says 1,000 bytes, the member expands to 20 MB."""
    path = tmp_path / "lie.npz"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("vertices.npy", bytes(20 << 20))
    data = path.read_bytes()
    path.write_bytes(data.replace((20 << 20).to_bytes(4, "little"), (1000).to_bytes(4, "little")))
    tracemalloc.start()
    with pytest.raises(MeshError):
        read_mesh(path)
    assert tracemalloc.get_traced_memory()[1] < 8 << 20
    tracemalloc.stop()


def test_an_array_that_announces_more_than_there_is_takes_no_memory(tmp_path):
    path = tmp_path / "long.npz"
    np.savez(path, vertices=np.zeros((4, 3)), faces=np.zeros((4, 3), dtype=int))
    members = {}
    with zipfile.ZipFile(path) as archive:
        members = {name: archive.read(name) for name in archive.namelist()}
    members["vertices.npy"] = members["vertices.npy"].replace(
        b"(4, 3), }" + b" " * 9, b"(99999999, 3), }  "
    )
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in members.items():
            archive.writestr(name, content)
    tracemalloc.start()
    with pytest.raises(MeshError, match="damaged"):
        read_mesh(path)
    assert tracemalloc.get_traced_memory()[1] < 8 << 20
    tracemalloc.stop()


@pytest.mark.parametrize("reader", [read_mesh, read_scalars], ids=lambda reader: reader.__name__)
def test_blocks_that_expand_are_refused_in_little_memory(reader, tmp_path):
    """A file of gzip, and a block within the XML, each of 20 MB in 20 kB."""
    needs("a.gii")
    (tmp_path / "bomb.surf.gii.gz").write_bytes(gzip.compress(bytes(20 << 20)))
    assert peak_of(reader, tmp_path / "bomb.surf.gii.gz") < 16 << 20
    write_mesh(tmp_path / "ball.surf.gii", np.eye(3), [[0, 1, 2]])
    text = (tmp_path / "ball.surf.gii").read_bytes()
    start, end = text.index(b"<Data>") + 6, text.index(b"</Data>")
    packed = base64.b64encode(zlib.compress(bytes(20 << 20)))
    for name, block in (("plain", packed), ("wrapped", b"<![CDATA[" + packed + b"]]>")):
        path = tmp_path / f"{name}.surf.gii"
        path.write_bytes(text[:start] + block + text[end:])
        assert peak_of(reader, path) < 16 << 20


def test_running_out_of_memory_is_no_damage(tmp_path, monkeypatch):
    """Nothing but a patch makes a small file run out of memory."""
    (tmp_path / "a.obj").write_text("v 0 0 0\n")

    def fail(_):
        raise MemoryError

    monkeypatch.setattr(Path, "read_bytes", fail)
    with pytest.raises(FileError, match="out of memory"):
        read_mesh(tmp_path / "a.obj")


def test_readers_work_under_any_error_state_of_the_caller(tmp_path):
    (tmp_path / "a.obj").write_text("v nan 0 0\nv 1e999 0 0\nv 1e-320 1 0\nf 1 2 3\n")
    with np.errstate(all="raise"):
        assert np.isnan(read_mesh(tmp_path / "a.obj").v[0, 0])


@pytest.mark.parametrize("kind", [TimeoutError, type("SoftTimeLimitExceeded", (Exception,), {})])
def test_what_a_signal_handler_raises_while_a_file_is_read_comes_out(kind, tmp_path, monkeypatch):
    def fail(_):
        raise kind("the time is over")

    (tmp_path / "a.obj").write_text("v 0 0 0\n")
    monkeypatch.setattr(Path, "read_bytes", fail)
    with pytest.raises(kind, match="the time is over"):
        read_mesh(tmp_path / "a.obj")


def test_readers_leave_the_filters_of_warnings_to_the_process(tmp_path):
    """`warnings.catch_warnings` in threads that overlap leaves those of one to the process."""
    needs("a.gii")
    for name in ("a.ply", "lh.white"):
        write_mesh(tmp_path / name, np.eye(3), [[0, 1, 2]])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        before = list(warnings.filters)
        seen = []

        def look(*_):
            seen.append(list(warnings.filters))

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr("igl_spheremap.io.files.structure_of", lambda path: look(path) or {})
            for name in ("a.ply", "lh.white"):
                read_mesh(tmp_path / name)
        assert seen == [before, before]


@pytest.mark.posix
def test_what_the_system_makes_up_is_refused(tmp_path):
    """Such files have the mode of regular ones; some never end."""
    if not Path("/proc/self/environ").exists():
        pytest.skip("no /proc here")
    (tmp_path / "a.npz").symlink_to("/proc/self/environ")
    for path in ("/proc/self/environ", tmp_path / "a.npz"):
        with pytest.raises(FileError, match="the system makes it up"):
            check_regular(Path(path))
    with pytest.raises(FileError, match="the system makes it up"):
        read_mesh(tmp_path / "a.npz")


#: Names of files elsewhere, by the rules of each system.
ELSEWHERE = ["../a.bin", "b/../../a.bin", "/etc/a.bin", "\\\\host\\a.bin", "C:\\a.bin", "..\\a.bin"]


@pytest.mark.parametrize("name", ELSEWHERE)
def test_a_file_names_no_file_elsewhere(name, tmp_path):
    with pytest.raises(FileError, match="not in its folder"):
        beside(tmp_path / "a.gltf", name)


@pytest.mark.posix
def test_a_link_in_the_folder_leads_to_no_file_elsewhere(tmp_path):
    """Neither as the file itself nor as a folder on the way; links within the folder do."""
    (tmp_path / "secret").write_text("secret")
    place = tmp_path / "upload"
    place.mkdir()
    (place / "a.bin").touch()
    (place / "out.bin").symlink_to("../secret")
    (place / "up").symlink_to("..")
    (place / "in.bin").symlink_to("a.bin")
    for name in ("out.bin", "up/secret"):
        with pytest.raises(FileError, match="not in its folder"):
            beside(place / "a.gltf", name)
    (tmp_path / "place").symlink_to("upload")
    for folder in (place, tmp_path / "place"):
        assert beside(folder / "a.gltf", "in.bin").exists()


def test_a_file_names_files_in_its_folder_and_below(tmp_path):
    (tmp_path / "b").mkdir()
    for name in ("a..bin", "b/a.bin"):
        (tmp_path / name).touch()
        assert beside(tmp_path / "a.gltf", name) == tmp_path / name


@pytest.mark.posix
@pytest.mark.parametrize("content", ["", "v 0 0\n"])
def test_a_name_of_two_lines_is_said_in_one(content, tmp_path):
    path = tmp_path / "two\nlines.obj"
    for expected in (FileError, MeshError):
        with pytest.raises(expected, match=r"two\\nlines\.obj") as caught:
            read_mesh(path)
        assert len(str(caught.value).splitlines()) == 1
        path.write_text(content)
