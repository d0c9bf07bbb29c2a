"""Names of files, by the data that their formats keep."""

import pytest

EXACT = ("ball.obj", "ball.off", "ball.ply", "ball.npz", "ball.vtk")
ROUNDED = ("ball.glb", "ball.gltf", "ball.surf.gii", "ball.surf.gii.gz", "lh.sphere.conformal")
#: Data by name, and by place.
NAMED = ("data.csv", "data.tsv", "data.ply", "data.vtk")
PLACED = ("data.npy", "data.txt", "data.1D")
ALL = (*EXACT, *ROUNDED, "ball.stl")


def needs(name):
    """Skip the test where the package that reads such a file is missing."""
    for part, module in (
        (".gl", "trimesh"),
        (".gii", "nibabel"),
        ("lh.", "nibabel"),
        ("rh.", "nibabel"),
    ):
        if part in name:
            pytest.importorskip(module)
