"""Records of options: one default in every place that spells it, and refusals before anything is computed."""

import inspect
import subprocess
import sys
from dataclasses import FrozenInstanceError, fields
from typing import get_type_hints

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.descent.preconditioned import harmonic_map
from igl_spheremap.maps.options import METHODS
from igl_spheremap.maps.variational import Fidelity, Landmarks, PHarmonic

V, F = ism.samples.make("spheroid", n_vertices=400)


def defaults(function):
    """Of keywords but those that are of one mesh, or of one run."""
    return {
        p.name: p.default
        for p in inspect.signature(function).parameters.values()
        if p.kind is p.KEYWORD_ONLY
        and p.name not in ("start", "landmark_weights", "caps", "listener")
    }


@pytest.mark.parametrize(
    ("function", "record", "left_out"),
    [
        (ism.spherical_conformal_map, ism.Auto, set()),
        (harmonic_map, ism.Auto, {"backend", "effort", "gauge", "polish"}),
        (ism.p_harmonic_map, PHarmonic, {"p"}),
        (ism.landmark_map, Landmarks, set()),
        (ism.fidelity_map, Fidelity, set()),
    ],
)
def test_keywords_have_the_names_and_defaults_of_the_record(function, record, left_out):
    options = {
        option.name: option.default for option in fields(record) if option.name not in left_out
    }
    assert {
        name: value for name, value in defaults(function).items() if name != "method"
    } == options


@pytest.mark.parametrize("function", [ism.algorithm_1, ism.algorithm_2])
def test_the_algorithms_by_name_take_the_papers_record(function):
    assert defaults(function) == {"method": ism.Lai2014()}
    assert function(V, F, method=ism.Lai2014(xi=0.5)).settings["xi"] == 0.5


def test_each_method_is_known_by_name_and_shown_to_completion():
    for name, record in METHODS.items():
        assert record.name == name
        assert getattr(ism, record.__name__) is record
        assert all(f"\n{option.name} : " in inspect.getdoc(record) for option in fields(record))


@pytest.mark.parametrize("name", METHODS)
def test_a_name_is_its_record_of_defaults(name):
    by_name, by_record = (
        ism.spherical_conformal_map(V, F, method=method) for method in (name, METHODS[name]())
    )
    assert np.array_equal(by_name.sphere, by_record.sphere)
    assert (
        (by_name.method, by_name.settings) == (by_record.method, by_record.settings) == (name, {})
    )


def test_settings_are_what_is_not_at_its_default():
    assert ism.Lai2014(rounds=1, xi=0.5).settings() == {"xi": 0.5}
    result = ism.spherical_conformal_map(V, F, polish="angles", tolerance=1e-3)
    assert result.settings == {"polish": "angles"}
    again = METHODS[result.method](**result.settings)
    assert np.array_equal(ism.spherical_conformal_map(V, F, method=again).sphere, result.sphere)


def test_less_effort_costs_angles_and_no_certificate_and_settings_say_so():
    v, f = ism.samples.make("octopus", n_vertices=2000)
    least, most = (
        ism.spherical_conformal_map(v, f, effort=effort)
        for effort in (ism.Effort(systems=0), ism.Effort())
    )
    assert least.certificate.folding_free
    assert np.abs(least.angle_differences()).mean() > 1.02 * np.abs(most.angle_differences()).mean()
    assert least.settings == {"effort": {"systems": 0}}
    assert METHODS["auto"](**least.settings) == ism.Auto(effort=ism.Effort(systems=0))


@pytest.mark.parametrize(
    ("wrong", "error", "message"),
    [
        ({"systems": -1}, ValueError, "systems is -1; give 0 or more"),
        ({"systems": 2.5}, TypeError, "systems is 2.5; give a whole number"),
        ({"least_gain": float("nan")}, ValueError, "least_gain is nan"),
        ({"least_gain": "little"}, TypeError, "least_gain is 'little'; give a number"),
    ],
)
def test_an_effort_that_is_none_is_refused(wrong, error, message):
    with pytest.raises(error, match=message):
        ism.Effort(**wrong)
    with pytest.raises(error, match=message):
        ism.Auto(effort=wrong)
    with pytest.raises(TypeError, match="give a record"):
        ism.Auto(effort=ism.Effort)


def test_records_are_frozen_and_equal_by_value():
    assert ism.Lai2014(rounds=2) == ism.Lai2014(rounds=2) != ism.Lai2014()
    with pytest.raises(FrozenInstanceError):
        ism.Auto().tolerance = 1.0


@pytest.mark.parametrize(
    ("record", "wrong", "message"),
    [
        (ism.Auto, {"gauge": "left"}, "unknown gauge 'left': choose 'poles' or 'centred'"),
        (
            ism.Auto,
            {"polish": "floor"},
            "unknown polish 'floor': choose 'auto' or 'angles' or None",
        ),
        (
            ism.Lai2014,
            {"edge_weights": "uniform"},
            "unknown edge_weights 'uniform': choose 'delaunay' or 'cotangent'",
        ),
        (
            ism.Lai2014,
            {"bb": "tau"},
            "unknown bb 'tau': choose 'tau_1 first' or 'tau_2 first' or 'tau_1' or 'tau_2'",
        ),
        (
            ism.Lai2014,
            {"rules": "program"},
            r"no safeguards: .* may_fold=True and gauge='free', .*as_programmed\(\)",
        ),
        (ism.Lai2014.as_programmed, {"may_fold": False}, "no safeguards"),
        (ism.Lai2014.as_programmed, {"gauge": "centred"}, "no safeguards"),
        (ism.GuYau, {"step": 2.0}, "unstable"),
        (ism.Lai2014, {"rounds": -1}, "rounds is -1; give 0 or more"),
        (ism.Lai2014, {"delta": 1.5}, "delta is 1.5; give a number from 0 to 1"),
        *(
            (record, {"max_iterations": -1}, "max_iterations is -1")
            for record in METHODS.values()
            if record is not ism.Stereographic
        ),
        (ism.Stereographic, {"puncture": -1}, "puncture is -1"),
    ],
)
def test_unknown_choices_are_refused_with_what_there_is(record, wrong, message):
    with pytest.raises(ValueError, match=message):
        record(**wrong)


