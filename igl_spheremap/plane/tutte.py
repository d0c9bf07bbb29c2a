"""Tutte's map of a disk: the boundary on a circle, every other vertex at the weighted mean of its neighbours."""

from __future__ import annotations

import igl
import numpy as np

from ..errors import FactorisationFailed
from ..mesh.arrays import FloatArray
from ..mesh.disk import Disk
from ..mesh.edges import marked, touching
from ..mesh.measure import face_areas, vertex_shares
from ..operators.factor.factorize import factorize
from ..operators.laplacian import mollified_edge_lengths, summed_laplacian
from ..verify.rim import plane_signs
from .doubling import without_chords


def tutte_map(disk: Disk, circle: FloatArray) -> FloatArray:
    """Images (n, 2) in the unit disk, given those (k, 2) of the boundary; without foldings but for rounding.

    The weights are cotangents. If faces fold, they are made positive: near these faces, then everywhere, then equal.
    Tutte 1963, *How to Draw a Graph*; Floater 2003, *One-to-one Piecewise Linear Mappings over Triangulations*.
    """
    n, f = len(disk.v), disk.f
    p, inner = np.zeros((n, 2)), ~marked(disk.rim, n)
    p[disk.rim] = circle
    weight = igl.cotmatrix_entries(mollified_edge_lengths(disk.unit, f))
    positive = np.clip(weight, 1e-3, 1e3)  # a solve then keeps ten of sixteen digits
    if not inner.any():
        return p
    for attempt in range(4):
        L = summed_laplacian(weight, f, n)
        try:
            p[inner] = factorize(L[inner][:, inner]).solve(-(L[inner][:, ~inner] @ p[~inner]))
        except FactorisationFailed:
            p[inner] = 0
        folded = plane_signs(p, f) <= 0
        if not folded.any():
            break
        near = touching(f, marked(f[folded], n))[:, None]
        weight = (np.where(near, positive, weight), positive, np.full(f.shape, 0.5), weight)[
            attempt
        ]
    return p


def by_lengths(disk: Disk) -> FloatArray:
    """Images (k, 2) of the boundary on the unit circle, which edges divide by their lengths."""
    return _on_circle(_rim_lengths(disk))


def evenly(disk: Disk) -> FloatArray:
    """Images (k, 2) of the boundary on the unit circle, as far apart from each other as they can be."""
    return _on_circle(np.ones(len(disk.rim)))


def by_harmonic_measure(disk: Disk) -> FloatArray:
    """Images (k, 2) of the boundary on the unit circle by a conformal map that sends a point deep inside to the origin.

    That map is exp(-(g + i h)) with Green's function g of the point, zero on the boundary, and its conjugate h, the
    flux of g through the boundary: the harmonic measure. A vertex has the Laplacian's rest there, and divides it
    between its two edges by their lengths.
    """
    v, f = without_chords(disk.unit, disk.f, disk.rim)
    n, length = len(v), _rim_lengths(disk)
    inner = ~marked(disk.rim, n)
    if not inner.any():
        return _on_circle(length)
    L = summed_laplacian(igl.cotmatrix_entries(mollified_edge_lengths(v, f)), f, n)
    factor = factorize(L[inner][:, inner])
    # From the point a random walk takes longest to the boundary.
    time = factor.solve(vertex_shares(face_areas(v, f), f, n)[inner])
    flux = -L[disk.rim][:, inner] @ factor.solve(
        (np.arange(len(time)) == time.argmax()).astype(float)
    )
    flux = np.maximum(flux, 1e-6 * flux.mean())  # in deep dents less than rounding is left of it
    density = flux / (length + np.roll(length, 1))
    return _on_circle(length * (density + np.roll(density, -1)))


def _rim_lengths(disk: Disk) -> FloatArray:
    """Lengths of the boundary edges, none so short that the images of its ends would coincide."""
    ring = disk.unit[disk.rim]
    lengths = np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1)
    return np.maximum(lengths, 1e-3 * lengths.mean())


def _on_circle(parts: FloatArray) -> FloatArray:
    """Points of the unit circle from its start on, with arcs of given proportions between them."""
    turn = 2 * np.pi * (np.cumsum(parts) - parts) / parts.sum()
    return np.column_stack((np.cos(turn), np.sin(turn)))
