"""Principal modes of shapes that correspond point by point, and how good a model of the shapes they are."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..mesh.arrays import FloatArray

_RANK = 1e-12  # share of the largest variance that is rounding
_FOLDS = 10  # of cross-validation above _EACH members, which are left out one by one below
_EACH = 100


class Modes(NamedTuple):
    """Principal components of shapes.

    Attributes
    ----------
    modes : (k, n, 3) float64 array
        Displacements of the points, of mean square 1 over the area: a score is a distance, in the shapes' units.
    variances : (k,) float64 array
        Of the scores, the largest first; divided by the number of shapes less 1.
    scores : (members, k) float64 array
        Coordinates of the shapes.
    """

    modes: FloatArray
    variances: FloatArray
    scores: FloatArray


def principal_modes(deviations: FloatArray, weights: FloatArray, count: int) -> Modes:
    """Modes of deviations (members, n, 3) from their mean, by the areas of the points.

    Of a mode's two signs the one is taken for which the cubes of the scores have a positive sum.
    """
    weights = weights / weights.sum()
    rows = (deviations * np.sqrt(weights)[:, None]).reshape(len(deviations), -1)
    values, vectors = np.linalg.eigh(rows @ rows.T)
    values, vectors = values[::-1], vectors[:, ::-1]
    found = min(count, len(rows) - 1, int(np.count_nonzero(values > _RANK * values[0])))
    values, vectors = values[:found], vectors[:, :found]
    vectors = vectors * np.where((vectors**3).sum(axis=0) < 0, -1.0, 1.0)
    modes = np.tensordot(vectors / np.sqrt(values), deviations, (0, 0))
    return Modes(modes, values / max(len(rows) - 1, 1), vectors * np.sqrt(values))


class ModelFigures(NamedTuple):
    """How good a model the first modes are, by their number 1, 2, ...: each (k,) float64.

    Attributes
    ----------
    compactness : (k,) float64 array
        Share of the variance that the modes hold.
    generalisation : (k,) float64 array
        Root mean square distance of a member from the model of the others, in the members' units. Up to 100 members are
        left out one by one, of more a tenth at a time.
    specificity : (k,) float64 array
        Mean distance of random shapes of the model from the member that is nearest to each.

    References
    ----------
    Davies, Twining, Taylor 2008, *Statistical Models of Shape*.
    """

    compactness: FloatArray
    generalisation: FloatArray
    specificity: FloatArray


def model_figures(deviations: FloatArray, weights: FloatArray, count: int, samples: int = 1000) -> ModelFigures:
    """Compactness, generalisation and specificity of models of shapes of 1 ... `count` modes.

    Random shapes have normal scores of a fixed seed.
    """
    whole = principal_modes(deviations, weights, len(deviations))
    scores, share = whole.scores, np.cumsum(whole.variances) / whole.variances.sum()
    folds = np.arange(len(scores)) % (_FOLDS if len(scores) > _EACH else len(scores))
    count = min(count, len(whole.variances), int(np.count_nonzero(folds)) - 1)  # modes of those outside of a fold
    squares = np.zeros((count, len(scores)))
    for fold in range(folds.max() + 1):
        out = folds == fold
        mean = scores[~out].mean(axis=0)
        _, _, axes = np.linalg.svd(scores[~out] - mean, full_matrices=False)
        rest = scores[out] - mean
        inside = np.cumsum((rest @ axes[:count].T) ** 2, axis=1).T
        squares[:, out] = (rest**2).sum(axis=1) - inside
    normal = np.random.default_rng(0).normal(size=(samples, count)) * np.sqrt(whole.variances[:count])
    nearest = np.empty(count)
    total = (scores**2).sum(axis=1)
    for k in range(count):
        drawn = normal[:, : k + 1]
        apart = (drawn**2).sum(axis=1)[:, None] + total - 2 * drawn @ scores[:, : k + 1].T
        nearest[k] = np.sqrt(np.maximum(apart.min(axis=1), 0)).mean()
    return ModelFigures(share[:count], np.sqrt(np.maximum(squares, 0).mean(axis=1)), nearest)
