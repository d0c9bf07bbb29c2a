"""A method as a frozen record of its options."""

from __future__ import annotations

from abc import ABC
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from typing import Any, ClassVar, Literal, get_args, get_origin, get_type_hints

from ..errors import check_number, check_whole, shown

_hints = cache(get_type_hints)  # 0.5 ms


@dataclass(frozen=True)
class Method(ABC):
    """A method and its options."""

    _in_words = "a record of options, such as Auto()"

    #: The name that users give.
    name: ClassVar[str]

    def __post_init__(self) -> None:
        """Before anything is computed, refuse options of the wrong kind: choices, counts, numbers."""
        for name, hint in _hints(type(self)).items():
            value, kinds = getattr(self, name), (hint, *get_args(hint))
            choices = [
                word for kind in kinds if get_origin(kind) is Literal for word in get_args(kind)
            ]
            if (value is None and type(None) in kinds) or get_origin(hint) is ClassVar:
                continue
            if choices and not (isinstance(value, str) and value in choices):
                words = [*map(repr, choices), *("None" for kind in kinds if kind is type(None))]
                raise ValueError(f"unknown {name} {shown(value)}: choose {' or '.join(words)}")
            if int in kinds:
                check_whole(value, name)
            if hint is float:
                check_number(value, name)
            if hint is bool and not isinstance(value, bool):
                raise TypeError(f"{name} is {shown(value)}; give True or False")
            if hint is str and not isinstance(value, str):
                raise TypeError(f"{name} is {shown(value)}; give a name")

    def settings(self) -> dict[str, Any]:
        """The options that are not at their defaults."""
        return _changed(self)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({', '.join(f'{name}={value!r}' for name, value in self.settings().items())})"


def _changed(record: Any) -> dict[str, Any]:
    """The fields of a record, and of records within it, that are not at their defaults."""
    changed = {}
    for each in fields(record):
        value = getattr(record, each.name)
        if value == each.default:
            continue
        if is_dataclass(value):
            value = _changed(value)
        changed[each.name] = value
    return changed
