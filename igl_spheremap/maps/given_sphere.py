"""Spheres of other programs: certified as results like our own, or repaired, moving as little of them as possible."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from itertools import count

import numpy as np
from numpy.typing import ArrayLike

from ..angles.plan import POOR
from ..descent.energies import HarmonicEnergy
from ..errors import FoldingsRemain, MeshError, Remedy
from ..gate import takes_mesh
from ..mesh.arrays import FloatArray, check_directions
from ..mesh.check import Mesh, check_mesh
from ..result.run import History, Iterate, Listener, Round, Run, Stage, Status
from ..sphere.rows import row_lengths, unit_rows
from ..timings import timed
from ..untangle.local_repair import has_few_foldings, repair_locally
from ..verify.certificate import UNIT_TOLERANCE, Certificate
from ..verify.distortion import mean_angle_difference
from ..verify.signs import folded_faces
from .methods import check_start
from .sphere_map import SphereMap


@takes_mesh
@timed()
def sphere_map(
    v: ArrayLike, f: ArrayLike, x: ArrayLike, *, caps: ArrayLike | None = None
) -> SphereMap:
    """Certify a sphere that another program made, as a `SphereMap`, which other functions take.

    Parameters
    ----------
    v, f : (n, 3) and (m, 3) array_like
        The mesh, as of `check_mesh`.
    x : (n, 3) array_like
        Images of the vertices on a sphere of any radius about the origin, in the same order; rows are scaled to unit
        length, and otherwise left where they are. If they are a mirror image, z is negated, and a note says so.
    caps : (m,) array_like of bool, optional
        As of `check_mesh`.

    Returns
    -------
    SphereMap
        Certified folding-free.

    Raises
    ------
    MeshError
        If the mesh is invalid, or `x` has not one finite, nonzero row per vertex.
    FoldingsRemain
        If the sphere folds; the error's ``result`` is the map with its certificate.

    See Also
    --------
    certify : of arrays.
    repair_foldings : if the map folds.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> x, f = ism.samples.sphere(42)
    >>> ism.sphere_map(x * [1, 2, 3], f, 100 * x).certificate.folding_free
    True
    """
    history = History()
    mesh = check_mesh(v, f, caps=caps)
    y = check_start(x, len(mesh.v), "images")
    y, certificate, notes = _not_mirrored(y, mesh, Certificate.of(y, mesh.f))
    found = _result(mesh, y, certificate, [*_is_itself(mesh, x), *notes])
    return replace(found, run=history.complete(found.run, "given"))


def _not_mirrored(
    x: FloatArray, mesh: Mesh, certificate: Certificate
) -> tuple[FloatArray, Certificate, list[str]]:
    """The map; if it is a homeomorphism that reverses orientation, with z negated, and a note."""
    if certificate.orientation != -1:
        return x, certificate, []
    y = x * [1, 1, -1]
    return y, Certificate.of(y, mesh.f), ["the sphere was a mirror image, not folded: z is negated"]


def _is_itself(mesh: Mesh, x: ArrayLike) -> list[str]:
    """A note where the images are the surface's own vertices, and these do not lie on a sphere, even a rounded one."""
    radii = row_lengths(mesh.v)
    if np.array_equal(x, mesh.v) and np.ptp(radii) > 1e-3 * radii.max():
        return [
            "the images are the surface itself and not a sphere: its vertices were projected from the origin; "
            f"{Remedy('spherical_conformal_map')} maps it"
        ]
    return []


def certified(mesh: Mesh, x: ArrayLike) -> SphereMap:
    """A mesh with given images of its vertices as a `SphereMap`; a FoldingsRemain if it folds."""
    y = check_start(x, len(mesh.v), "images")
    certificate = Certificate.of(y, mesh.f)
    if certificate.orientation == -1:
        raise MeshError(f"the sphere is {certificate}")
    return _result(mesh, y, certificate)


