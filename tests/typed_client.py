"""A client of the public names that type checkers read, and that runs: hints must reach users."""

import numpy as np
from numpy.typing import NDArray

import igl_spheremap as ism
from igl_spheremap.io.records import LoadedMesh
from igl_spheremap.mesh_repair.info import MeshInfo


def watch(iterate: ism.Iterate) -> None:
    """A listener."""
    energy: float = iterate.energy
    positions: NDArray[np.float64] = iterate.x
    assert np.isfinite(energy)
    assert positions.shape[1] == 3


def verdict(certificate: ism.Certificate) -> str:
    """A certificate's fields have their types."""
    foldings: int = certificate.foldings
    proved: bool = certificate.folding_free
    return "folding-free" if proved else f"{foldings} foldings"


def main() -> str:
    """Map, certify, and use the results."""
    v, f = ism.samples.make("spheroid", n_vertices=500)
    method = ism.Lai2014(rounds=0, gradient_tolerance=1e-2)
    result: ism.SphereMap = ism.spherical_conformal_map(v, f, method=method, listener=watch)
    sphere: NDArray[np.float64] = result.sphere
    angles: NDArray[np.float64] = ism.angle_differences(v, f, sphere)
    assert angles.shape == f.shape
    mesh: LoadedMesh = ism.read_mesh("sample:sphere:n_vertices=42")
    ball: ism.SphereMap = ism.spherical_conformal_map(mesh, method="auto", tolerance=1e-2)
    assert ism.angle_differences((mesh.v, mesh.f), ball.sphere).shape == mesh.f.shape
    found: MeshInfo = ism.info(mesh)
    loops: list[tuple[int, ...]] = [part.boundary_loops for part in found.topology.components]
    assert loops == [()]
    assert ism.certify(ball.sphere, ism.check_mesh(v=mesh.v, f=mesh.f))
    return verdict(ism.certify(sphere, f))


if __name__ == "__main__":
    print(main())
