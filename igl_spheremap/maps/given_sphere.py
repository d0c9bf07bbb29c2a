"""A sphere of another program, certified as a result like our own."""

from __future__ import annotations

from numpy.typing import ArrayLike

from ..descent.energies.harmonic import HarmonicEnergy
from ..errors import FoldingsRemain, MeshError, own_errstate
from ..mesh.check import Mesh
from ..result.run import Listener, Status
from ..result.sphere_map import SphereMap
from ..untangle.candidate import Candidate
from ..verify.certificate import certify_checked
from .run import check_start, run


@own_errstate
def sphere_map(v: ArrayLike, f: ArrayLike, x: ArrayLike) -> SphereMap:
    """Certify a sphere that another program made, for all that takes a `SphereMap`.

    Parameters
    ----------
    v : (n, 3) array_like
        Vertex positions of the source.
    f : (m, 3) array_like
        Faces as 0-based vertex indices: closed, oriented, connected, genus 0.
    x : (n, 3) array_like
        Images of the vertices on a sphere of any radius about the origin, in the same order; rows are scaled to unit
        length, and otherwise left where they are.

    Returns
    -------
    SphereMap
        Certified folding-free.

    Raises
    ------
    MeshError
        If the mesh is invalid, `x` has not one finite, nonzero row per vertex, or it is a reflection.
    FoldingsRemain
        If the sphere folds; the error's ``result`` is the map with its certificate.

    Examples
    --------
    >>> import igl_spheremap as ism
    >>> x, f = ism.samples.sphere(42)
    >>> ism.sphere_map(x * [1, 2, 3], f, 100 * x).certificate.folding_free
    True
    """
    def certified(mesh: Mesh, notify: Listener) -> Candidate:
        y = check_start(x, len(mesh.v), "images")
        certificate = certify_checked(y, mesh.f)
        if len(certificate.flipped) == len(mesh.f):
            raise MeshError("the sphere is a reflection: all faces are flipped; negate one of its coordinates, "
                            "or reverse the faces of a mesh that is inside out")
        energy = HarmonicEnergy.of(mesh).evaluate(y)[0]
        return Candidate(y, energy, Status.CONVERGED, certificate=certificate, gauge="given")

    result = run(v, f, certified, "given", {})
    if not result.certificate.folding_free:
        raise FoldingsRemain(f"the sphere is {result.certificate}; repair_foldings makes it a bijection, "
                             "unless it belongs to another mesh", result)
    return result
