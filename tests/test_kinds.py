"""Arguments of wrong kinds are named in one sentence, by every public function, before anything is done."""

import inspect

import numpy as np
import pytest
from doors import PUBLIC

import igl_spheremap as ism
from igl_spheremap.gate import _kinds

TRIANGLE = {"v": np.eye(3), "f": [[0, 1, 2]]}
#: Stand-ins for records, which are known by the names of their classes.
RECORDS = [
    type(name, (), {})()
    for name in ("SphereMap", "PlaneMap", "SurfaceMap", "Group", "SphericalHarmonics")
]
#: Values of all kinds: what an argument takes is given to it, what it does not take must be refused.
VALUES = [
    3,
    -1,
    0.5,
    float("nan"),
    "abc",
    [1, 2],
    len,
    True,
    {},
    *RECORDS,
    None,
    b"x",
    np.zeros((2, 2, 2)),
    object(),
]
CASES = [
    pytest.param(function, argument, id=f"{name}-{argument}")
    for name, function in PUBLIC.items()
    if inspect.isfunction(function)
    for argument, parameter in inspect.signature(function).parameters.items()
    if _kinds(str(parameter.annotation))
]


def taken(parameter, value):
    """Whether an annotation takes a value."""
    kinds = _kinds(str(parameter.annotation))
    return not kinds or any(fits(value) for fits, _ in kinds)


@pytest.mark.parametrize(("function", "argument"), CASES)
def test_an_argument_of_another_kind_is_named(function, argument):
    parameters = inspect.signature(function).parameters
    given = {
        name: TRIANGLE.get(name, next(value for value in VALUES if taken(one, value)))
        for name, one in parameters.items()
        if one.default is one.empty or name in TRIANGLE
    }
    wrong = [value for value in VALUES if not taken(parameters[argument], value)]
    assert len(wrong) > 5
    for value in wrong:
        with pytest.raises(TypeError, match=rf"^{argument} is [^\n]*; give [^\n]*$"):
            function(**given | {argument: value})


def test_the_gate_takes_what_numpy_counts_and_paths_are():
    v, f = ism.samples.sphere(42)
    result = ism.balanced_spherical_map(v, f, balance=np.float32(0.5), listener=None)
    assert ism.shapes.to_grid(result, rows=np.int64(5), labels=np.False_).shape == (5, 10, 3)
