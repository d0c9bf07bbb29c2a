"""The octahedral grid: a sphere of its own, and images of positions that become meshes again."""

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.sphere.rows import unit_rows


def sphere(k):
    """The grid's own points as an image."""
    x, f = ism.samples.sphere(12)
    points = ism.shapes.to_grid(ism.sphere_map(x, f, x), x, kind="octahedral", rows=k)
    return unit_rows(points.reshape(-1, 3)).reshape(k, k, 3)


@pytest.mark.parametrize("k", [3, 5, 9, 33])
def test_the_grids_points_are_a_subdivided_octahedron(k):
    v, f = ism.shapes.mesh_from_grid(sphere(k))
    m = k // 2
    assert (len(v), len(f)) == (4 * m**2 + 2, 8 * m**2)
    assert ism.certify(v, f).folding_free
    assert {(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)} <= set(
        map(tuple, v.round(12) + 0.0)
    )


def test_an_image_of_positions_comes_back_as_the_mesh_that_it_is():
    """From mesh to image to mesh: positions and faces are the same, to rounding, for the mesh lies on the grid."""
    v, f = ism.shapes.mesh_from_grid(sphere(17))
    surface = v * [1, 2, 3] + 0.1 * np.sin(3 * v)
    again, faces = ism.shapes.mesh_from_grid(
        ism.shapes.to_grid(ism.sphere_map(surface, f, v), kind="octahedral", rows=17)
    )
    assert np.abs(again - surface).max() < 1e-12
    assert np.array_equal(faces, f)


def test_values_are_read_off_the_grid_at_second_order_and_exactly_at_its_points():
    where = unit_rows(np.random.default_rng(0).normal(size=(500, 3)))
    errors = []
    for k in (33, 65, 129):
        x = sphere(k)
        image = np.exp(x[..., 0] - x[..., 2])
        errors.append(
            np.abs(
                ism.shapes.from_grid(image, where, kind="octahedral")
                - np.exp(where[:, 0] - where[:, 2])
            ).max()
        )
        back = ism.shapes.from_grid(image, x.reshape(-1, 3), kind="octahedral")
        assert np.abs(back - image.ravel()).max() < 1e-12
    assert np.log2(errors[0] / errors[2]) > 2 * 1.8


@pytest.mark.parametrize(
    ("shape", "words"),
    [
        ((4, 4, 3), "4 rows and 4 columns"),
        ((5, 7, 3), "5 rows and 7 columns"),
        ((1, 1, 3), "1 rows"),
        ((5, 5), "rows x"),
    ],
)
def test_other_grids_are_refused(shape, words):
    with pytest.raises(ism.MeshError, match=words):
        ism.shapes.mesh_from_grid(np.zeros(shape))


def test_a_command_makes_the_mesh(tmp_path, capsys):
    image, out = tmp_path / "image.npz", tmp_path / "a.ply"
    x, f = ism.samples.sphere(162)
    ism.write_mesh(tmp_path / "x.ply", x, f)
    words = [
        "grid",
        str(tmp_path / "x.ply"),
        str(tmp_path / "x.ply"),
        str(image),
        "--kind",
        "octahedral",
    ]
    assert main([*words, "--rows", "9"]) == 0
    assert main(["mesh", str(image), str(out)]) == 0
    assert "66 vertices, 128 faces" in capsys.readouterr().out
    assert len(ism.read_mesh(out).v) == 66
    assert main([*words, "--rows", "8", "-f"]) == 2
    assert main(["mesh", str(tmp_path / "x.ply"), str(out), "-f"]) == 64
    assert "IMAGE is" in capsys.readouterr().err
