"""The repair of a map from any program, moving as little of it as possible."""

from __future__ import annotations

import time
from dataclasses import replace
from itertools import count

import numpy as np
from numpy.typing import ArrayLike

from ..descent.energies.harmonic import HarmonicEnergy
from ..errors import own_errstate
from ..mesh.arrays import FloatArray, check_directions
from ..mesh.check import Mesh
from ..result.run import Iterate, Listener, Round, Status
from ..result.sphere_map import SphereMap
from ..sphere.rows import row_lengths, unit_rows
from ..untangle.candidate import Candidate
from ..untangle.local_repair import repair_locally
from ..untangle.polish import polish_map
from ..verify.certificate import certify_checked
from ..verify.distortion import mean_angle_difference
from ..verify.signs import folded_faces
from .options import Auto, Polish
from .run import run

#: Rows this close to unit length count as unit.
_UNIT = 1e-6


@own_errstate
def repair_foldings(
    v: ArrayLike,
    f: ArrayLike,
    x: ArrayLike,
    *,
    polish: Polish | None = None,
    listener: Listener | None = None,
) -> SphereMap:
    """Repair every folding of a map to the sphere, from whatever program it comes.

    Folded slivers are unfolded by small moves; vertices around other foldings are removed and put back where no face
    folds. What moved is relaxed towards the source's angles. The rest of the map stays where it is, and a map without
    foldings stays bit for bit.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions of the source.
    f : (m, 3) array_like
        Faces as 0-based vertex indices: closed, oriented, connected, genus 0.
    x : (n, 3) array_like
        Images of the vertices: finite, nonzero rows, which are scaled to unit length. A map that turns the
        sphere inside out is reflected first; one of the wrong degree is rebuilt.
    polish : {"angles"}, optional
        What to lower afterwards on the whole map: the angle differences. Nothing by default.
    listener : callable, optional
        Called with an `Iterate` before and after, after every round of small moves, and each time that a batch
        of vertices was put back; its residual is the number of foldings. Vertices that are still missing lie on
        those that they were collapsed to.

    Returns
    -------
    SphereMap
        With its certificate; ``rounds`` has the foldings before and after.

    Raises
    ------
    MeshError
        If the mesh is invalid, or `x` has not one finite, nonzero row per vertex.
    ValueError
        If `polish` is unknown.

    References
    ----------
    Shen, Jiang, Zorin, Panozzo 2019, *Progressive Embedding*.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("spheroid", n_vertices=500)
    >>> x = ism.spherical_conformal_map(v, f).sphere.copy()
    >>> x[[10, 20]] = x[[20, 10]]
    >>> ism.certify(x, f).folding_free, ism.repair_foldings(v, f, x).certificate.folding_free
    (False, True)
    """
    def repair(mesh: Mesh, notify: Listener) -> Candidate:
        began, places = time.perf_counter(), count()
        y = _checked_map(x, mesh)

        def record(stage: str, x: FloatArray) -> None:
            foldings = float(folded_faces(x, mesh.f).sum())
            notify(Iterate(stage, 0, next(places), x.copy(), float("nan"), foldings))

        before = certify_checked(y, mesh.f)
        record("map", y)
        if not before.folding_free:
            y = repair_locally(mesh, y, None if listener is None else lambda part: record("repair", part))
            record("repaired", y)
        if polish is not None:
            y = polish_map(mesh, y)
            record("polished", y)
        after = certify_checked(y, mesh.f)
        energy = HarmonicEnergy.of(mesh).evaluate(y)[0]
        done = Round(0, "map", before.foldings, after.foldings, 0, energy, mean_angle_difference(mesh, y),
                     Status.CONVERGED, time.perf_counter() - began)
        return Candidate(y, energy, Status.CONVERGED, (done,), after, gauge="given")

    result = run(v, f, repair, "repair", Auto(polish=polish).settings(), listener)
    return replace(result, iterations=0)  # of a minimisation there are none


def _checked_map(x: ArrayLike, mesh: Mesh) -> FloatArray:
    """Unit rows of `x`, untouched where they are so already."""
    rows = check_directions(x, len(mesh.v), "images")
    return rows.copy() if np.abs(row_lengths(rows) - 1).max() < _UNIT else unit_rows(rows)
