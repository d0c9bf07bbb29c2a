import numpy as np
from scipy.spatial.transform import Rotation

from igl_spheremap.shapes.groups.procrustes import fitted, generalised_procrustes

RNG = np.random.default_rng(0)
SHAPE = RNG.normal(size=(50, 3)) * [3, 2, 1]
WEIGHTS = RNG.uniform(1, 2, 50)


def moved(scales):
    """The shape turned, moved and scaled."""
    turns = Rotation.random(len(scales), random_state=1).as_matrix()
    return np.stack(
        [
            scale * SHAPE @ turn + RNG.normal(size=3)
            for scale, turn in zip(scales, turns, strict=True)
        ]
    )


def test_similar_shapes_fall_on_each_other():
    shapes = moved([1.0, 2.0, 4.0])
    found = generalised_procrustes(shapes, WEIGHTS)
    assert np.abs(found.shapes - found.mean).max() < 1e-9
    assert np.allclose(found.sizes, [0.5, 1, 2])


def test_rigid_motions_keep_the_sizes():
    shapes = moved([1.0, 2.0, 3.0])
    aligned = generalised_procrustes(shapes, WEIGHTS, rigid=True).shapes
    lengths = np.linalg.norm(aligned[:, 0] - aligned[:, 1], axis=1)
    assert np.allclose(lengths / lengths[0], [1, 2, 3])


def test_the_mean_lies_where_shapes_lie_that_are_in_one_place():
    shapes = SHAPE + 0.01 * RNG.normal(size=(8, 50, 3)) + [10, 20, 30]
    found = generalised_procrustes(shapes, WEIGHTS)
    assert np.abs(found.mean - shapes.mean(axis=0)).max() < 0.01


def test_a_shape_is_laid_on_a_mean_that_stays():
    shape, size = fitted(moved([3.0])[0], SHAPE, WEIGHTS)
    assert np.allclose(shape, SHAPE)
    assert np.isclose(size, 3)
