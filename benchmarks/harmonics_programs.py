"""FlowShape and aics-shparam in Pythons of their own, as they need numpy and libigl of other versions.

Called by `harmonics.py` as ``PYTHON harmonics_programs.py NAME IN.npz OUT.npz``.
"""

import sys

import numpy as np


def flowshape(v, f, degree):
    """FlowShape's sphere by 20 steps of mean curvature flow, and the surface by its fit of the positions."""
    import flowshape as fs

    x = fs.mobius_center(v, fs.conformal_flow(v, f), f)
    weights, basis = fs.IRF_vector(v, x, f, max_degree=int(degree) + 1)
    return {"x": x, "v": basis @ weights, "f": f}


def aics(image, degree):
    """aics-shparam's surface from a solid image, in voxels along x, y, z: a radius for each direction."""
    from aicsshparam import shparam, shtools
    from vtk.util.numpy_support import vtk_to_numpy

    (_, grid), (_, _, _, centroid) = shparam.get_shcoeffs(image, int(degree), alignment_2d=False)
    surface = shtools.get_even_reconstruction_from_grid(grid, npoints=4000, centroid=centroid)
    faces = vtk_to_numpy(surface.GetPolys().GetData()).reshape(-1, 4)[:, 1:]
    return {"v": vtk_to_numpy(surface.GetPoints().GetData()), "f": faces}


if __name__ == "__main__":
    name, source, target = sys.argv[1:]
    with np.load(source) as data:
        np.savez(target, **globals()[name](**data))
