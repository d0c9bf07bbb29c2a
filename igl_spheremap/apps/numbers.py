"""Numbers on the command line that are refused outside of their range."""

from __future__ import annotations

import math
from argparse import ArgumentTypeError
from collections.abc import Callable
from typing import Any


def number(words: str, allowed: Callable[[float], bool], kind: type[float] = float) -> Callable[[str], Any]:
    """A type of arguments for argparse: finite numbers that are allowed, which the words describe.

    >>> number("from 0", lambda n: n >= 0, int)("7")
    7
    """

    def parse(text: str) -> float:
        value = kind(text)
        if not (math.isfinite(value) and allowed(value)):
            raise ArgumentTypeError(f"{text} is out of range: give a {'whole ' * (kind is int)}number {words}")
        return value

    parse.__name__ = "number"  # argparse: "invalid number value: 'x'"
    return parse


COUNT = number("from 0", lambda n: n >= 0, int)
POSITIVE_COUNT = number("from 1", lambda n: n >= 1, int)
FROM_ZERO = number("from 0", lambda n: n >= 0)
POSITIVE = number("above 0", lambda n: n > 0)
