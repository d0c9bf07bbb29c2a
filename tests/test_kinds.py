"""Arguments of wrong kinds are named in one sentence, by every public function, before anything is done."""

import inspect

import numpy as np
import pytest
from doors import PUBLIC

import igl_spheremap as ism
from igl_spheremap.gate import kinds_of

TRIANGLE = {"v": np.eye(3), "f": [[0, 1, 2]]}
#: Records without contents, of the classes that arguments are of.
RECORDS = [
    object.__new__(type("Empty", (kind,), {"__repr__": lambda self: "Empty()"}))
    for kind in (
        ism.SphereMap,
        ism.DiskMap,
        ism.shapes.SurfaceMap,
        ism.shapes.Group,
        ism.shapes.SphericalHarmonics,
    )
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
FUNCTIONS = {name: inspect.unwrap(one) for name, one in PUBLIC.items() if inspect.isfunction(one)}
CASES = [
    pytest.param(PUBLIC[name], argument, id=f"{name}-{argument}")
    for name, function in FUNCTIONS.items()
    for argument, kinds in kinds_of(function).items()
    if kinds
]


def taken(function, argument, value):
    """Whether an annotation takes a value."""
    kinds = kinds_of(inspect.unwrap(function))[argument]
    return not kinds or any(fits(value) for fits, _ in kinds)


@pytest.mark.parametrize(("function", "argument"), CASES)
def test_an_argument_of_another_kind_is_named(function, argument):
    parameters = inspect.signature(function).parameters
    given = {
        name: TRIANGLE.get(name, next(value for value in VALUES if taken(function, name, value)))
        for name, one in parameters.items()
        if one.default is one.empty or name in TRIANGLE
    }
    wrong = [value for value in VALUES if not taken(function, argument, value)]
    assert len(wrong) > 5
    for value in wrong:
        with pytest.raises(TypeError, match=rf"^{argument} is [^\n]*; give [^\n]*$"):
            function(**given | {argument: value})


def test_what_the_gate_leaves_to_others_is_arrays_meshes_and_records_of_options():
    left = {
        str(function.__annotations__[argument]).removesuffix(" | None")
        for function in FUNCTIONS.values()
        for argument, kinds in kinds_of(function).items()
        if not kinds
    }
    arrays = {hint for hint in left if "ArrayLike" in hint or "MeshLike" in hint}
    assert left - arrays == {"IntArray", "Lai2014"}


def test_the_gate_takes_what_numpy_counts_and_paths_are():
    v, f = ism.samples.sphere(42)
    result = ism.balanced_spherical_map(v, f, balance=np.float32(0.5), listener=None)
    assert ism.shapes.to_grid(result, rows=np.int64(5), labels=np.False_).shape == (5, 10, 3)
