import numpy as np
import pytest
from family import body, spiral

import igl_spheremap as ism
from igl_spheremap.mesh.measure import enclosed_volume, surface_area


def frames(bends):
    """A body that bends, on a mesh of its own in each frame, and the place of each vertex in the body at rest."""
    rng = np.random.default_rng(0)
    for k, bend in enumerate(bends):
        x, f = spiral(300 + 5 * k, rng)
        yield (body(x, bend) + np.array([0.2 * k, 0, 0]), f), body(x)


@pytest.fixture(scope="module")
def bending(here):
    """Four frames."""
    meshes, places = zip(*frames([0.0, 0.4, 0.8, 1.2]), strict=True)
    return meshes, ism.shapes.series(meshes, features=places, target="ico:2", engine=here)


def test_points_keep_their_place_in_the_body(bending):
    _, found = bending
    size = np.sqrt(((found.features[0] - found.features[0].mean(axis=0)) ** 2).sum(axis=1).mean())
    apart = np.linalg.norm(found.features - found.features[0], axis=2)
    assert np.sqrt((apart[1] ** 2).mean()) < 0.05 * size
    assert np.sqrt((apart[-1] ** 2).mean()) < 0.1 * size
    assert np.sqrt((found.drift**2).mean()) < 0.1 * size
    assert not found.notes


def test_areas_and_volumes_are_those_of_the_frames(bending):
    meshes, found = bending
    assert np.allclose(found.areas.sum(axis=1), [surface_area(*mesh) for mesh in meshes])
    assert np.allclose(found.surface_areas, found.areas.sum(axis=1))
    assert np.allclose(found.volumes, [enclosed_volume(*mesh) for mesh in meshes])
    assert all(each.certificate.folding_free for each in found.maps)
    assert np.allclose(found.vertices.mean(axis=1)[:, 0], [0, 0.2, 0.4, 0.6], atol=0.1)


def test_one_frame_makes_no_series():
    with pytest.raises(ism.MeshError, match="two or more"):
        ism.shapes.series([ism.samples.sphere(42)])
    with pytest.raises(ValueError, match="features are of 1 surfaces"):
        ism.shapes.series([ism.samples.sphere(42)] * 2, features=[[0.0]])


def test_an_inside_out_member_is_named_and_repaired():
    v, f = ism.samples.make("pear", n_vertices=100)
    with pytest.raises(
        ism.MeshError, match=r"surface 1: inside out: .* \(repair_mesh\(v, f\) does\)"
    ):
        ism.shapes.series([(v, f), (v, f[:, ::-1])], target="ico:2")
    mended = ism.repair_mesh(v, f[:, ::-1])
    assert ism.shapes.series([(v, f), mended], target="ico:2").drift.max() < 1e-9
    group = ism.shapes.template(
        [(v * [1 + 0.1 * k, 1, 1], f) for k in range(3)] + [(v, f[:, ::-1])], target="ico:2"
    )
    assert list(group.left_out) == ["3"]
    with pytest.raises(ism.MeshError, match="inside out"):
        group.place(ism.balanced_spherical_map(v, f[:, ::-1], balance=1))


@pytest.mark.parametrize(
    ("call", "option", "value"),
    [
        (ism.shapes.series, "target", 3),
        (ism.shapes.series, "features", 3.0),
        (ism.shapes.series, "sources", 3),
        (ism.shapes.template, "target", 3),
        (ism.shapes.template, "features", 3.0),
        (ism.shapes.template, "sources", 3),
    ],
)
def test_an_argument_that_is_none_is_named(call, option, value):
    v, f = ism.samples.make("pear", n_vertices=100)
    with pytest.raises((TypeError, ValueError), match=f"^{option} is {value}"):
        call(**{"sources": [(v, f)] * 3, "target": "ico:2", option: value})


def test_frames_may_come_one_by_one():
    v, f = ism.samples.make("pear", n_vertices=100)
    assert (
        len(ism.shapes.series(((v * (1 + k), f) for k in range(2)), target="ico:2").vertices) == 2
    )


def test_a_series_goes_on_where_it_ended_and_gives_the_same_bits(bending, here, tmp_path):
    meshes, found = bending
    for _ in range(2):
        again = ism.shapes.series(meshes, target="ico:2", engine=here, out=tmp_path)
        assert (again.vertices == found.vertices).all()
        assert (again.drift == found.drift).all()
        (tmp_path / "work" / "pairs" / "1.npz").unlink()
        manifest = tmp_path / "manifest.jsonl"
        lines = manifest.read_bytes().splitlines(keepends=True)
        manifest.write_bytes(b"".join(lines[: len(lines) // 2]))


def test_a_frame_that_can_not_be_mapped_is_named(here):
    v, f = ism.samples.sphere(42)
    with pytest.raises(ism.MeshError, match="surface 1: open surface"):
        ism.shapes.series(
            [(v * [1, 1, 2], f), (v, f[1:]), (v * [1, 1, 2], f)], target="ico:1", engine=here
        )
