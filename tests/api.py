"""All that a user may name: both doors, their results and errors, flags of commands, exit statuses; a line each.

``python tests/api.py`` writes them to ``tests/api.txt``, with which `test_api.py` compares them: a name that changes is
seen in the change that moves it.
"""

import inspect
import re
import sys
from dataclasses import MISSING, fields, is_dataclass
from enum import Enum
from pathlib import Path

from doors import PUBLIC

from igl_spheremap import errors
from igl_spheremap.apps.cli.exits import Exit
from igl_spheremap.apps.cli.table import COMMANDS

SNAPSHOT = Path(__file__).with_name("api.txt")


def signature(function):
    """Parameters with their kinds and defaults, but without types, which may become wider."""
    signed = inspect.signature(function)
    bare = [
        one.replace(annotation=inspect.Parameter.empty)
        for one in signed.parameters.values()
        if one.name != "self"
    ]
    return str(signed.replace(parameters=bare, return_annotation=inspect.Signature.empty))


def default(field):
    """The default of a field of a record."""
    if field.default is not MISSING:
        return f" = {field.default!r}"
    return "" if field.default_factory is MISSING else f" = {field.default_factory()!r}"


def attributes(public):
    """Definitions of a class and of its bases in the package."""
    return {
        key: value
        for base in reversed(public.__mro__)
        if base.__module__.startswith("igl_spheremap")
        for key, value in vars(base).items()
    }


def of_class(name, public):
    """Attributes of instances of a class."""
    bases = ", ".join(base.__name__ for base in public.__bases__ if base is not object)
    yield f"{name}: class({bases})"
    if issubclass(public, Enum):
        yield from (f"{name}.{member.name} = {member.value!r}" for member in public)
    elif is_dataclass(public):
        yield from (
            f"{name}.{field.name}{default(field)}"
            for field in fields(public)
            if field.name[0] != "_"
        )
    yield from (f"{name}.{field}" for field in getattr(public, "_fields", ()))
    for key, value in sorted(attributes(public).items()):
        if (key.startswith("_") and key != "__init__") or (
            is_dataclass(public) and key == "__init__"
        ):
            continue
        made = getattr(value, "__func__", value)  # of a class method
        if inspect.isfunction(made):
            yield f"{name}.{key}{signature(made)}"
        elif isinstance(value, property):
            yield f"{name}.{key}"


def returned():
    """Records that no door has, but which its functions return and its records hold, as annotations say."""
    said = set()
    for public in filter(inspect.isclass, PUBLIC.values()):
        made = (
            getattr(one, "fget", None) or getattr(one, "__func__", one)
            for one in attributes(public).values()
        )
        said |= {
            str(inspect.signature(one).return_annotation) for one in made if inspect.isfunction(one)
        }
        said |= {
            str(one) for base in public.__mro__ for one in inspect.get_annotations(base).values()
        }
    said |= {
        str(inspect.signature(one).return_annotation)
        for one in filter(inspect.isfunction, PUBLIC.values())
    }
    names = {name for text in said for name in re.findall(r"\w+", text)} - {
        name.split(".")[-1] for name in PUBLIC
    }
    modules = [module for name, module in sys.modules.items() if name.startswith("igl_spheremap.")]
    return {
        name: getattr(module, name)
        for module in modules
        for name in names & set(vars(module))
        if inspect.isclass(getattr(module, name))
        and getattr(module, name).__module__ == module.__name__
    }


def of_doors():
    """What can be imported, what it returns, and errors of the system and the numbers."""
    raised = {
        name: one
        for name, one in vars(errors).items()
        if inspect.isclass(one) and issubclass(one, RuntimeError)
    }
    for name, record in sorted({**raised, **returned()}.items() - PUBLIC.items()):
        yield from of_class(name, record)
    for name, public in sorted(PUBLIC.items()):
        if inspect.isclass(public):
            yield from of_class(name, public)
        elif inspect.isfunction(public):
            yield f"{name}{signature(public)}"
        elif inspect.ismodule(public):
            yield from (
                f"{name}.{key}{signature(getattr(public, key))}" for key in sorted(public.__all__)
            )
        else:
            yield f"{name} = {public!r}"


def of_shell():
    """Commands, their arguments with defaults, and exit statuses."""
    for command in sorted(COMMANDS, key=lambda one: one.name):
        yield f"igl-spheremap {command.name}"
        for names, options in command.arguments:
            choices = (
                f" {{{','.join(map(str, options['choices']))}}}" if "choices" in options else ""
            )
            of = options.get("default", False if options.get("action") == "store_true" else None)
            yield f"igl-spheremap {command.name} {', '.join(names)}{choices} = {of!r}"
    yield from (f"exit status {status:d}: {status.name}" for status in Exit)


def text():
    """The whole of it."""
    return "".join(f"{line}\n" for line in (*of_doors(), *of_shell()))


if __name__ == "__main__":
    SNAPSHOT.write_text(text(), encoding="utf-8")
