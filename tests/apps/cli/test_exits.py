"""How commands end: the shell reads of flags where Python reads of calls, and Ctrl-C is a listener."""

from __future__ import annotations

import threading

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.exits import Interrupt

V, F = ism.samples.sphere(42)
CUBE = """v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"""


def mesh(v, f):
    return "".join(f"v {x} {y} {z}\n" for x, y, z in v) + "".join(f"f {i} {j} {k}\n" for i, j, k in f + 1)


def torus(n, k):
    """Vertices and faces of a torus."""
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(k), indexing="ij"))
    a, b = 2 * np.pi * i / n, 2 * np.pi * j / k
    v = np.column_stack(((3 + np.cos(b)) * np.cos(a), (3 + np.cos(b)) * np.sin(a), np.sin(b)))
    corner = [(i + di) % n * k + (j + dj) % k for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1))]
    return v, np.vstack((np.column_stack(corner[:3]), np.column_stack([corner[0], *corner[2:]])))


@pytest.mark.parametrize(("text", "call", "flags"), [
    (mesh(V, np.vstack((F, [[3, 3, 4]]))), "repair_mesh(v, f)", ["--repair"]),
    (mesh(np.vstack((V, [[0, 0, 9]])), F), "repair_mesh(v, f)", ["--repair"]),
    (mesh(V, np.vstack((F, F[:1]))), "repair_mesh(v, f)", ["--repair"]),
    (mesh(V, np.vstack((F[:1, ::-1], F[1:]))), "repair_mesh(v, f)", ["--repair"]),
    (mesh(np.vstack((V, V + 3)), np.vstack((F, F + len(V)))), "repair_mesh(v, f, keep_largest=True)",
     ["--repair", "--keep-largest"]),
    (mesh(V, F[1:]), "repair_mesh(v, f, holes='fill')", ["--repair", "--fill-holes"]),
    (mesh(np.vstack((V, V + 3)), np.vstack((F[1:], F + len(V)))), "repair_mesh(v, f, keep_largest=True)",
     ["--repair", "--keep-largest"]),
    (mesh(np.vstack((V, V + 3)), np.vstack((F[1:], F[2:] + len(V)))),
     "repair_mesh(v, f, keep_largest=True, holes='fill')", ["--repair", "--keep-largest", "--fill-holes"]),
    (mesh(*torus(12, 6)), "repair_mesh(v, f, handles='cut')", ["--repair", "--cut-handles"]),
    (mesh(V[F].reshape(-1, 3) * (1 + 1e-12 * np.arange(3 * len(F))[:, None]), np.arange(3 * len(F)).reshape(-1, 3)),
     "repair_mesh(v, f, weld=1e-06)", ["--repair", "--weld", "1e-06"]),
    (CUBE, "read_mesh(path, triangulate=True)", ["--repair"]),
])
def test_what_repairs_a_mesh_is_a_call_in_python_and_a_flag_in_the_shell(text, call, flags, tmp_path, capsys):
    path = tmp_path / "mesh.obj"
    path.write_text(text)
    with pytest.raises(ism.MeshError) as caught:
        ism.check_mesh(*ism.read_mesh(path))
    assert call in str(caught.value)
    assert "--" not in str(caught.value)
    assert main(["map", str(path), str(tmp_path / "sphere.obj")]) == 2
    line = capsys.readouterr().err
    assert f"({' '.join(flags)} does)" in line
    assert "(v, f" not in line
    assert main(["info", str(path), *flags]) == 0


def test_a_file_that_is_there_is_replaced_by_an_argument_or_a_flag(tmp_path, capsys):
    path = tmp_path / "mesh.obj"
    ism.write_mesh(path, V, F)
    with pytest.raises(ism.FileError, match=r"; force=True replaces it"):
        ism.write_mesh(path, V, F)
    assert main(["map", "sample:sphere:n_vertices=42", str(path), "-q"]) == 74
    assert "; --force replaces it" in capsys.readouterr().err


def test_interrupts_can_be_listened_to_in_any_thread():
    errors = []

    def enter() -> None:
        try:
            with Interrupt():
                pass
        except ValueError as error:
            errors.append(error)

    thread = threading.Thread(target=enter)
    thread.start()
    thread.join()
    assert errors == []
