"""Pictures: what is none is refused in one line, without waiting and without much memory."""

import os
import struct
import zlib

import numpy as np
import pytest

from igl_spheremap import FileError
from igl_spheremap.io import read_picture, write_picture


def test_pictures_come_back(tmp_path):
    image = np.random.default_rng(0).integers(0, 256, (5, 7, 3), dtype=np.uint8)
    write_picture(tmp_path / "a.png", image)
    assert np.array_equal(read_picture(tmp_path / "a.png"), image)


def huge_png():
    """A header that announces 10 gigapixels."""
    header = b"IHDR" + struct.pack(">2I5B", 100_000, 100_000, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + struct.pack(">I", 13) + header + struct.pack(">I", zlib.crc32(header))


@pytest.mark.parametrize("data", [b"", b"no picture", huge_png()], ids=["empty", "text", "huge"])
def test_what_is_no_picture_is_one_line(data, tmp_path):
    (tmp_path / "a.png").write_bytes(data)
    with pytest.raises(FileError, match=r"can't read .* as a picture"):
        read_picture(tmp_path / "a.png")


@pytest.mark.posix
def test_devices_and_pipes_are_refused_without_reading(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in ("/dev/zero", tmp_path / "pipe"):
        with pytest.raises(FileError, match="a device or a pipe"):
            read_picture(path)
