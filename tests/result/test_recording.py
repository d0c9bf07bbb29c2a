"""Contents of a recording."""

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.draw.run import linear_below, objective, plot_run
from igl_spheremap.result.recording import Recording
from igl_spheremap.result.run import Iterate, Stage, Step


def feed(recording, x, lengths):
    for stage, length in enumerate(lengths):
        for k in range(length):
            recording(Iterate(Stage.ALGORITHM_1, stage, k, x, float(k)))


def test_it_is_the_history_and_the_certificates():
    v, f = ism.samples.make("bird", n_vertices=1500)
    recording = Recording(f)
    result = ism.spherical_conformal_map(
        v, f, method=ism.Lai2014(max_iterations=100), listener=recording
    )
    assert [step.energy for step in recording.history] == [step.energy for step in result.history]
    assert recording.foldings[0] > recording.foldings[-1] == result.certificate.foldings
    for frame in recording.frames[::20]:
        assert (
            frame.foldings
            == ism.certify(frame.iterate.x, f).foldings
            == recording.foldings[frame.index]
        )


@pytest.mark.parametrize("lengths", [(1,), (1000,), (1, 1, 700), (317, 5, 900, 1)])
@pytest.mark.parametrize("room", [20, 57])
def test_it_thins_evenly_in_pairs_and_keeps_both_ends_of_each_stage(lengths, room):
    x, f = np.eye(3), np.array([[0, 1, 2]])
    recording = Recording(f, budget=room * x.nbytes)
    feed(recording, x, lengths)
    kept = [frame.index for frame in recording.frames]
    ends = np.cumsum(lengths)
    assert len(recording.history) == len(recording.foldings) == ends[-1]
    around = {k + shift for k in (0, *ends) for shift in (-2, -1, 0, 1)}
    assert set(kept) >= around & set(range(ends[-1]))
    assert kept == sorted(set(kept))
    assert len(kept) <= room
    steps = np.diff(kept)
    assert steps.max(initial=1) <= max(1, 4 * ends[-1] / (room - len(around)))
    assert (np.minimum(steps[1:], steps[:-1]) == 1).all()


@pytest.mark.parametrize("room", [40, 100])
def test_all_changes_of_the_number_of_foldings_are_kept_before_any_other_step(room):
    x, f = np.eye(3), np.array([[0, 1, 2]])
    changes = np.random.default_rng(0).choice(np.arange(3, 997), 15, replace=False)
    recording = Recording(f, budget=room * x.nbytes)
    for k in range(1000):
        recording(Iterate(Stage.ALGORITHM_1, 0, k, x if (k > changes).sum() % 2 else -x, 0.0))
    kept = {frame.index for frame in recording.frames}
    assert len(kept) <= room
    assert kept >= {*changes.tolist(), *(changes + 1).tolist()}
    assert f"{len(kept)} of 1,000 iterates are kept" in recording.describe()
    assert "all where foldings change" in recording.describe()


def test_where_every_step_changes_the_number_of_foldings_these_are_thinned():
    x, f = np.eye(3), np.array([[0, 1, 2]])
    recording = Recording(f, budget=30 * x.nbytes)
    for k in range(1000):
        recording(Iterate(Stage.ALGORITHM_1, 0, k, x if k % 2 else -x, 0.0))
    kept = np.array([frame.index for frame in recording.frames])
    assert 10 < len(kept) <= 30
    assert (np.diff(kept) == 1).sum() >= len(kept) // 2


def test_the_latest_iterate_is_always_there():
    x, f = np.eye(3), np.array([[0, 1, 2]])
    recording = Recording(f, budget=5 * x.nbytes)
    for k in range(300):
        recording(Iterate(Stage.ALGORITHM_1, 0, k, x, float(k)))
        assert recording.frames[-1].index == k


def step(stage, energy):
    return Step(Stage(stage), 0, 0, energy, 0.0, 0.0)


def test_what_is_minimised_falls_in_its_curve():
    """Below 4 pi, too, where a discrete energy may end; its absolute value would rise there."""
    above = [12.5679, 12.5664, 12.5649]
    at, values, name = objective([step("sobolev", energy) for energy in above])
    assert at.tolist() == [0, 1, 2]
    assert (np.diff(values) < 0).all()
    assert values[0] > 0 > values[-1]
    assert name == "energy minus 4π"
    assert linear_below(values) == np.inf


def test_the_curve_of_another_energy_begins_where_it_is_minimised_first():
    history = [
        step("sobolev", 12.57),
        step("opening", 247.0),
        step("balance", 3.3),
        step("balance", 3.0),
    ]
    at, values, name = objective(history)
    assert (at.tolist(), values.min(), name) == (
        [2, 3],
        0,
        "energy of the balance above its minimum",
    )


def test_a_plot_shows_no_logarithms_of_what_is_about_zero():
    v, f = ism.samples.make("spheroid", n_vertices=500)
    recording = Recording(f)
    result = ism.spherical_conformal_map(v, f, listener=recording)
    figure = plot_run(
        recording.history, recording.foldings, result.angle_differences(), result.log_area_ratios()
    )
    energy = figure.axes[0]
    assert energy.get_yscale() == "linear"
    shown = energy.get_lines()[0].get_ydata()
    assert np.argmin(shown) == np.argmin([one.energy for one in recording.history])


def test_zeros_and_two_points_are_said_and_not_drawn():
    history = [step("harmonic", 12.6), step("harmonic", 12.57)]
    rest = np.zeros((4, 3)), np.zeros(4)
    figure = plot_run(history, [0, 0], *rest, title="a.ply")
    assert len(figure.axes) == 2
    assert [text.get_text() for text in figure.texts] == [
        "a.ply\nenergy minus 4π: 0.0336 to 0.00363; no face is folded in any iterate"
    ]
    assert [ax.get_title() for ax in plot_run(history * 2, [0, 1, 1, 0], *rest).axes[:2]] == [
        "energy minus 4π",
        "folded faces",
    ]


def test_ticks_of_iterations_are_whole_numbers():
    history = [step("harmonic", 12.6 - 0.01 * k) for k in range(4)]
    figure = plot_run(history, [2, 1, 1, 0], np.zeros((4, 3)), np.zeros(4))
    for ax in figure.axes[:2]:
        assert {float(tick).is_integer() for tick in ax.get_xticks()} == {True}


def test_the_drawn_curve_has_each_folding_of_a_long_run():
    history = [step("harmonic", 12.6)] * 30_000
    folded = np.random.default_rng(1).choice(len(history) // 64, 90, replace=False) * 64 + 7
    counts = np.zeros(len(history), dtype=int)
    counts[folded] = np.arange(1, 91)
    figure = plot_run(history, counts, np.zeros((4, 3)), np.zeros(4))
    (curve,) = (ax.lines[0] for ax in figure.axes if ax.get_title() == "folded faces")
    x, y = curve.get_data()
    assert sorted(x[y > 0]) == sorted(folded)
    assert (y == counts[x]).all()
    assert len(x) < 3000


@pytest.mark.parametrize("budget", [float("nan"), -1, "much"])
def test_a_budget_is_a_number_of_bytes(budget):
    with pytest.raises((TypeError, ValueError), match=r"^budget is "):
        ism.Recording(ism.samples.sphere(42)[1], budget=budget)
