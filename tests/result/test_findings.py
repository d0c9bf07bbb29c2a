"""Shell, notebooks and pages say the findings on a map in the same words."""

import json
from dataclasses import replace

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.maps.sphere_map import map_findings, round_rows
from igl_spheremap.result.findings import angles, areas, certificate_numbers, verdict
from igl_spheremap.result.result import result_rows

BALL = "sample:spheroid:n_vertices=300"


@pytest.mark.parametrize("balance", [0.0, 0.75])
def test_shell_and_notebook_say_the_same(balance, tmp_path, capsys):
    target = str(tmp_path / "map.npz")
    assert main(["map", BALL, target, "--balance", str(balance)]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    result = ism.read_map(target)
    for label, text in result_rows(result, map_findings(result)):
        if label not in ("mesh", "method"):
            assert f"{label} {text}" in shown
    assert ("balance = 0.75" in shown) == bool(balance)
    assert main(["map", BALL, target, "--balance", str(balance), "--json", "-", "-f"]) == 0
    figures = json.loads(capsys.readouterr().out)
    for finding in map_findings(result):
        assert {key: figures[key] for key in finding.numbers} == finding.numbers


def test_sentences_hold_the_numbers():
    x, f = ism.samples.sphere(42)
    assert verdict(ism.certify(-x, f)).numbers["certificate"]["flipped"] == {
        "count": 80,
        "first": list(range(10)),
    }
    assert angles(np.array([[1.0, -2.0, 3.0]])).text.startswith(
        "differ by 2 degrees on average (median 2,"
    )
    assert areas(np.array([0.5, -1.5])).numbers["log_area_ratios"]["mean"] == 1


@pytest.mark.parametrize(("balance", "polish"), [(0.75, "auto"), (0.0, "angles"), (0.0, "auto")])
def test_the_last_row_of_the_rounds_is_the_result(balance, polish):
    """Even where further steps follow the rounds."""
    v, f = ism.samples.make("bird", n_vertices=900)
    result = ism.balanced_spherical_map(v, f, balance=balance, method=ism.Auto(polish=polish))
    rows = round_rows(result)
    assert len(rows) >= len(result.rounds) > 0
    assert rows[-1][-2:] == (
        f"{result.energy:.6f}",
        f"{np.abs(result.angle_differences()).mean():.3g}",
    )


def test_an_angle_that_was_not_measured_is_an_empty_cell():
    v, f = ism.samples.make("bird", n_vertices=900)
    result = ism.spherical_conformal_map(v, f, method=ism.Auto(polish="angles"))
    first, *others = result.rounds
    unmeasured = replace(first, mean_angle_difference=np.nan)
    changed = replace(result, run=replace(result.run, rounds=(unmeasured, *others)))
    before, after = round_rows(result), round_rows(changed)
    assert after[0] == (*before[0][:-1], "")
    assert after[1:] == before[1:]


def test_programs_are_given_where_the_boundary_of_a_map_to_the_plane_crosses_itself():
    bow_tie = ism.certify([[0, 0], [1, 1], [1, 0], [0, 1]], [[0, 1, 2], [0, 2, 3]])
    assert certificate_numbers(bow_tie)["crossings"] == {"count": 2, "first": [0, 2]}
    assert "crossings" not in certificate_numbers(ism.certify(*ism.samples.sphere(42)))