def _result(
    mesh: Mesh, y: FloatArray, certificate: Certificate, notes: Sequence[str] = ()
) -> SphereMap:
    """A map with its certificate as a result; a FoldingsRemain if it folds."""
    run = Run(
        Status.DONE,
        HarmonicEnergy.of(mesh).evaluate(y)[0],
        "given",
        gauge="given",
        notes=tuple(notes),
    )
    result = SphereMap(mesh, y, certificate, run)
    if not certificate.folding_free:
        raise FoldingsRemain(
            f"the sphere is {certificate}; {Remedy('repair_foldings', given='v, f, x')} makes it "
            "a bijection, unless it belongs to another mesh",
            result,
        )
    return result


@takes_mesh
@timed()
def repair_foldings(
    v: ArrayLike,
    f: ArrayLike,
    x: ArrayLike,
    *,
    caps: ArrayLike | None = None,
    listener: Listener | None = None,
) -> SphereMap:
    """Repair every folding of a map to the sphere, made by any program.

    Folded slivers are repaired by small moves; vertices around other foldings are removed and put back so that no face
    folds. Moved vertices are relaxed towards the source's angles. The rest of the map stays where it is, and a map
    without foldings stays bit for bit.

    Parameters
    ----------
    v, f : (n, 3) and (m, 3) array_like
        The mesh, as of `check_mesh`.
    x : (n, 3) array_like
        Images of the vertices: finite, nonzero rows, which are scaled to unit length. A map that turns the
        sphere inside out is reflected first; one of the wrong degree is rebuilt.
    caps : (m,) array_like of bool, optional
        As of `check_mesh`.
    listener : callable, optional
        Called with an `Iterate` before and after, after every round of small moves, and after each batch of vertices
        put back; its residual is the number of foldings. Vertices that are still missing lie on those that they were
        collapsed to.

    Returns
    -------
    SphereMap
        With its certificate; ``rounds`` has the foldings before and after.

    Raises
    ------
    MeshError
        If the mesh is invalid, or `x` has not one finite, nonzero row per vertex.

    See Also
    --------
    certify : finds foldings.
    sphere_map : takes a map as it is.

    Notes
    -----
    A repaired map is as good as the part of the given one that did not fold. If much of it folds, as in most Gauss
    maps, `spherical_conformal_map` makes a better one.

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
    history = History(listener)
    mesh = check_mesh(v, f, caps=caps)
    began, places = time.perf_counter(), count()
    rows = check_directions(x, len(mesh.v), "images")
    y = rows.copy()
    if np.abs(row_lengths(rows) - 1).max() >= UNIT_TOLERANCE:
        y = unit_rows(rows)

    def record(stage: Stage, x: FloatArray) -> None:
        foldings = float(folded_faces(x, mesh.f).sum())
        history(Iterate(stage, 0, next(places), x.copy(), float("nan"), foldings))

    before = Certificate.of(y, mesh.f)
    record(Stage.MAP, y)
    y, _, notes = _not_mirrored(y, mesh, before)
    notes = [*_is_itself(mesh, rows), *notes]
    if before.orientation is None:
        notify = None
        if listener is not None:
            notify = partial(record, Stage.REPAIR)
        y, after = repair_locally(mesh, y, before, notify)
        record(Stage.REPAIRED, y)
    else:
        after = Certificate.of(y, mesh.f)
    energy = HarmonicEnergy.of(mesh).evaluate(y)[0]
    done = Round(
        0,
        "map",
        before.foldings,
        after.foldings,
        0,
        energy,
        mean_angle_difference(mesh, y),
        Status.DONE,
        time.perf_counter() - began,
    )
    if (
        before.orientation is None
        and not has_few_foldings(before, mesh.f)
        and done.mean_angle_difference > POOR
    ):
        better = Remedy("spherical_conformal_map")
        notes = [
            *notes,
            f"{before.foldings:,} of {len(mesh.f):,} faces folded, too many to keep the shape of the map: "
            f"angles are {done.mean_angle_difference:.3g} degrees off on average; {better} makes a map "
            "that keeps them, without this one",
        ]
    run = Run(Status.DONE, energy, rounds=(done,), gauge="given", notes=tuple(notes))
    return SphereMap(mesh, y, after, history.complete(run, "repair"))
