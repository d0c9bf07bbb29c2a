"""How commands end: the shell reads of flags where Python reads of calls, and Ctrl-C is a listener."""

from __future__ import annotations

import pickle
import re
import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.exits import Interrupt, Shell
from igl_spheremap.apps.cli.table import COMMANDS
from igl_spheremap.errors import Remedy, said_by

V, F = ism.samples.sphere(42)
CUBE = """v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"""


def mesh(v, f):
    return "".join(f"v {x} {y} {z}\n" for x, y, z in v) + "".join(
        f"f {i} {j} {k}\n" for i, j, k in f + 1
    )


def torus(n, k):
    """Vertices and faces of a torus."""
    i, j = (a.ravel() for a in np.meshgrid(np.arange(n), np.arange(k), indexing="ij"))
    a, b = 2 * np.pi * i / n, 2 * np.pi * j / k
    v = np.column_stack(((3 + np.cos(b)) * np.cos(a), (3 + np.cos(b)) * np.sin(a), np.sin(b)))
    corner = [(i + di) % n * k + (j + dj) % k for di, dj in ((0, 0), (1, 0), (1, 1), (0, 1))]
    return v, np.vstack((np.column_stack(corner[:3]), np.column_stack([corner[0], *corner[2:]])))


def soup(v, f):
    """Corners of their own, which differ in their last digits."""
    return mesh(
        v[f].reshape(-1, 3) * (1 + 1e-12 * np.arange(f.size)[:, None]),
        np.arange(f.size).reshape(-1, 3),
    )


@pytest.mark.parametrize(
    ("text", "call", "flags"),
    [
        (mesh(V, np.vstack((F, [[3, 3, 4]]))), "repair_mesh(v, f)", ["--repair"]),
        (mesh(np.vstack((V, [[0, 0, 9]])), F), "repair_mesh(v, f)", ["--repair"]),
        (mesh(V, np.vstack((F, F[:1]))), "repair_mesh(v, f)", ["--repair"]),
        (mesh(V, np.vstack((F[:1, ::-1], F[1:]))), "repair_mesh(v, f)", ["--repair"]),
        (
            mesh(np.vstack((V, V + 3)), np.vstack((F, F + len(V)))),
            "repair_mesh(v, f, keep_largest=True)",
            ["--repair", "--keep-largest"],
        ),
        (mesh(V, F[1:]), "repair_mesh(v, f, holes='fill')", ["--repair", "--fill-holes"]),
        (
            mesh(np.vstack((V, V + 3)), np.vstack((F[1:], F + len(V)))),
            "repair_mesh(v, f, keep_largest=True)",
            ["--repair", "--keep-largest"],
        ),
        (
            mesh(np.vstack((V, V + 3)), np.vstack((F[1:], F[2:] + len(V)))),
            "repair_mesh(v, f, keep_largest=True, holes='fill')",
            ["--repair", "--keep-largest", "--fill-holes"],
        ),
        (mesh(*torus(12, 6)), "repair_mesh(v, f, handles='cut')", ["--repair", "--cut-handles"]),
        (soup(V, F), "repair_mesh(v, f, weld=1e-06)", ["--repair", "--weld", "1e-06"]),
        (CUBE, "read_mesh(path, triangulate=True)", ["--repair"]),
    ],
)
def test_what_repairs_a_mesh_is_a_call_in_python_and_a_flag_in_the_shell(
    text, call, flags, tmp_path, capsys
):
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


SHELL = Shell({"--repair": False, "--weld": True, "--cut": True, "--force": False, "--hemi": True})


@pytest.mark.parametrize(
    ("remedy", "in_python", "in_the_shell"),
    [
        (
            Remedy("repair_mesh", {"weld": 1e-6}),
            "repair_mesh(v, f, weld=1e-06)",
            "--repair --weld 1e-06",
        ),
        (Remedy("repair_disk", {"cut": 5}), "repair_disk(v, f, cut=5)", "--cut 5"),
        (
            Remedy("repair_mesh", {"holes": "fill"}),
            "repair_mesh(v, f, holes='fill')",
            "repair_mesh(v, f, holes='fill') in Python",
        ),
        (
            Remedy("repair_foldings", given="v, f, x"),
            "repair_foldings(v, f, x)",
            "the command repair",
        ),
        (Remedy("write_map", given="path, result"), "write_map(path, result)", "the command map"),
        (Remedy(options={"force": True}), "force=True", "--force"),
        (Remedy(options={"hemisphere": None}), "hemisphere", "--hemi"),
        (Remedy(options={"gauge": "centred"}), "gauge='centred'", "gauge='centred' in Python"),
    ],
)
def test_each_front_end_says_a_remedy_in_its_own_words(remedy, in_python, in_the_shell):
    error = ism.MeshError("open; close it", remedy)
    assert str(remedy) == in_python
    assert str(pickle.loads(pickle.dumps(error))) == f"open; close it ({in_python} does)"
    with said_by(SHELL):
        assert str(error) == f"open; close it ({in_the_shell} does)"
    assert str(remedy) == in_python


