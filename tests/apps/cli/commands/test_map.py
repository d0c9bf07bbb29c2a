"""The flags of `map` are the options of the methods' records."""

import json
from dataclasses import fields
from typing import get_args, get_type_hints

from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.parser import build_parser
from igl_spheremap.maps.options import METHODS, Auto


def flags():
    """Flags of `map` by the name of the option that they set."""
    commands = next(action for action in build_parser()._actions if action.dest == "command")
    return {action.dest: action for action in commands.choices["map"]._actions}


def test_methods_are_those_of_the_records_and_the_default_is_the_front_doors():
    assert tuple(flags()["method"].choices) == tuple(METHODS)
    assert flags()["method"].default == Auto.name


def test_flags_have_the_names_choices_and_defaults_of_options():
    options = {option.name for method in METHODS.values() for option in fields(method)}
    found = {name: flag for name, flag in flags().items() if name in options}
    assert set(found) == {"tolerance", "max_iterations", "gauge", "polish", "weights"}
    for name, flag in found.items():
        assert flag.option_strings == ["--" + name.replace("_", "-")]
        assert flag.default is None  # the record's own default holds
        hint = next(get_type_hints(method)[name] for method in METHODS.values() if name in get_type_hints(method))
        if flag.choices is not None:
            choices = [choice for part in (hint, *get_args(hint)) for choice in get_args(part) or [part]]
            assert set(flag.choices) <= set(choices)
        elif hint is not bool:
            assert type(flag.type("1")) is hint


def test_flags_of_every_method_are_options_of_every_method():
    for method in METHODS.values():
        assert {"tolerance", "max_iterations"} <= {option.name for option in fields(method)}


def test_timings_are_printed_and_are_figures(tmp_path, capsys):
    words = ["map", "sample:spheroid", str(tmp_path / "a.obj"), "--timings", "--json", str(tmp_path / "a.json")]
    assert main(words) == 0
    figures = json.loads((tmp_path / "a.json").read_text())
    printed = capsys.readouterr().out
    assert figures["timings"]
    assert all(f"  {name}\n" in printed for name in (*figures["timings"], "other"))
