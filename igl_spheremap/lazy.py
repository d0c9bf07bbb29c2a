"""Public names that are imported at their first use."""

from __future__ import annotations

from sys import modules

TYPE_CHECKING = False
# at run time this import, or that of `typing`, would take three times as long as all else here
if TYPE_CHECKING:
    from collections.abc import Callable


def attach(
    package: str, places: dict[str, str]
) -> tuple[Callable[[str], object], Callable[[], list[str]], list[str]]:
    """`__getattr__`, `__dir__` and `__all__` of a package, by the module in it of each name; a module has its own."""
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
