"""Records of any depth as plain JSON and arrays, and back by the types of their fields."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from enum import Enum
from types import UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray


def pack(value: Any, name: str, arrays: dict[str, NDArray[Any]]) -> Any:
    """What JSON holds of `value`; its arrays are added to `arrays`, under names such as ``certificate.flipped``."""
    if isinstance(value, np.ndarray):
        arrays[name] = value
        return None
    if isinstance(value, Enum):
        return value.name
    if dataclasses.is_dataclass(value):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value) if field.compare}
    if isinstance(value, Mapping):
        return {str(key): pack(item, _below(name, key), arrays) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [pack(item, _below(name, k), arrays) for k, item in enumerate(value)]
    return value.item() if isinstance(value, np.generic) else value


def unpack(kind: Any, value: Any, name: str, arrays: Mapping[str, NDArray[Any]]) -> Any:
    """The value of type `kind` that `pack` took apart."""
    if name in arrays:
        return arrays[name]
    if get_origin(kind) in (Union, UnionType):  # of one type or None
        kind = next(option for option in get_args(kind) if option is not type(None))
    if value is None:
        return None
    if isinstance(kind, type) and issubclass(kind, Enum):
        return kind[value]
    if isinstance(kind, type) and dataclasses.is_dataclass(kind):
        types = get_type_hints(kind)
        return kind(**{key: unpack(types[key], item, _below(name, key), arrays) for key, item in value.items()})
    if hasattr(kind, "_fields"):  # a named tuple
        types = get_type_hints(kind)
        return kind(*(unpack(types[key], item, _below(name, k), arrays)
                      for k, (key, item) in enumerate(zip(kind._fields, value, strict=True))))
    if get_origin(kind) is tuple:
        return tuple(unpack(get_args(kind)[0], item, _below(name, k), arrays) for k, item in enumerate(value))
    if isinstance(value, dict):
        return {key: unpack(Any, item, _below(name, key), arrays) for key, item in value.items()}
    return value


def _below(name: str, key: object) -> str:
    return f"{name}.{key}" if name else str(key)
