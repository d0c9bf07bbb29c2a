"""Numbers out of range are one line and status 64, before anything is read."""

import pytest

from igl_spheremap.apps.cli import main


@pytest.mark.parametrize(("words", "problem"), [
    ("map a b --tolerance nan", "nan is out of range: give a number from 0"),
    ("map a b --tolerance -1", "-1 is out of range: give a number from 0"),
    ("map a b --max-iterations -5", "-5 is out of range: give a whole number from 0"),
    ("map a b --max-iterations 1e3", "invalid number value: '1e3'"),
    ("map a b --radius inf", "inf is out of range: give a number above 0"),
    ("map a b --balance nan", "nan is out of range: give a number from 0 to 1"),
    ("p-harmonic a b -p 1", "1 is out of range: give a number above 1"),
    ("harmonics a b c --degree -1", "-1 is out of range: give a whole number from 0"),
    ("view a --size 100000 1000", "100000 is out of range: give a whole number from 200 to 8192"),
    ("play a --length 0", "0 is out of range: give a whole number from 1"),
])
def test_numbers_out_of_range_are_one_line(words, problem, capsys):
    assert main(words.split()) == 64
    assert problem in capsys.readouterr().err
