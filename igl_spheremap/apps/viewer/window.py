"""The one polyscope window of a process, on a screen or off it, and the pictures and videos that show it."""

from __future__ import annotations

import contextlib
import ctypes
import errno
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...draw import palette
from ...draw.plot import LIGHT
from ...errors import DisplayError, FileError, import_optional, legible
from ...gate import PathLike
from ...io.replacing import check_writable, replacing
from ...mesh.arrays import FloatArray
from .choices import SIZE

#: Packages of Debian and Ubuntu that polyscope needs.
PACKAGES = "libegl1 libegl-mesa0 libgl1 libgl1-mesa-dri libx11-6"


class _Lazy:
    """A module that is imported at its first use, which raises a DisplayError if it can't be."""

    def __init__(self, name: str) -> None:
        self._name = name

    @cached_property
    def _module(self) -> ModuleType:
        try:
            return import_module(self._name)
        except ImportError as error:
            hint = f"Debian and Ubuntu: apt install {PACKAGES}"
            raise DisplayError(f"polyscope can't be loaded ({error}); {hint}") from None

    def __getattr__(self, name: str) -> Any:
        return getattr(self._module, name)


ps, imgui, implot = (
    _Lazy(module) for module in ("polyscope", "polyscope.imgui", "polyscope.implot")
)


#: Title of a window without a given one.
TITLE = "igl_spheremap"
MATERIAL = "spheremap"
#: World units that are as long as a pixel: the grid lays things out in pixels.
UNITS_PER_PIXEL = 0.01
_FIELD_OF_VIEW = 45.0  # degrees, from top to bottom
#: Unchanged frames take 20 ms of a core by Mesa's software OpenGL: half of it at this rate.
MAX_FPS = 25
PICTURES = (".png", ".jpg")
#: The last bytes of their files.
_ENDS = (b"IEND\xaeB`\x82", b"\xff\xd9")
Picture = NDArray[np.uint8]
#: Takes a picture and the number of its repeats.
Write = Callable[[Picture, int], None]
#: Files that hold a video.
VIDEOS = (".gif", ".mp4")
#: ImGui's grey of light panels.
_PANEL = (240, 240, 240)
_offscreen: bool | None = None


def open_window(size: tuple[int, int] = SIZE, offscreen: bool = False, title: str = TITLE) -> None:
    """Start polyscope, or clear what an earlier call has drawn; off screen it draws for files and needs no display.

    The first window's title stays.

    If there is no display, no OpenGL, or this process draws the other way already, raises a DisplayError.
    """
    global _offscreen
    if _offscreen is None:
        _start(offscreen, title)
        _offscreen = offscreen
    elif _offscreen != offscreen:
        if _offscreen:
            raise DisplayError("this process draws off screen already")
        raise DisplayError(
            "this process has a window already; draw pictures for files in another one"
        )
    ps.remove_everything()
    ps.clear_user_callback()
    ps.set_window_size(*size)


def _start(offscreen: bool, title: str) -> None:
    name = backend(offscreen)
    # Mesa's software OpenGL then leaves a core to computations beside the window
    if not offscreen:
        os.environ.setdefault("LP_NUM_THREADS", str(max(0, (os.cpu_count() or 1) - 2)))
    ps.set_program_name(legible(title))
    ps.set_verbosity(0)
    ps.set_use_prefs_file(False)
    ps.set_errors_throw_exceptions(True)
    ps.set_display_message_popups(False)
    try:
        ps.init(name)
    except RuntimeError as error:
        with contextlib.suppress(RuntimeError):  # without memory this does not start either
            ps.init("openGL_mock")  # else polyscope complains once more when the process ends
        reason = " ".join(str(error).replace("[polyscope]", "").replace("[EXCEPTION]", "").split())
        hint = "is the display there? Pictures for files need none"
        if offscreen:
            hint = f"Debian and Ubuntu: apt install {PACKAGES}"
        raise DisplayError(f"OpenGL did not start ({reason}); {hint}") from None
    _set_scene(offscreen)


