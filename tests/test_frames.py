"""How deep a call is: a reader who follows it has at most 13 functions in mind, and 15 where steps improve the map."""

import sys
from pathlib import Path

import pytest

import igl_spheremap as ism

ROOT = str(Path(ism.__file__).parent)


def deepest(call):
    """The longest chain of nested frames of the package while a function runs."""
    chain, longest = [], []

    def follow(frame, event, _):
        if not frame.f_code.co_filename.startswith(ROOT):
            return
        if event == "call":
            chain.append(f"{frame.f_code.co_filename.removeprefix(ROOT)}: {frame.f_code.co_name}")
            longest[:] = max(longest, chain, key=len)
        elif event == "return" and chain:
            chain.pop()

    sys.setprofile(follow)
    try:
        call()
    finally:
        sys.setprofile(None)
    return longest


@pytest.mark.parametrize(("name", "most"), [("spheroid", 13), ("bird", 13), ("octopus", 15)])
def test_a_plain_call_is_as_deep_as_a_reader_can_follow(name, most):
    """Of maps that stay as they are, and of one that is improved."""
    v, f = ism.samples.make(name, n_vertices=2000)
    ism.spherical_conformal_map(v, f)  # imports, which are no work of a call
    frames = deepest(lambda: ism.spherical_conformal_map(v, f))
    assert len(frames) <= most, "\n".join(frames)
