"""Conformal maps of genus-0 triangle meshes to the unit sphere, proved free of foldings."""

from ._version import __version__ as __version__


def _modules() -> dict[str, str]:
    """The module of each public name, as `__init__.pyi` lists them.

    `lazy_loader.attach_stub` does this, too, but imports `ast` for it, which takes five times what all else takes here.
    """
    with open(f"{__path__[0]}/__init__.pyi", encoding="utf-8") as stub:
        words = [line.split() for line in stub if line.startswith("from .")]  # from .MODULE import NAME as NAME
    return {name: module.removeprefix(".") or name for _, module, _, name, *_ in words}


_MODULES = _modules()
__all__ = sorted(_MODULES)


def __getattr__(name: str) -> object:
    """Import a public name from its module at its first use."""
    from importlib import import_module

    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = import_module(f"{__name__}.{_MODULES[name]}")
    value = module if name == _MODULES[name] else getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
