"""The stateful twin: the same maps as the function's, by one factorisation."""

import threading

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.operators import laplacian as operators_module
from igl_spheremap.operators.factor.factorize import available_backends

V, F = ism.samples.make("dino", n_vertices=1500)


@pytest.fixture(scope="module")
def mapper():
    return ism.SphereMapper(V, F)


@pytest.mark.parametrize(
    "options", [{}, {"tolerance": 1e-8}, {"max_iterations": 1}, {"polish": "angles"}], ids=str
)
def test_gives_the_same_numbers_as_the_function(mapper, options):
    there = ism.spherical_conformal_map(V, F, **options)
    here = (ism.SphereMapper(V, F, method=ism.Auto(**options)) if options else mapper).map()
    np.testing.assert_array_equal(here.sphere, there.sphere)
    assert (here.energy, here.history, here.status) == (there.energy, there.history, there.status)
    assert (here.backend, here.notes, here.method) == (there.backend, there.notes, there.method)


def test_a_map_leaves_nothing_behind_for_the_next(mapper):
    before = mapper.map().sphere
    mapper.map(listener=lambda iterate: None).rebalance(0.5)
    np.testing.assert_array_equal(mapper.map().sphere, before)


def test_factorises_once(monkeypatch):
    v, f = ism.samples.make("spheroid", n_vertices=800)
    calls, factorize = [], operators_module.factorize
    monkeypatch.setattr(
        operators_module, "factorize", lambda *args: calls.append(1) or factorize(*args)
    )
    mapper = ism.SphereMapper(v, f)
    for _ in range(3):
        assert mapper.map().certificate.folding_free
    assert len(calls) == 1


@pytest.mark.parametrize("backend", available_backends())
def test_moved_positions_give_the_map_of_a_new_mapper(backend):
    """Also after positions whose weights are others, with another pattern, or can't be factorised."""
    v, f = ism.samples.make("spheroid", n_vertices=600)
    flat = v.copy()
    flat[f[0]] = flat[f[0, 0]]  # faces of zero area: mollified weights
    mapper = ism.SphereMapper(v, f, method=ism.Auto(backend=backend))
    for w in (v * [1, 1, 1.5], 1e3 * v + 7, flat, v * [1, 0.7, 1]):
        mapper.move(w)
        expected = ism.spherical_conformal_map(w, f, backend=backend)
        np.testing.assert_array_equal(mapper.map().sphere, expected.sphere)
        assert mapper.map().notes == expected.notes
        np.testing.assert_array_equal(mapper.map().vertices, w)
    np.testing.assert_array_equal(
        mapper.map().rebalance(0.3).sphere, expected.rebalance(0.3).sphere
    )


@pytest.mark.parametrize(
    "positions", [V[:-1], V * np.nan, V * 0, [1, 2]], ids=["too few", "NaN", "a point", "no rows"]
)
def test_a_mapper_stays_as_it_is_where_positions_are_refused(mapper, positions):
    before = mapper.map().sphere
    with pytest.raises(ism.MeshError):
        mapper.move(positions)
    np.testing.assert_array_equal(mapper.map().sphere, before)


def test_calls_of_two_threads_give_right_maps_or_an_error():
    shapes = [V * [1, 1, 1 + k / 8] for k in range(4)]
    expected = [ism.spherical_conformal_map(v, F).sphere for v in shapes]
    shared, wrong, refused = ism.SphereMapper(V, F), [], []

    def work(own):
        for k in range(24):
            try:
                shared.move(shapes[(own + k) % 4])
                result = shared.map()
            except RuntimeError as error:
                refused.append(str(error))
                continue
            shape = next(i for i, v in enumerate(shapes) if np.array_equal(result.vertices, v))
            if not np.array_equal(result.sphere, expected[shape]):
                wrong.append(shape)

    threads = [threading.Thread(target=work, args=(own,)) for own in range(3)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []
    assert all("a mapper of its own" in message for message in refused)


def test_a_listener_does_not_move_the_mapper_of_its_run():
    own = ism.SphereMapper(V, F)
    with pytest.raises(RuntimeError, match="whose listener calls it"):
        own.map(listener=lambda iterate: own.move(V))
    assert np.array_equal(own.map().sphere, ism.spherical_conformal_map(V, F).sphere)