@pytest.mark.parametrize("record", [*METHODS.values(), PHarmonic, Landmarks, Fidelity])
@pytest.mark.parametrize(
    ("kind", "value", "error"),
    [
        (float, -1e-3, "ValueError"),
        (float, float("nan"), "ValueError"),
        (float, "1e-3", "TypeError"),
        (float, None, "TypeError"),
        (float, True, "TypeError"),
        (int, 2.5, "TypeError"),
        (int, True, "TypeError"),
        (int, -1, "ValueError"),
        (int, "3", "TypeError"),
        (bool, 1, "TypeError"),
        (str, 7, "TypeError"),
    ],
)
def test_values_of_another_kind_are_refused_where_the_record_is_built(record, kind, value, error):
    hints = get_type_hints(record)
    for option in fields(record):
        if hints[option.name] is kind:
            with pytest.raises(
                (ValueError, TypeError), match=rf"^{option.name} [^\n]*; give [^\n]*$"
            ) as refused:
                record(**{option.name: value})
            assert type(refused.value).__name__ == error


def test_numbers_of_numpy_are_numbers():
    assert ism.Auto(tolerance=np.float32(0.5), max_iterations=np.int64(3)) == ism.Auto(
        tolerance=0.5, max_iterations=3
    )


@pytest.mark.parametrize(
    "call",
    [
        lambda **options: ism.spherical_conformal_map(V, F, **options),
        lambda **options: ism.p_harmonic_map(V, F, 3, **options),
        lambda **options: ism.landmark_map(V, F, [0], V[:1], **options),
    ],
)
@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"max_iterations": -1}, ValueError, "max_iterations is -1; give 0 or more"),
        ({"max_iterations": 1.5}, TypeError, "max_iterations is 1.5; give a whole number"),
        ({"listener": 3}, TypeError, "listener is 3; give a function"),
    ],
)
def test_keywords_are_refused_as_options_of_records_are(call, options, error, message):
    with pytest.raises(error, match=message):
        call(**options)


@pytest.mark.parametrize(
    "call",
    [
        lambda: ism.spherical_conformal_map(V, F, method=ism.Auto),
        lambda: ism.balanced_spherical_map(V, F, balance=1, method=ism.Auto),
        lambda: ism.SphereMapper(V, F, method=ism.Auto),
        lambda: ism.map_many([], "", method=ism.Auto),
    ],
)
def test_a_class_is_no_record(call):
    with pytest.raises(
        TypeError, match=r"method is <class .*Auto.*>; give .*a record of options, such as Auto\(\)"
    ):
        call()


@pytest.mark.parametrize(
    "call",
    [
        lambda: ism.SphereMapper(V, F, method=ism.Lai2014()),
        lambda: ism.SphereMapper(V, F, method="auto"),
        lambda: ism.algorithm_1(V, F, method="lai2014"),
        lambda: ism.algorithm_2(V, F, method=ism.Auto()),
        lambda: ism.spherical_conformal_map(V, F, method=3),
    ],
)
def test_records_of_other_methods_are_refused(call):
    with pytest.raises(
        TypeError, match=r"method is .*; give .*a record of options, such as \w+\(\)"
    ):
        call()


@pytest.mark.parametrize(
    ("balance", "error"),
    [
        ("1", TypeError),
        (None, TypeError),
        (True, TypeError),
        ([1], TypeError),
        (float("nan"), ValueError),
        (1.5, ValueError),
        (-0.1, ValueError),
    ],
)
def test_a_balance_is_a_number_from_0_to_1(balance, error):
    result = ism.spherical_conformal_map(V, F)
    for call in (
        lambda: ism.balanced_spherical_map(V, F, balance=balance),
        lambda: result.rebalance(balance),
        lambda: ism.map_many([], "", balance=balance),
    ):
        with pytest.raises(error, match="balance"):
            call()


def test_options_of_what_takes_maps_are_refused_too():
    result = ism.spherical_conformal_map(V, F)
    for call, message in (
        (
            lambda: ism.shapes.register(result, result, stiffness="soft"),
            "stiffness is 'soft'; give a number",
        ),
        (lambda: ism.shapes.register(result, result, listener=3), "listener is 3"),
        (
            lambda: ism.shapes.spherical_harmonics(result, degree=2.5),
            "degree is 2.5; give a whole number",
        ),
        (
            lambda: ism.shapes.spherical_harmonics(result, oversampling="4"),
            "oversampling is '4'; give a number",
        ),
        (lambda: ism.shapes.to_grid(result, rows=True), "rows is True; give a whole number"),
        (lambda: ism.map_many([], "", listener=3), "listener is 3"),
    ):
        with pytest.raises(TypeError, match=message):
            call()


def test_the_front_door_loads_no_solver_before_the_first_call():
    code = (
        "import sys, igl_spheremap as ism; ism.spherical_conformal_map; ism.Auto;"
        "print(*sorted({m.split('.')[0] for m in sys.modules} & {'scipy', 'igl'}))"
    )
    loaded = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout.split()
    assert loaded == []
