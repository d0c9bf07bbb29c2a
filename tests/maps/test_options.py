"""Records of options: one default in every place that spells it, and refusals before anything is computed."""

import inspect
import subprocess
import sys
from dataclasses import FrozenInstanceError, fields

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.descent.preconditioned import harmonic_map
from igl_spheremap.maps.options import METHODS

V, F = ism.samples.make("spheroid", n_vertices=400)


def defaults(function):
    return {p.name: p.default for p in inspect.signature(function).parameters.values() if p.kind is p.KEYWORD_ONLY}


@pytest.mark.parametrize(("function", "record", "left_out"), [
    (ism.spherical_conformal_map, ism.Auto, set()),
    (harmonic_map, ism.Auto, {"backend", "effort", "gauge", "polish"}),
])
def test_keywords_have_the_names_and_defaults_of_the_record(function, record, left_out):
    options = {option.name: option.default for option in fields(record) if option.name not in left_out}
    assert defaults(function) == options | {"listener": None}


@pytest.mark.parametrize("function", [ism.minimize_harmonic_energy, ism.remove_foldings])
def test_the_algorithms_by_name_take_the_papers_record(function):
    assert defaults(function) == {"method": ism.Lai2014(), "listener": None}
    assert function(V, F, method=ism.Lai2014(xi=0.5)).settings["xi"] == 0.5


def test_each_method_is_known_by_name_and_shown_to_completion():
    for name, record in METHODS.items():
        assert record.name == name
        assert getattr(ism, record.__name__) is record
        assert all(f"\n{option.name} : " in inspect.getdoc(record) for option in fields(record))


@pytest.mark.parametrize("name", METHODS)
def test_a_name_is_its_record_of_defaults(name):
    by_name, by_record = (ism.spherical_conformal_map(V, F, method) for method in (name, METHODS[name]()))
    assert np.array_equal(by_name.sphere, by_record.sphere)
    assert (by_name.method, by_name.settings) == (by_record.method, by_record.settings) == (name, {})


def test_settings_are_what_is_not_at_its_default():
    assert ism.Lai2014(rounds=3, xi=0.5).settings() == {"xi": 0.5}
    result = ism.spherical_conformal_map(V, F, polish="angles", tolerance=1e-3)
    assert result.settings == {"polish": "angles"}
    again = METHODS[result.method](**result.settings)
    assert np.array_equal(ism.spherical_conformal_map(V, F, again).sphere, result.sphere)


def test_less_effort_costs_angles_and_no_certificate_and_settings_say_so():
    v, f = ism.samples.make("octopus", n_vertices=2000)
    least, most = (ism.spherical_conformal_map(v, f, effort=effort)
                   for effort in (ism.Effort(systems=0, sweeps=0), ism.Effort()))
    assert least.certificate.folding_free
    assert np.abs(least.angle_differences()).mean() > 1.02 * np.abs(most.angle_differences()).mean()
    assert least.settings == {"effort": {"systems": 0, "sweeps": 0, "least_gain": 0.025}}
    assert METHODS["auto"](**least.settings) == ism.Auto(effort=ism.Effort(systems=0, sweeps=0))


@pytest.mark.parametrize(("wrong", "error", "message"), [
    ({"systems": -1}, ValueError, "systems is -1; give 0 or more"),
    ({"sweeps": 2.5}, TypeError, "sweeps is 2.5; give a whole number"),
    ({"least_gain": float("nan")}, ValueError, "least_gain is nan"),
    ({"least_gain": "little"}, TypeError, "least_gain is 'little'; give a number"),
])
def test_an_effort_that_is_none_is_refused(wrong, error, message):
    with pytest.raises(error, match=message):
        ism.Effort(**wrong)
    with pytest.raises(error, match=message):
        ism.Auto(effort=wrong)
    with pytest.raises(TypeError, match="give a record"):
        ism.Auto(effort=ism.Effort)


def test_records_are_frozen_and_equal_by_value():
    assert ism.Lai2014(rounds=1) == ism.Lai2014(rounds=1) != ism.Lai2014()
    with pytest.raises(FrozenInstanceError):
        ism.Auto().tolerance = 1.0


@pytest.mark.parametrize(("record", "wrong", "message"), [
    (ism.Auto, {"gauge": "left"}, "unknown gauge 'left': choose 'poles' or 'centred'"),
    (ism.Auto, {"polish": "floor"}, "unknown polish 'floor': choose 'angles'"),
    (ism.Lai2014, {"weights": "uniform"}, "unknown weights 'uniform': choose 'cotangent' or 'delaunay'"),
    (ism.Lai2014, {"bb": "tau"}, "unknown bb 'tau': choose 'alternating' or 'tau_1' or 'tau_2'"),
    (ism.GuYau, {"step": 2.0}, "unstable"),
    (ism.Lai2014, {"rounds": -1}, "rounds is -1; give 0 or more"),
    (ism.Lai2014, {"delta": 1.5}, "delta is 1.5; give a number from 0 to 1"),
    *((record, {"max_iterations": -1}, "max_iterations is -1") for record in METHODS.values()),
    (ism.Stereographic, {"plane": "circle-packing"}, "'laplace-beltrami' or 'conformal-equivalence'"),
])
def test_unknown_choices_are_refused_with_what_there_is(record, wrong, message):
    with pytest.raises(ValueError, match=message):
        record(**wrong)


def test_the_front_door_loads_no_solver_before_the_first_call():
    code = ("import sys, igl_spheremap as ism; ism.spherical_conformal_map; ism.Auto;"
            "print(*sorted({m.split('.')[0] for m in sys.modules} & {'scipy', 'igl'}))")
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert loaded == []
