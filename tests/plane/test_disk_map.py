"""Maps to the unit disk against exact ones."""

import numpy as np
import pytest
from disks import cap, grid, half, polar

import igl_spheremap as ism
from igl_spheremap.angles import repair
from igl_spheremap.angles.layout import unroll
from igl_spheremap.balance.energy import BalancedEnergy
from igl_spheremap.balance.family import POWER
from igl_spheremap.balance.flat_faces import FlatFaces
from igl_spheremap.errors import FactorisationFailed
from igl_spheremap.newton.system import VertexSystem
from igl_spheremap.plane.sliding import slide
from igl_spheremap.plane.tutte import by_lengths, tutte_map
from igl_spheremap.result.run import History
from igl_spheremap.untangle.local_repair import repair_locally


def flat(p):
    return np.column_stack((p, np.zeros(len(p))))


def rms(disk, exact):
    return np.sqrt((disk.mesh.A * ((disk.plane - exact) ** 2).sum(axis=1)).sum())


@pytest.mark.parametrize("angle", [75, 150])
def test_errors_on_a_cap_fall_with_the_square_of_its_edges(angle):
    errors = []
    for rings in (8, 16, 32):
        v, f, exact = cap(rings, np.radians(angle))
        disk = ism.disk_conformal_map(v, f)
        assert disk.certificate
        errors.append(rms(disk, exact))
    assert np.log2(errors[1] / errors[2]) > 1.8
    assert np.log2(errors[0] / errors[2]) / 2 > 1.8


def test_a_disk_is_its_own_map():
    p, f = polar(12)
    disk = ism.disk_conformal_map(flat(3 * p + 1), f)
    assert np.abs(disk.plane - p).max() < 1e-3
    assert np.abs(disk.angle_differences()).mean() < 0.2


def test_the_map_is_the_same_after_similarities_and_moebius_maps_of_the_source():
    v, f, _ = cap(16, 1.8)
    disk = ism.disk_conformal_map(v, f)
    moved = ism.disk_conformal_map(2e5 * v - 7e4, f)
    assert np.abs(moved.plane - disk.plane).max() < 1e-4
    # an inversion, then a mirror image: conformal, and keeps orientation
    centre = np.array([0.3, -0.2, -2.0])
    w = v - centre
    w = w / (w**2).sum(axis=1)[:, None] * [1, 1, -1]
    other = ism.disk_conformal_map(w, f).plane @ [1, 1j]
    mine = disk.plane @ [1, 1j]
    # The two differ by an automorphism of the disk, which three boundary points determine: cross ratios agree.
    a, b, c = disk.rim[:: len(disk.rim) // 3][:3]

    def ratios(z):
        return (z - z[a]) * (z[b] - z[c]) / ((z - z[c] + (z == z[c])) * (z[b] - z[a]))

    inside = np.flatnonzero(np.abs(mine) < 0.9)
    assert np.abs(ratios(other) - ratios(mine))[inside].max() < 0.05


def test_the_boundary_runs_once_along_the_circle():
    v, f, _ = half(*ism.samples.make("spheroid", n_vertices=2000))
    for balance in (0, 0.5, 1):
        disk = ism.balanced_disk_map(v, f, balance=balance)
        q = disk.plane[disk.rim]
        assert np.abs(np.hypot(q[:, 0], q[:, 1]) - 1).max() < 1e-15
        turn = np.angle(np.roll(q @ [1, 1j], -1) / (q @ [1, 1j]))
        assert (turn > 0).all()
        assert turn.sum() == pytest.approx(2 * np.pi)
        assert disk.certificate.folding_free
        assert (ism.certify(disk.plane, f).folding_free, disk.balance) == (True, balance)


def test_balances_lead_from_conformal_to_area_preserving():
    v, f, _ = half(*ism.samples.make("spheroid", n_vertices=2000), axis=0)
    conformal = ism.disk_conformal_map(v, f)
    maps = [conformal, conformal.rebalance(0.5), conformal.rebalance(1)]
    angles = [np.abs(m.angle_differences()).mean() for m in maps]
    areas = [np.abs(m.log_area_ratios()).mean() for m in maps]
    assert angles == sorted(angles)
    assert areas == sorted(areas, reverse=True)
    assert areas[2] < 0.06
    assert maps[2].conformal is conformal
    assert maps[1].rebalance(0) is conformal


def test_the_area_preserving_map_of_a_cap_keeps_its_symmetry():
    v, f, exact = cap(16, np.radians(120))
    p = ism.balanced_disk_map(v, f, balance=1).plane
    radius = np.sin(np.arccos(v[:, 2]) / 2) / np.sin(np.radians(60))  # Lambert's projection
    direction = exact / np.maximum(np.hypot(*exact.T), 1e-9)[:, None]
    assert np.sqrt(((p - radius[:, None] * direction) ** 2).sum(axis=1).mean()) < 0.02


def test_sliding_and_doubling_agree():
    v, f, exact = cap(16, 1.8)
    mesh = ism.check_disk(v, f)
    energy = BalancedEnergy(FlatFaces.of(mesh.unit, mesh.f), 0.0, POWER, np.zeros(len(f)))
    p, _ = slide(
        mesh,
        energy,
        tutte_map(mesh, by_lengths(mesh)),
        History(),
        VertexSystem(mesh.f, len(mesh.v)),
    )
    disk = ism.disk_conformal_map(v, f)
    assert np.abs(np.abs(p @ [1, 1j]) - np.hypot(*exact.T)).max() < 0.1
    assert ism.certify(p, f)
    assert not disk.run.notes


@pytest.mark.parametrize(
    "faces",
    [
        [[0, 1, 2]],
        [[0, 1, 2], [0, 2, 3]],
        [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]],
        [[0, 1, 2], [0, 2, 3], [0, 3, 4]],
    ],
)
@pytest.mark.parametrize("balance", [0, 1])
def test_the_smallest_disks(faces, balance):
    v = np.array([[0, 0, 0], [1, 0, 0.1], [1, 1, 0], [0, 1, 0.3], [0.2, 0.6, 0]])[
        : np.max(faces) + 1
    ]
    disk = ism.balanced_disk_map(v, faces, balance=balance)
    assert disk.certificate.folding_free
    assert ism.flatten(v, faces).certificate.folding_free


