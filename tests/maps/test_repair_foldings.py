"""The repair of maps from any program: what folds is repaired, all else stays."""

import numpy as np
import pytest
from triangulations import icosphere

import igl_spheremap as ism


def test_any_map_is_repaired_and_the_listener_sees_foldings_vanish():
    v, f = ism.samples.make("spheroid", n_vertices=1000)
    x = ism.spherical_conformal_map(v, f).sphere.copy()
    x[f[7, :2]] = x[f[7, 1::-1]]  # two neighbours exchanged
    seen = []
    result = ism.repair_foldings(v, f, x, listener=seen.append)
    assert result.certificate.folding_free
    assert seen[0].residual == ism.certify(x, f).foldings == result.rounds[0].foldings_before > 0
    far = np.linalg.norm(x - x[f[7, 0]], axis=1) > 0.5
    assert (result.sphere[far] == x[far]).all()
    assert seen[-1].residual == 0
    assert {it.stage for it in seen} == {"map", "repair", "repaired"}


def test_a_good_map_of_another_program_stays_bit_for_bit():
    x, f = icosphere(2)
    single = x.astype(np.float32)
    result = ism.repair_foldings(x, f, single)
    assert (result.sphere == single).all()
    assert result.certificate.folding_free
    assert result.gauge == "given"


def test_a_map_turned_inside_out_is_reflected():
    x, f = icosphere(3)
    v = x * [1.0, 1.1, 1.2]
    result = ism.repair_foldings(v, f, -x)
    assert result.certificate.folding_free
    assert np.abs(result.angle_differences()).mean() == pytest.approx(np.abs(ism.angle_differences(v, f, x)).mean())


def test_an_unknown_polish_is_refused():
    x, f = icosphere(1)
    with pytest.raises(ValueError, match="unknown polish 'floor'"):
        ism.repair_foldings(x, f, x, polish="floor")


@pytest.mark.parametrize("bad", [0.0, np.nan, np.inf])
def test_rows_without_direction_are_refused(bad):
    x, f = icosphere(1)
    y = x.copy()
    y[5] = bad
    with pytest.raises(ism.MeshError):
        ism.repair_foldings(x, f, y)
