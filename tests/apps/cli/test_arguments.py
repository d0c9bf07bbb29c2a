"""Numbers out of range are one line and status 64, before anything is read; defaults are those of Python."""

import inspect

import pytest

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.table import COMMANDS


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        ("map a b --tolerance nan", "nan is out of range: give a number from 0"),
        ("map a b --tolerance -1", "-1 is out of range: give a number from 0"),
        ("map a b --max-iterations -5", "-5 is out of range: give a whole number from 0"),
        ("map a b --max-iterations 1e3", "invalid number value: '1e3'"),
        ("map a b --radius inf", "inf is out of range: give a number above 0"),
        ("map a b --balance nan", "nan is out of range: give a number from 0 to 1"),
        ("harmonics a b c --degree -1", "-1 is out of range: give a whole number from 0"),
        (
            "view a --size 100000 1000",
            "100000 is out of range: give a whole number from 200 to 8192",
        ),
        ("play a --length 0", "0 is out of range: give a whole number from 1"),
    ],
)
def test_numbers_out_of_range_are_one_line(words, problem, capsys):
    assert main(words.split()) == 64
    assert problem in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "which"),
    [
        (["map", "", "out.obj"], 1),
        (["map", "in.obj", ""], 2),
        (["batch", "*.ply", "--out", ""], 3),
    ],
)
def test_an_empty_argument_is_no_folder(words, which, capsys):
    assert main(words) == 64
    assert f"argument {which} of {words[0]} is empty" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("command", "function", "parameters"),
    [
        ("flatten", ism.flatten, {"balance": "balance"}),
        ("match", ism.shapes.match, {"feature_weight": "feature_weight"}),
        ("register", ism.shapes.register, {"stiffness": "stiffness"}),
        (
            "template",
            ism.shapes.template,
            {name: name for name in ("modes", "balance")} | {"to": "target"},
        ),
        ("template", ism.shapes.permutation_test, {"permutations": "permutations"}),
        ("harmonics", ism.shapes.spherical_harmonics, {"degree": "degree"}),
        ("grid", ism.shapes.to_grid, {"kind": "kind", "rows": "rows"}),
        ("resample", ism.resample, {"to": "target"}),
        ("batch", ism.map_many, {"balance": "balance"}),
        (
            "batch",
            ism.Engine,
            {name: name for name in ("resume", "retry_failed", "timeout", "retries")},
        ),
    ],
)
def test_flags_have_the_defaults_of_the_functions(command, function, parameters):
    row = next(row for row in COMMANDS if row.name == command)
    flags = {
        names[-1].removeprefix("--").replace("-", "_"): options.get(
            "default", False if "action" in options else None
        )
        for names, options in row.arguments
    }
    defaults = {
        flag: inspect.signature(function).parameters[name].default
        for flag, name in parameters.items()
    }
    assert {flag: flags[flag] for flag in parameters} == defaults
