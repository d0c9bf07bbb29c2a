"""How deep a call is: a reader who follows it has at most 15 functions in mind."""

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


@pytest.mark.parametrize("name", ["spheroid", "bird", "octopus"])
def test_a_plain_call_is_at_most_15_frames_deep(name):
    """Of maps that stay as they are, whose angles are improved, and that are repaired."""
    v, f = ism.samples.make(name, n_vertices=2000)
    ism.spherical_conformal_map(v, f)  # imports, which are no work of a call
    frames = deepest(lambda: ism.spherical_conformal_map(v, f))
    assert len(frames) <= 15, "\n".join(frames)