def backend(offscreen: bool) -> str:
    """Name of a backend of polyscope that does not crash, as polyscope does without libEGL."""
    if not sys.platform.startswith("linux"):
        return "openGL3_glfw"
    if not offscreen:
        if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            raise DisplayError("there is no display for a window; pictures for files need none")
        return "openGL3_glfw"
    try:
        ctypes.CDLL("libEGL.so.1")
    except OSError:
        raise DisplayError(
            f"libEGL.so.1 is missing; Debian and Ubuntu: apt install {PACKAGES}"
        ) from None
    return "openGL3_egl"


def _set_scene(offscreen: bool) -> None:
    """Background, light and a camera that sees everything from the front without perspective."""
    with tempfile.TemporaryDirectory() as folder:
        files = []
        for name, image in zip("rgbk", matcaps(), strict=True):
            path = Path(folder) / f"{name}.ppm"
            path.write_bytes(
                b"P6\n256 256\n255\n" + np.rint(255 * image).astype(np.uint8).tobytes()
            )
            files.append(str(path))
        ps.load_blendable_material(MATERIAL, filenames=files)
    ps.set_build_default_gui_panels(False)
    ps.set_open_imgui_window_for_user_callback(False)
    ps.set_do_default_mouse_interaction(False)
    ps.set_background_color(palette.BACKGROUND)
    ps.set_ground_plane_mode("none")
    ps.set_SSAA_factor(2 if offscreen else 1)
    ps.set_automatically_compute_scene_extents(False)
    ps.set_view_projection_mode("orthographic")
    ps.set_vertical_fov_degrees(_FIELD_OF_VIEW)
    ps.set_max_fps(MAX_FPS)


def matcaps(ambient: float = 0.62, diffuse: float = 0.42) -> list[FloatArray]:
    """Images (256, 256, 3) of a lit ball in red, green, blue and black, which make a blendable material of polyscope.

    The light comes from the viewer's upper left. A colour c is seen as c times the shade: polyscope's own materials
    would wash it out, and then no legend fits. Faces that are turned away from the light have the brightness `ambient`;
    facing it adds `diffuse`.
    """
    y, x = np.mgrid[1 - 1 / 256 : -1 : -1 / 128, -1 + 1 / 256 : 1 : 1 / 128]
    size = np.maximum(np.hypot(x, y), 1)
    x, y = x / size, y / size
    z = np.sqrt(np.maximum(0, 1 - x * x - y * y))
    shade = linear(
        np.minimum(1, ambient + diffuse * np.maximum(0, np.stack((x, y, z), axis=2) @ LIGHT))
    )
    return [shade[..., None] * np.eye(4, 3)[k] for k in range(4)]


def linear(colours: FloatArray) -> FloatArray:
    """Colours that polyscope, which applies a gamma of 2.2 at the end, shows as the given ones."""
    return colours**2.2


def to_world(x: float, y: float, depth: float = 0.0) -> FloatArray:
    """The point that is seen at a pixel, this many pixels in front of the middle."""
    width, height = ps.get_window_size()
    return np.array([x - width / 2, height / 2 - y, depth]) * UNITS_PER_PIXEL


def aim(height: int) -> None:
    """Point the camera so that a pixel is `UNITS_PER_PIXEL` long, x to the right and y up, the origin in the middle."""
    reach = 0.5 * height * UNITS_PER_PIXEL
    # as orthographic views have it
    ps.set_length_scale(reach / (2 * np.tan(np.radians(_FIELD_OF_VIEW / 2))))
    ps.set_bounding_box((-2 * reach, -reach, -reach), (2 * reach, reach, reach))
    ps.look_at((0.0, 0.0, 3 * reach), (0.0, 0.0, 0.0))


def check_picture(path: PathLike) -> None:
    """If a picture can't be written, raise a FileError before the work starts; polyscope reports nothing."""
    if Path(path).suffix.lower() not in PICTURES:
        raise FileError(f"{path}: a picture is a {' or '.join(PICTURES)} file")
    try:
        os.fspath(path).encode()
    except UnicodeEncodeError:
        raise FileError(f"{path}: polyscope takes names of pictures in UTF-8 only") from None
    check_writable(path, force=True)


def save(path: PathLike) -> None:
    """Write the window as a picture."""
    check_picture(path)
    _settle()
    with replacing(path, force=True) as partial:
        ps.screenshot(os.fspath(partial), transparent_bg=False, include_UI=True)
        if not partial.read_bytes().endswith(_ENDS):  # polyscope does not say so
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), os.fspath(path))


