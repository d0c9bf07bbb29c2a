"""The programs that `judge` runs: each takes the surfaces of a mesh, and returns positions, with seconds if it knows.

Those that take the time of a process of their own tell it. A row is all that a further program needs.
"""

from __future__ import annotations

import importlib.util
import sys
import tempfile
from functools import partial
from pathlib import Path

import igl
import numpy as np
from disks import cut

import igl_spheremap as ism

from . import disks
from .common import beside, octave
from .peers import lapy, mean_curvature_flow

#: cat-surf under the GPL: a program of its own, which this package neither imports nor brings.
_CAT = """
import sys, time, numpy as np, cat_surf
a = np.load(sys.argv[1]); began = time.process_time()
x = cat_surf.surf_to_sphere(a["v"], a["f"].astype(np.int32), stop_at=6, relax=bool(a["relax"]))[0]
np.savez(sys.argv[2], x=x, seconds=time.process_time() - began)
"""


def cat_surf(v, f, relax):
    """T1Prep's sphere by inflation; `relax`: its distances brought near to those of the surface, as FreeSurfer does."""
    if importlib.util.find_spec("cat_surf") is None:
        raise ImportError("cat-surf is not installed")
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "in.npz", Path(folder) / "out.npz"
        np.savez(source, v=v, f=f, relax=relax)
        beside([sys.executable, "-c", _CAT, source, target])
        with np.load(target) as found:
            return found["x"], float(found["seconds"])


def by_octave(folder, code):
    """A sphere by functions of MATLAB's language; the environment variable names the folder of their code."""
    return lambda v, f: octave(folder, code, v=v, f=f + 1.0)


def matched(v, f, w, g):
    """This package's map between surfaces, as positions."""
    return ism.shapes.match((v, f), (w, g)).positions


def nearest_points(v, f, w, g):
    """The points of the target nearest to the source's, moved and scaled onto it."""
    v, size = v - v.mean(axis=0), np.sqrt(w.var(axis=0).sum() / v.var(axis=0).sum())
    return np.asarray(igl.point_mesh_squared_distance(v * size + w.mean(axis=0), w, g)[2])


def functional(v, f, w, g):
    """A functional map of pyfmaps, refined by ZoomOut, as it ships: vertices onto vertices."""
    from pyFM.functional import FunctionalMapping
    from pyFM.mesh import TriMesh

    model = FunctionalMapping(TriMesh(w, g), TriMesh(v, f))
    model.preprocess()
    model.fit()
    return w[model.get_p2p(model.zoomout_refine(nit=30, step=5))]


def balanced(balance):
    """This package's sphere between conformal and area-preserving."""
    return lambda v, f: ism.balanced_spherical_map(v, f, balance=balance).sphere


#: By what is to be mapped, and by name.
PROGRAMS = {
    "sphere": {
        "igl_spheremap": lambda v, f: ism.spherical_conformal_map(v, f).sphere,
        "igl_spheremap, balance .85": balanced(0.85),
        "igl_spheremap, balance 1": balanced(1.0),
        "LaPy": lapy,
        "LaPy, no refusals": partial(lapy, guarded=False),
        "mean curvature flow": mean_curvature_flow,
        "Choi, Lam, Lui": by_octave("SDEM_FOLDER", "spherical_conformal_map(v, f)"),
        "SDEM": by_octave(
            "SDEM_FOLDER",
            "SDEM(v, f, face_area(f, v), spherical_conformal_map(v, f), 0.1, 1e-3, 200)",
        ),
        "CEM": by_octave("SEM_FOLDER", "Sphere.CEM(f, v)"),
        "SEM": by_octave("SEM_FOLDER", "Sphere.SEM(f, v)"),
        "cat-surf": partial(cat_surf, relax=False),
        "cat-surf, relaxed": partial(cat_surf, relax=True),
    },
    "disk": {
        f"igl_spheremap, {name}" if hasattr(ism, name.partition(",")[0]) else name: call
        for name, call in (
            (name.replace("`", ""), call)
            for name, call in disks.methods().items()
            if call != disks.freesurfer
        )
    },
    "map": {
        "igl_spheremap, match": matched,
        "nearest points": nearest_points,
        "functional maps": functional,
    },
}


#: Those that run in processes of their own: nothing of them is warm.
COLD = ("Choi, Lam, Lui", "SDEM", "CEM", "SEM", "cat-surf", "cat-surf, relaxed")


def small(kind):
    """Surfaces of that kind to warm up on."""
    v, f = ism.samples.make("spheroid", n_vertices=1500)
    return (*cut(v, f, 0, 0.5),) if kind == "disk" else (v, f) if kind == "sphere" else (v, f, v, f)
