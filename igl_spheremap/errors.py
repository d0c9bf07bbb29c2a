"""Errors that the package raises, each with a sentence a user can act on.

The mend of a fault is data, a `Remedy`: the library says it as a call, the command line as its flags.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from importlib import import_module
from numbers import Integral, Real
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")
T = TypeVar("T")
E = TypeVar("E", bound=Exception)

#: Control characters, ends of lines, marks that turn the direction of writing, and characters of no text file.
_CONTROL = re.compile("[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff\ufffe\uffff]")
_LONGEST = 60  # characters of a value in a message
_PACKAGES = {"PIL": "pillow"}  # where the name to install is not the name to import


@dataclass(frozen=True)
class Remedy:
    """A call that mends a fault; without a function, options of the call that failed.

    As a text it is the reader's input: a call in Python, flags in the shell, see `said_by`.

    Attributes
    ----------
    function : str
        Name of a function of this package.
    options : dict
        Its options; those of `repair_mesh` and `repair_disk` in the order in which the repairs are made.
    given : str
        The arguments before these options.

    Examples
    --------
    >>> str(Remedy("repair_mesh", {"holes": "fill"})), str(Remedy("", {"force": True}))
    ("repair_mesh(v, f, holes='fill')", 'force=True')
    """

    function: str = ""
    options: Mapping[str, Any] = field(default_factory=dict)
    given: str = "v, f"

    def __str__(self) -> str:
        return _SAY.get()(self)


def as_call(remedy: Remedy) -> str:
    """Say a remedy as a call in Python; an option whose value the reader chooses is said by its name alone."""
    options = []
    for name, value in remedy.options.items():
        if value is None:
            options.append(name)
        else:
            options.append(f"{name}={value!r}")
    if not remedy.function:
        return ", ".join(options)
    return f"{remedy.function}({', '.join((remedy.given, *options))})"


Say = Callable[[Remedy], str]
_SAY: ContextVar[Say] = ContextVar("how messages say remedies", default=as_call)


def said_here() -> Say:
    """The function by which messages say remedies in this context."""
    return _SAY.get()


@contextmanager
def said_by(say: Say) -> Iterator[None]:
    """Let messages say remedies by a function; each front end has one, and that of Python is the default."""
    token = _SAY.set(say)
    try:
        yield
    finally:
        _SAY.reset(token)


class MeshError(ValueError):
    """A call does not take a mesh, or an array that goes with it; most take a closed genus-0 triangle mesh.

    The message is one line: the fault, its place (the first indices), and the repair.

    Attributes
    ----------
    fault : str
        The fault, its place, and the way to mend it.
    remedy : Remedy or None
        The call that mends it: ``repair_mesh(v, f, **error.remedy.options)``, for disks ``repair_disk``. None, the
        default, if no call does.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.sphere(42)
    >>> try:
    ...     ism.check_mesh(v, f[1:])
    ... except ism.MeshError as error:
    ...     error.remedy.function, error.remedy.options
    ('repair_mesh', {'holes': 'fill'})
    """

    def __init__(self, fault: str = "", remedy: Remedy | None = None) -> None:
        super().__init__(fault, remedy)

    @property
    def fault(self) -> str:
        return printable(str(self.args[0]))

    @property
    def remedy(self) -> Remedy | None:
        found: Remedy | None = self.args[1]
        return found

    def __str__(self) -> str:
        if self.remedy is None:
            return self.fault
        return f"{self.fault} ({self.remedy} does)"


class FileError(OSError):
    """A file can't be read or written; the message is one line that says why.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> ism.read_mesh("nowhere.ply")
    Traceback (most recent call last):
        ...
    igl_spheremap.errors.FileError: ...nowhere.ply...
    """

    def __str__(self) -> str:
        return printable(super().__str__())


class MapError(RuntimeError):
    """A map was computed but can't be accepted.

    Attributes
    ----------
    result : SphereMap or None
        The map as far as it came, with its certificate, so that nothing is lost; None, the default, if there is none.
    """

    def __init__(self, message: str, result: Any = None) -> None:
        super().__init__(message)
        self.result = result


class FoldingsRemain(MapError):
    """The map is not certified folding-free.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> x, f = ism.samples.sphere(42)
    >>> folded = x.copy()
    >>> folded[0] = -x[0]
    >>> try:
    ...     ism.sphere_map(x, f, folded)
    ... except ism.FoldingsRemain as error:
    ...     print(len(error.result.certificate.flipped))
    5
    """


class FactorisationFailed(RuntimeError):
    """A matrix is not numerically positive definite, or the backend gave up on it.

    Another Laplacian of the same surface, with mollified or intrinsic Delaunay weights, may work.
    """


class OfListener(BaseException):
    """Carries a listener's error to the public function, past the handlers of steps' errors."""

    def __init__(self, error: Exception) -> None:
        super().__init__()
        self.error = error


class DisplayError(RuntimeError):
    """Nothing can be drawn here; the message is one line that names the missing part."""


class WorkersUnavailable(RuntimeError):
    """No worker, or none of the right version, runs the jobs of `igl_spheremap.map_many`."""


def check_number(value: object, name: str, least: float = 0.0, most: float = math.inf) -> float:
    """The value of an option; a TypeError unless it is a number, a ValueError unless it is in range.

    >>> check_number(float("nan"), "tolerance")
    Traceback (most recent call last):
        ...
    ValueError: tolerance is nan; give a number of at least 0
    """
    if not isinstance(value, Real) or isinstance(value, bool):
        raise TypeError(f"{name} is {shown(value)}; give a number")
    number = float(value)
    if not least <= number <= most:
        limits = f"from {least:g} to {most:g}"
        if most == math.inf:
            limits = f"of at least {least:g}"
        raise ValueError(f"{name} is {number:g}; give a number {limits}")
    return number


def check_whole(value: object, name: str, least: int = 0) -> int:
    """The value of an option; a TypeError unless it is a whole number, a ValueError if it is too small."""
    if not isinstance(value, Integral) or isinstance(value, bool):
        raise TypeError(f"{name} is {shown(value)}; give a whole number")
    if value < least:
        raise ValueError(f"{name} is {value}; give {least} or more")
    return int(value)


def check_list(
    value: object, name: str, length: int | None = None, what: str = "a list"
) -> list[Any]:
    """Several things as a list; a TypeError for a text or one thing alone, a ValueError for another number of them.

    >>> check_list("a.ply", "sources")
    Traceback (most recent call last):
        ...
    TypeError: sources is 'a.ply'; give a list
    """
    if isinstance(value, str | bytes | os.PathLike) or not isinstance(value, Iterable):
        raise TypeError(f"{name} is {shown(value)}; give {what}")
    several = list(value)
    if length is not None and len(several) != length:
        raise ValueError(f"{name} has {len(several)} entries; give {length}")
    return several


def shown(value: object) -> str:
    """A value in a message: the beginning of its text in one line."""
    text = printable(" ".join(repr(value).split()))
    if len(text) <= _LONGEST:
        return text
    return f"{text[:_LONGEST]}..."


def printable(text: str) -> str:
    """A text with its control characters as escapes, so that a name from a file changes no line and no terminal.

    >>> printable("sulc\\n\\x1b[31m")
    'sulc\\\\n\\\\x1b[31m'
    """
    return _CONTROL.sub(lambda found: found[0].encode("unicode_escape").decode("ascii"), text)


def legible(text: str) -> str:
    """A text that windows and plots take, with all its lines: names of files may not be UTF-8.

    >>> legible("caf\\udce9.obj")
    'caf\\\\udce9.obj'
    """
    return text.encode(errors="backslashreplace").decode()


def one_line(error: BaseException) -> str:
    """The message of an error in one line.

    >>> one_line(FileNotFoundError(2, "No such file", "a.ply")), one_line(MemoryError())
    ('a.ply: No such file', 'out of memory; try a smaller mesh or more memory')
    """
    words: object = error
    if isinstance(error, MemoryError) and (type(error) is not MemoryError or not error.args):
        words = "out of memory; try a smaller mesh or more memory"
    elif isinstance(error, ImportError):
        words = f"a library can't be loaded: {error}; install it anew, or try more memory"
    elif isinstance(error, OSError) and error.strerror:
        words = ": ".join(str(part) for part in (error.filename, error.strerror) if part)
    line = printable(" ".join(str(words).split()))
    if not line:
        return type(error).__name__
    return line


def within(error: E, place: str) -> E:
    """The same error with a place put before its message.

    >>> str(within(MeshError("no faces"), "a.ply: "))
    'a.ply: no faces'
    """
    error.args = (f"{place}{error.args[0]}", *error.args[1:])
    return error


@contextmanager
def naming(file: str) -> Iterator[None]:
    """Put a file's name before the fault of its mesh or map."""
    try:
        yield
    except (MeshError, FoldingsRemain) as error:
        raise within(error, f"{file}: ") from None


def without_name(line: str, name: str) -> str:
    """A message without its file's name, which stands before it already.

    >>> without_name("a.ply: no faces", "a.ply"), without_name("can't read a.ply: No such file", "a.ply")
    ('no faces', "can't read it: No such file")
    >>> without_name("can't write a.ply.npz: no space", "a.ply")
    "can't write a.ply.npz: no space"
    """
    return re.sub(rf"(?<!\S){re.escape(name)}(?![\w./-])", "it", line.removeprefix(f"{name}: "))


def import_optional(module: str, user: str, extra: str = "") -> Any:
    """Import a module that `user` needs; if it is not installed, raise a FileError that says how to install it."""
    try:
        return import_module(module)
    except ImportError:
        name = module.partition(".")[0]
        package = _PACKAGES.get(name, name)
        hint = ""
        if extra:
            hint = f" (the extra {extra!r} of igl_spheremap includes it)"
        raise FileError(
            f"{user} needs {package}, which is not installed: pip install {package}{hint}"
        ) from None
    except ValueError as error:  # matplotlib refuses the MPLBACKEND of another program
        raise FileError(f"{user} needs {module}, which can't start: {one_line(error)}") from None