def test_a_note_of_another_process_is_said_by_the_front_end_that_asked_for_it(tmp_path, capsys):
    """Also where the executor is the caller's, and its threads know nothing of the command line."""
    (tmp_path / "hole.obj").write_text(mesh(V, F[1:]))
    with (
        ThreadPoolExecutor(1) as threads,
        said_by(Shell({"--repair": False, "--fill-holes": False})),
    ):
        (row,) = ism.map_many(
            [tmp_path / "hole.obj"], f"{tmp_path}/{{stem}}.ply", engine=ism.Engine(executor=threads)
        )
    assert "(--repair --fill-holes does)" in row.notes
    (row,) = ism.map_many(
        [tmp_path / "hole.obj"], f"{tmp_path}/{{stem}}.npz", engine=ism.Engine(processes=1)
    )
    assert "(repair_mesh(v, f, holes='fill') does)" in row.notes


BAD = {
    "hole": mesh(V, F[1:]), "holes": mesh(V, np.delete(F, [0, 60], axis=0)), "closed": mesh(V, F), "cube": CUBE,
    "two": mesh(np.vstack((V, V + 3)), np.vstack((F, F + len(V)))), "torus": mesh(*torus(12, 6)), "soup": soup(V, F),
    "torn": soup(V, F[1:]), "flipped": mesh(V, np.vstack((F[:1, ::-1], F[1:]))),
    "handle": mesh(*(lambda v, f: (v, f[1:]))(*torus(12, 6))),
}  # fmt: skip
MORE = {
    "transfer": ["--data", "sphere.npy"],
    "export": ["--show", "octahedral"],
    "view": ["--screenshot", "a.png"],
    "play": ["--screenshot", "a.png"],
}


READERS = [row for row in COMMANDS if any(names == ("source",) for names, _ in row.arguments)]


@pytest.mark.parametrize("command", READERS, ids=lambda row: row.name)
def test_an_error_names_only_flags_of_its_command(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name, text in BAD.items():
        (tmp_path / f"{name}.obj").write_text(text)
    ism.write_mesh("sphere.ply", V, F)
    flags = {name for names, _ in command.arguments for name in names}
    more = MORE.get(command.name, [])
    places = [names[0] for names, _ in command.arguments if not names[0].startswith("-")][1:]
    for name in BAD:
        if name == "closed" and command.name not in ("disk", "flatten"):
            continue
        out = {"export": "a.glb", "transfer": "a.npz", "grid": "a.npz", "harmonics": "a.npz"}.get(
            command.name, "a.obj"
        )
        rest = {
            "sphere": "sphere.ply",
            "target": out,
            "other": f"{name}.obj",
            "other_sphere": "sphere.ply",
        }
        words = [command.name, f"{name}.obj", *(rest[place] for place in places), *more]
        status = main([*words, *(["-f"] if "-f" in flags else [])])
        said = capsys.readouterr()
        assert status == 2 or (
            status == 0 and (name == "hole" or command.name in ("info", "disk", "flatten"))
        )
        own = re.sub(r"`igl-spheremap [^`]+`", "", said.err + said.out)  # other commands, quoted
        assert set(re.findall(r"--[a-z][a-z-]*", own)) <= flags, said.err


def test_a_batch_names_its_own_flags(tmp_path):
    (tmp_path / "hole.obj").write_text(BAD["hole"])
    (tmp_path / "soup.obj").write_text(BAD["soup"])
    words = ["batch", str(tmp_path / "*.obj"), "--out", str(tmp_path / "{stem}.ply"), "--jobs", "1"]
    summary = tmp_path / "all.tsv"
    assert main([*words, "--summary", str(summary), "-q"]) == 2
    assert "(--repair --fill-holes does)" in summary.read_text()
    assert "(--repair --weld 1e-06 does)" in summary.read_text()
    assert main([*words, "--repair", "--fill-holes", "--weld", "1e-06", "-q"]) == 0


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
