"""A map in a scene of the caller's own: two structures of polyscope with quantities, and nothing else is touched."""

import sys

from drawing import run

CODE = """
import numpy as np, polyscope as ps, igl_spheremap as ism
ps.set_verbosity(0)
ps.init("openGL_mock")
ps.set_up_dir("neg_y_up")
v, f = ism.samples.make("dino", n_vertices=1200)
ps.register_surface_mesh("mine", v, f).add_scalar_quantity("x", v[:, 0])
result, start = ism.spherical_conformal_map(v, f), ism.gauss_map(v, f)
folded = ism.certify(start, f).flipped
surface, sphere = ism.add_to_polyscope(result, "dino", x=start)
assert ps.has_surface_mesh("mine") and ps.has_surface_mesh("dino")
assert ps.get_surface_mesh("dino on the sphere").n_faces() == len(f) == surface.n_faces()
for one in (surface, sphere):
    values = one.get_quantity_buffer("angle difference", "values")
    assert values.size() == len(f)
    buffer = one.get_quantity_buffer("foldings", "colors")
    colours = np.array([buffer.get_value(k).as_tuple() for k in range(len(f))])
    rare = np.unique(colours.round(4), axis=0, return_inverse=True)[1].reshape(-1)
    assert {*np.flatnonzero(rare == rare[folded[0]])} == {*folded}
    assert one.get_quantity_buffer("checkerboard", "coords").size() == 3 * len(f)
at = sphere.get_transform()  # up is -y, front z: right is -x
centre = at[:3, 3]
assert centre[0] + at[0, 0] < v[:, 0].min()
again, _ = ism.add_to_polyscope(result, "dino")
assert again.get_name() == "dino"
print("done")
"""


AGAIN = """
import polyscope as ps, igl_spheremap as ism
ps.set_verbosity(0)
ps.init("openGL_mock")
result = ism.spherical_conformal_map(*ism.samples.make("sphere", n_vertices=100))
held = []
for k in range(400):
    held.extend(ism.add_to_polyscope(result, f"map {min(k, 30)}"))
print("done")
"""


def test_maps_replace_each_other_while_their_structures_are_held():
    """Polyscope's objects then lie where others were, whose handles are still there."""
    done = run([sys.executable, "-c", AGAIN])
    assert done.stdout == "done\n", done.stderr


def test_a_map_joins_a_scene():
    done = run([sys.executable, "-c", CODE])
    assert done.stdout == "done\n", done.stderr


ALONE = """
from igl_spheremap.errors import DisplayError
import igl_spheremap as ism
result = ism.spherical_conformal_map(*ism.samples.make("sphere", n_vertices=100))
try:
    ism.add_to_polyscope(result)
except DisplayError as error:
    print(error)
"""


def test_a_scene_must_be_there():
    assert run([sys.executable, "-c", ALONE]).stdout.endswith("call polyscope.init() first\n")