def _settle() -> None:
    """Draw until panels know their size; in a window they do, and its picture stays."""
    for _ in range(2 if _offscreen else 0):
        ps.frame_tick()


def grab() -> NDArray[np.uint8]:
    """The window as an image (height, width, 3), the top row first."""
    _settle()
    image = ps.screenshot_to_buffer(transparent_bg=False, include_UI=True)
    return np.ascontiguousarray(image[..., :3])


def show(callback: Callable[[], None]) -> None:
    """Run the window until it is closed, with a callback before every frame."""
    ps.set_user_callback(callback)
    ps.show()
    ps.clear_user_callback()


def pressed(key: str, again: bool = False) -> bool:
    """Whether a key was pressed just now, but into no field; while it is held, `again` and again."""
    held = getattr(imgui, f"ImGuiKey_{key}")
    return not imgui.GetIO().WantTextInput and bool(imgui.IsKeyPressed(held, again))


def check_video(path: Path) -> None:
    """If a video can't be written, raise a FileError before the work starts."""
    if path.suffix.lower() not in VIDEOS:
        raise FileError(f"{path}: a video is a {' or '.join(VIDEOS)} file")
    check_writable(path, force=True)
    if path.suffix.lower() == ".mp4":
        ffmpeg()
    else:
        import_optional("PIL.Image", "a video", "io")


@contextmanager
def open_video(path: Path, rate: int) -> Iterator[Write]:
    """A function that adds pictures to a file, at `rate` a second; the ending of `path` chooses the format."""
    kind = _gif
    if path.suffix.lower() == ".mp4":
        kind = _mp4
    with replacing(path, force=True) as partial, kind(partial, rate) as write:
        yield write


@contextmanager
def _gif(path: Path, rate: int) -> Iterator[Write]:
    images = import_optional("PIL.Image", "a video", "io")
    frames: list[Any] = []
    durations: list[int] = []

    def write(picture: Picture, times: int) -> None:
        frames.append(_reduced(images, picture))
        durations.append(times * 1000 // rate)

    yield write
    frames[0].save(
        path, save_all=True, append_images=frames[1:], duration=durations, loop=0, disposal=1
    )


def _reduced(images: Any, picture: Picture) -> Any:
    """A picture in 254 colours and two that a palette by area would lose: of folded faces, and the panels' grey."""
    image = images.fromarray(picture)
    chosen = image.quantize(
        255, method=images.Quantize.FASTOCTREE, dither=images.Dither.NONE
    ).getpalette()
    indexed = images.new("P", (1, 1))
    kept = *(round(255 * c) for c in palette.FOLDED), *_PANEL
    indexed.putpalette([*chosen[: 3 * 254], *kept])
    return image.quantize(palette=indexed, dither=images.Dither.NONE)


@contextmanager
def _mp4(path: Path, rate: int) -> Iterator[Write]:
    process: subprocess.Popen[bytes] | None = None
    failed = False

    def write(picture: Picture, times: int) -> None:
        nonlocal process
        # the codec takes even sizes only
        height, width = (side // 2 * 2 for side in picture.shape[:2])
        if process is None:
            words = f"-y -f rawvideo -pix_fmt rgb24 -s {width}x{height} -r {rate} -i - -pix_fmt yuv420p -f mp4"
            command = [ffmpeg(), "-loglevel", "error", *words.split(), str(path)]
            process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.DEVNULL)
        assert process.stdin is not None
        process.stdin.write(np.ascontiguousarray(picture[:height, :width]).tobytes() * times)

    try:
        yield write
        if process is not None:
            process.communicate()
            failed = process.returncode != 0
    except BrokenPipeError:
        failed = True
    finally:
        if process is not None:
            process.kill()
            process.wait()
    if failed:
        raise FileError(f"ffmpeg wrote no {path.name}: is the disk full?")


def ffmpeg() -> str:
    """The program that encodes videos: the environment's, the one on the path, or imageio-ffmpeg's."""
    found = os.environ.get("IMAGEIO_FFMPEG_EXE") or shutil.which("ffmpeg")
    if found:
        return found
    return str(import_optional("imageio_ffmpeg", "an MP4 video", "video").get_ffmpeg_exe())
