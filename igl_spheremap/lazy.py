"""Public names that are imported at their first use, as the stub of their package lists them."""

from __future__ import annotations

from sys import modules

TYPE_CHECKING = False
# at run time this import, or that of `typing`, would take three times what all else takes here
if TYPE_CHECKING:
    from collections.abc import Callable


def attach(
    package: str, folder: str
) -> tuple[Callable[[str], object], Callable[[], list[str]], list[str]]:
    """`__getattr__`, `__dir__` and `__all__` of a package in a folder, of its stub's lines `from .M import N as N`.

    `lazy_loader.attach_stub` does this, too, but imports `ast` for it, which takes five times what all else takes here.
    """
    with open(f"{folder}/__init__.pyi", encoding="utf-8") as stub:
        words = [line.split() for line in stub if line.startswith("from .")]
    places = {name: module.removeprefix(".") or name for _, module, _, name, *_ in words}
    public = sorted(places)

    def get(name: str) -> object:
        from importlib import import_module

        if name not in places:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module = import_module(f"{package}.{places[name]}")
        value = module if name == places[name] else getattr(module, name)
        setattr(modules[package], name, value)
        return value

    return get, lambda: public, public