def test_a_strip_without_inner_vertices():
    p, f = grid(2, 30)
    v = np.column_stack((np.cos(p[:, 0] / 10), np.sin(p[:, 0] / 10), p[:, 1] / 10))
    assert ism.disk_conformal_map(v, f).certificate.folding_free


@pytest.mark.parametrize("scale", [1e-150, 1e-9, 1e12, 1e150])
def test_no_scale_is_too_small_or_too_large(scale):
    v, f, _ = cap(6, 1.0)
    assert (
        np.abs(
            ism.disk_conformal_map(scale * v, f).plane - ism.disk_conformal_map(v, f).plane
        ).max()
        < 1e-4
    )


def test_slivers_do_not_fold():
    p, f = grid(12, 12)
    v = np.column_stack((p[:, 0], 1e-7 * p[:, 1], np.sin(p[:, 0])))
    assert ism.disk_conformal_map(v, f).certificate.folding_free
    assert ism.flatten(v, f).certificate.folding_free


def test_a_deep_tube_keeps_its_tip():
    """It has 60 radii, so that its end is e^-60 as large as the disk: float64 has such numbers at the origin only."""
    rings, around = 151, 12
    p, f = grid(rings, around + 1)
    number = np.arange(len(p)).reshape(rings, -1)
    number[:, -1] = number[:, 0]
    f = np.vstack(
        (number.ravel()[f], [[number[-1, k], number[-1, k + 1], len(p)] for k in range(around)])
    )
    turn = 2 * np.pi * (p[:, 0] + p[:, 1] / 2) / around
    v = np.vstack((np.column_stack((np.cos(turn), np.sin(turn), 0.4 * p[:, 1])), [[0, 0, 60]]))
    rows, f = np.unique(f, return_inverse=True)
    disk = ism.disk_conformal_map(v[rows], f.reshape(-1, 3))
    assert disk.certificate.folding_free
    assert np.abs(disk.angle_differences()).mean() < 15
    radius = np.hypot(*disk.plane.T)
    assert np.log(radius[radius > 0].min()) == pytest.approx(-60, rel=0.1)
    assert ism.flatten(v[rows], f.reshape(-1, 3), balance=0).certificate.folding_free


