"""What is known of a map is said in the same words by the shell, in notebooks and on pages."""

import json

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.result.findings import angles, areas, verdict
from igl_spheremap.result.sphere_map import map_findings, result_rows

BALL = "sample:spheroid:n_vertices=300"


@pytest.mark.parametrize("balance", [0.0, 0.75])
def test_shell_and_notebook_say_the_same(balance, tmp_path, capsys):
    target = str(tmp_path / "map.npz")
    assert main(["map", BALL, target, "--balance", str(balance)]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    result = ism.read_map(target)
    for label, text in result_rows(result):
        if label not in ("mesh", "method"):
            assert f"{label} {text}" in shown
    assert ("balance 0.75" in shown) == bool(balance)
    assert main(["map", BALL, target, "--balance", str(balance), "--json", "-", "-f"]) == 0
    figures = json.loads(capsys.readouterr().out)
    for finding in map_findings(result):
        assert {key: figures[key] for key in finding.numbers} == finding.numbers


def test_sentences_hold_the_numbers():
    x, f = ism.samples.sphere(42)
    assert verdict(ism.certify(-x, f)).numbers["certificate"]["flipped"] == {"count": 80, "first": list(range(10))}
    assert angles(np.array([[1.0, -2.0, 3.0]])).text.startswith("differ by 2 degrees on average (median 2,")
    assert areas(np.array([0.5, -1.5])).numbers["area_ratios"]["mean"] == 1


def test_the_last_round_is_the_map():
    result = ism.balanced_spherical_map(*ism.samples.make("pear", n_vertices=600), balance=0.75)
    last = result.rounds[-1]
    assert last.mean_angle_difference == pytest.approx(np.abs(result.angle_differences()).mean())
    assert (last.energy, last.foldings_after) == (result.energy, 0)
    assert len(result.rounds) == len(result.conformal.rounds) + 1
