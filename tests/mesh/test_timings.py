"""Stages share the time of a run among them, whatever is nested in what."""

import time

import igl_spheremap as ism
from igl_spheremap.mesh.timings import stage, timed, timings


def test_a_stage_counts_what_no_stage_within_it_counts():
    with timed():
        with stage("outer"):
            time.sleep(0.01)
            with stage("inner"):
                time.sleep(0.05)
                with stage("outer"):
                    time.sleep(0.01)
        seconds = timings()
    assert seconds["inner"] > 0.05
    assert 0.02 < seconds["outer"] < seconds["inner"] + 0.01
    assert timings() == {}


def test_an_error_ends_its_stages():
    with timed():
        try:
            with stage("outer"), stage("inner"):
                raise ValueError
        except ValueError:
            pass
        assert set(timings()) == {"outer", "inner"}


def test_the_stages_of_a_map_make_up_its_seconds():
    v, f = ism.samples.make("spheroid", n_vertices=2000)
    ism.spherical_conformal_map(v, f)  # imports
    for result in (ism.spherical_conformal_map(v, f), ism.spherical_conformal_map(v, f, "stereographic"),
                   ism.SphereMapper(v, f).map(), ism.balanced_spherical_map(v, f, 0.5)):
        assert 0.5 * result.seconds < sum(result.timings.values()) <= result.seconds
        assert {"gauge", "certificate", "balance"} & result.timings.keys()
