"""Phases divide the time of a run among them, however nested."""

import time

import igl_spheremap as ism
from igl_spheremap.timings import phase, timed, timings


def test_a_stage_counts_what_no_stage_within_it_counts():
    with timed():
        began = time.perf_counter()
        with phase("outer"):
            time.sleep(0.01)
            with phase("inner"):
                time.sleep(0.05)
                with phase("outer"):
                    time.sleep(0.01)
        seconds, passed = timings(), time.perf_counter() - began
    assert seconds["inner"] >= 0.05
    assert seconds["outer"] >= 0.02
    assert sum(seconds.values()) <= passed  # nothing counts twice
    assert timings() == {}


def test_an_error_ends_its_stages():
    with timed():
        try:
            with phase("outer"), phase("inner"):
                raise ValueError
        except ValueError:
            pass
        assert set(timings()) == {"outer", "inner"}


def test_maps_hold_stages_that_take_no_longer_than_they():
    v, f = ism.samples.make("spheroid", n_vertices=2000)
    for result in (
        ism.spherical_conformal_map(v, f),
        ism.spherical_conformal_map(v, f, method="stereographic"),
        ism.SphereMapper(v, f).map(),
        ism.balanced_spherical_map(v, f, balance=0.5),
    ):
        assert 0 < sum(result.timings.values()) <= result.seconds
        assert {"gauge", "certificate"} & result.timings.keys()
    assert {"check", "certificate", "balance"} <= result.timings.keys()