def test_a_listener_sees_the_run_and_can_stop_it():
    v, f, _ = cap(8, 1.5)
    seen = []

    def watch(iterate):
        seen.append(iterate.x.shape[1])
        if len(seen) == 2 and stop:
            raise StopIteration

    for stop in (False, True):
        seen.clear()
        disk = ism.balanced_disk_map(v, f, balance=1, listener=watch)
        assert (disk.status is ism.Status.STOPPED) == stop
    assert disk.plane.shape == (len(v), 2)


@pytest.mark.parametrize(
    ("balance", "error"), [(2, ValueError), (-1, ValueError), ("1", TypeError)]
)
def test_a_balance_is_between_0_and_1(balance, error):
    v, f, _ = cap(2, 1.5)
    for call in (ism.balanced_disk_map, ism.flatten):
        with pytest.raises(error):
            call(v, f, balance=balance)
    with pytest.raises(error):
        ism.disk_conformal_map(v, f).rebalance(balance)


def test_a_double_that_mostly_folds_is_neither_laid_out_nor_embedded_if_its_boundary_has_most_vertices(
    monkeypatch,
):
    """Both would take most of the time on fans, and be lost on them."""
    n, embedded = 300, []
    rng, turn = np.random.default_rng(0), np.linspace(0, 1.5 * np.pi, n)
    r, i = rng.uniform(0.7, 1, n), np.arange(1, n)
    v = np.vstack(
        ([0, 0, 0], np.column_stack((r * np.cos(turn), r * np.sin(turn), 0.1 * rng.normal(size=n))))
    )
    monkeypatch.setattr(
        repair, "repair_locally", lambda *a, **k: embedded.append(a) or repair_locally(*a, **k)
    )
    monkeypatch.setattr(repair, "unroll", lambda *a: embedded.append(a) or unroll(*a))
    disk = ism.disk_conformal_map(v, np.column_stack((0 * i, i, i + 1)))
    assert disk.certificate.folding_free
    assert not embedded


@pytest.mark.parametrize("kind", [FactorisationFailed, ism.FoldingsRemain, ValueError])
def test_what_a_listener_raises_comes_out_as_it_is(kind):
    """Whenever it is raised, with its cause, also an error after which a double of the disk is given up."""
    v, f = ism.samples.make("pear", n_vertices=100)
    calls = []
    ism.balanced_disk_map(v, f[1:], listener=calls.append)
    for count in (*range(6), len(calls) - 1):
        error, cause, seen = kind("mine"), KeyError("why"), iter(range(len(calls)))

        def raise_once(iterate, error=error, cause=cause, seen=seen, count=count):
            if next(seen) == count:
                raise error from cause

        with pytest.raises(kind) as caught:
            ism.balanced_disk_map(v, f[1:], listener=raise_once)
        assert caught.value is error
        assert error.__cause__ is cause


def test_a_long_straight_side_is_noted_and_a_lower_balance_has_none():
    """Areas alone leave one edge of the boundary free to grow."""
    v, f = ism.samples.make("bunny", n_vertices=2000)
    upper = f[v[f, 2].mean(axis=1) > np.median(v[:, 2])]
    conformal = ism.disk_conformal_map(ism.repair_disk(v, upper, keep_largest=True, holes="fill"))
    for balance, straight in ((0.95, False), (1, True)):
        disk = conformal.rebalance(balance)
        ring = disk.plane[disk.rim] @ [1, 1j]
        largest = np.degrees(np.abs(np.angle(np.roll(ring, -1) / ring)).max())
        assert (largest > 30) == straight
        assert [
            f"spans {largest:.0f} degrees of the circle" in note
            for note in disk.notes[len(conformal.notes) :]
        ] == [True] * straight
