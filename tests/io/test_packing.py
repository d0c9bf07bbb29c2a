"""Records of any depth as JSON and arrays."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from enum import Enum
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from igl_spheremap.io.packing import pack, unpack


class Colour(Enum):
    RED = "a sentence"


class Row(NamedTuple):
    name: str
    value: float


@dataclass(frozen=True, eq=False)
class Inner:
    values: NDArray[np.int64]
    colour: Colour | None = None


@dataclass(frozen=True, eq=False)
class Outer:
    inner: Inner
    rows: tuple[Row, ...] = ()
    parts: tuple[Inner, ...] = ()
    count: int = 0
    label: str | None = None
    options: dict[str, Any] = field(default_factory=dict)


def through_json(record):
    arrays = {}
    text = json.dumps(pack(record, "", arrays))
    return unpack(Outer, json.loads(text), "", arrays), arrays


def test_records_come_back():
    record = Outer(Inner(np.arange(3), Colour.RED), (Row("a", 1.5), Row("b", float("inf"))),
                   (Inner(np.arange(2)), Inner(np.array([7]))), np.int64(4), "x",
                   {"weights": np.ones(2), "deep": {"k": [1, None]}})
    back, arrays = through_json(record)
    assert sorted(arrays) == ["inner.values", "options.weights", "parts.0.values", "parts.1.values"]
    assert back.inner.colour is Colour.RED
    assert back.parts[1].colour is None
    assert back.rows == record.rows
    assert isinstance(back.rows[0], Row)
    assert back.parts[1].values.tolist() == [7]
    assert (back.count, back.label, back.options["deep"]) == (4, "x", {"k": [1, None]})
    assert back.options["weights"].tolist() == [1, 1]


def test_fields_that_a_file_does_not_have_take_their_defaults():
    back = unpack(Outer, {"inner": {"values": None}}, "", {"inner.values": np.arange(3)})
    assert back.count == 0
    with pytest.raises(TypeError, match="inner"):
        unpack(Outer, {}, "", {})
