"""What the flags choose: the record of a method with its options."""

from __future__ import annotations

from argparse import Namespace
from dataclasses import fields
from typing import Any

from ...maps.options import METHODS, Method
from .failures import UsageError


def given(args: Namespace, *names: str) -> dict[str, Any]:
    """The values of options whose flags were given; without its flag an option has its own default."""
    return {name: value for name in names if (value := getattr(args, name, None)) is not None}


def chosen_method(args: Namespace) -> Method:
    """The method of --method with the options whose flags were given, which it must know."""
    known = {name: [option.name for option in fields(record)] for name, record in METHODS.items()}
    options = given(args, *sorted(set().union(*known.values())))
    if unknown := set(options) - set(known[args.method]):
        flags = sorted(f"--{name.replace('_', '-')}" for name in unknown)
        raise UsageError(f"--method {args.method} takes no {' and no '.join(flags)}")
    return METHODS[args.method](**options)
