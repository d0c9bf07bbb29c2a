"""`disk`, `flatten` and `check` of their maps."""

import json
import re
import subprocess
import sys

import numpy as np
import pytest
from disks import half
from drawing import needs_drawing
from shell import one_line
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.exits import Exit
from igl_spheremap.io.patch import Patch, read_patch, write_patch
from igl_spheremap.io.records import Label
from igl_spheremap.io.scalars import write_scalars

V, F = icosphere(3)
W, G, ROWS = half(V, F)


@pytest.fixture
def face(tmp_path):
    ism.write_mesh(tmp_path / "face.ply", W, G)
    return str(tmp_path / "face.ply")


@pytest.mark.parametrize("command", ["disk", "flatten"])
@pytest.mark.parametrize("name", ["a.obj", "a.npz", "a.ply"])
def test_a_map_is_written_and_checked(face, tmp_path, command, name, capsys):
    out, figures = str(tmp_path / name), tmp_path / "figures.json"
    assert main([command, face, out, "--json", str(figures)]) == Exit.OK
    assert "boundary crosses itself nowhere" in " ".join(capsys.readouterr().out.split())
    numbers = json.loads(figures.read_text())
    assert numbers["certificate"]["folding_free"]
    assert numbers["rim"] == len(ism.check_disk(W, G).rim)
    own = [out] if name.endswith((".obj", ".npz")) else [face, out]
    assert main(["check", *own, "-q"]) == Exit.OK


def test_the_image_goes_to_no_stream_and_a_closed_surface_to_the_command_map(tmp_path, capsys):
    assert main(["flatten", "sample:sphere", "-"]) == 64
    assert "not stdout" in capsys.readouterr().err
    assert main(["flatten", "sample:sphere", str(tmp_path / "a.obj")]) == 2
    assert "map it to the sphere (the command map does)" in capsys.readouterr().err


def test_patches_go_in_and_out(tmp_path):
    whole, cut, flat = (
        str(tmp_path / name) for name in ("lh.ply", "lh.half.patch.3d", "lh.half.patch.flat")
    )
    ism.write_mesh(whole, V, F)
    write_patch(cut, Patch(ROWS, W, np.zeros(len(W), dtype=bool)))
    assert main(["flatten", whole, flat, "--patch", cut, "-q"]) == Exit.OK
    assert main(["check", whole, flat, "-q"]) == Exit.OK
    patch = read_patch(flat)
    assert (patch.rows == ROWS).all()
    folded = patch.positions.copy()
    folded[0, :2] += 10
    write_patch(flat, Patch(patch.rows, folded, patch.border), force=True)
    assert main(["check", whole, flat, "-q"]) == Exit.UNCERTIFIED


def test_what_is_welded_is_reported(tmp_path, capsys):
    soup = str(tmp_path / "soup.stl")
    ism.write_mesh(soup, W, G)
    assert main(["flatten", soup, str(tmp_path / "a.obj"), "-q"]) == Exit.OK
    ism.write_mesh(tmp_path / "loose.ply", np.vstack((W, [[9, 9, 9]])), G)
    assert (
        main(["flatten", str(tmp_path / "loose.ply"), str(tmp_path / "b.obj"), "-q"])
        == Exit.NO_MESH
    )
    capsys.readouterr()
    assert (
        main(["flatten", str(tmp_path / "loose.ply"), str(tmp_path / "b.obj"), "-q", "--repair"])
        == Exit.OK
    )
    assert "unreferenced" in capsys.readouterr().err


def test_a_closed_mesh_is_refused_in_one_line(tmp_path, capsys):
    assert main(["disk", "sample:spheroid:n_vertices=500", str(tmp_path / "a.obj")]) == Exit.NO_MESH
    assert "closed surface" in one_line(capsys)


def test_other_maps_of_a_face_fail(face, tmp_path):
    ism.write_mesh(tmp_path / "folded.ply", W * [1, 1, 0], G[:, ::-1])
    # seen from above it is one
    assert main(["check", face, str(tmp_path / "folded.ply"), "-q"]) == Exit.OK
    ism.write_mesh(tmp_path / "mirrored.ply", W * [-1, 1, 0], G)
    assert main(["check", face, str(tmp_path / "mirrored.ply"), "-q"]) == Exit.UNCERTIFIED
    assert main(["check", face, face, "-q"]) == Exit.NO_MESH


def test_a_closed_surface_is_cut_and_holes_but_one_are_filled(tmp_path, capsys):
    closed, out = str(tmp_path / "ball.ply"), str(tmp_path / "a.obj")
    ism.write_mesh(closed, V, F)
    for cut in ("3", "0,5,9", str(tmp_path / "tips.vts")):
        (tmp_path / "tips.vts").write_text("0\n5\n9\n")
        assert main(["flatten", closed, out, "--cut", cut, "-q", "-f"]) == Exit.OK
        assert main(["check", out, "-q"]) == Exit.OK
        assert len(ism.read_mesh(out).v) == len(V)
    ism.write_mesh(tmp_path / "torn.ply", W, np.delete(G, 60, axis=0))
    torn = str(tmp_path / "torn.ply")
    assert main(["disk", torn, out, "-f"]) == Exit.NO_MESH
    assert "(--repair --fill-holes does)" in capsys.readouterr().err
    hole = ",".join(map(str, W[G[60, 0]]))
    for rim, length in (
        ([], len(ism.check_disk(W, G).rim)),
        ([f"--rim={hole}"], 3),
        (["--rim", str(G[60, 0])], 3),
    ):
        figures = tmp_path / "figures.json"
        assert (
            main(
                ["disk", torn, out, "-f", "--repair", "--fill-holes", *rim, "--json", str(figures)]
            )
            == Exit.OK
        )
        assert json.loads(figures.read_text())["rim"] == length
        assert main(["check", out, "-q"]) == Exit.OK
    capsys.readouterr()
    for words, status in (
        (["--fill-holes"], Exit.NO_MESH),
        (["--rim", "3"], Exit.USAGE),
        (["--cut-handles", "--repair"], Exit.USAGE),
        (["--cut", "99999,1"], Exit.USAGE),
    ):
        assert main(["flatten", closed, out, "-f", *words]) == status
        one_line(capsys)


def test_what_float32_folds_is_said_with_the_formats_that_do_not(tmp_path, capsys):
    pytest.importorskip("trimesh")
    pytest.importorskip("PIL")
    ism.write_mesh(tmp_path / "thin.obj", W * [1, 1e-9, 0], G)
    thin = str(tmp_path / "thin.obj")
    assert main(["flatten", thin, str(tmp_path / "a.npz"), "-q"]) == Exit.OK
    assert main(["flatten", thin, str(tmp_path / "a.glb")]) == Exit.UNCERTIFIED
    assert "write .obj or .npz, which keep every digit" in " ".join(capsys.readouterr().out.split())


def test_a_plot_is_drawn(face, tmp_path):
    pytest.importorskip("matplotlib")
    plot = tmp_path / "a.png"
    assert main(["flatten", face, str(tmp_path / "a.obj"), "--plot", str(plot), "-q"]) == Exit.OK
    assert plot.read_bytes().startswith(b"\x89PNG")
    assert main(["flatten", face, str(tmp_path / "b.obj"), "--plot", "a.txt", "-q"]) == Exit.USAGE


@needs_drawing
def test_a_flat_map_is_shown_beside_its_surface(face, tmp_path):
    flat, picture = str(tmp_path / "a.obj"), tmp_path / "a.png"
    assert main(["flatten", face, flat, "-q"]) == Exit.OK
    view = [sys.executable, "-m", "igl_spheremap", "view", flat, "--screenshot", str(picture)]
    shown = subprocess.run(view, timeout=300, capture_output=True, text=True)
    assert shown.returncode == Exit.OK
    assert re.search(rf"^screenshot\s+{re.escape(str(picture))}$", shown.stdout, re.MULTILINE)
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_the_cuts_of_a_template_come_over_a_registration(tmp_path, capsys):
    """Here the surface lies on its own sphere, and is coarser than the template: at places the cut is a slit."""
    x, f = icosphere(3)
    y, g = icosphere(5)
    surface, reg, template, patch = (
        str(tmp_path / name) for name in ("lh.ply", "lh.sphere.ply", "mine.ply", "mine.patch.3d")
    )
    ism.write_mesh(surface, x * [1, 1.4, 0.8], f)
    ism.write_mesh(reg, 100 * x, f)
    ism.write_mesh(template, y, g)
    rows = np.flatnonzero((y[:, 2] > -0.7) & ~((np.abs(y[:, 1]) < 0.02) & (y[:, 0] > 0)))
    write_patch(patch, Patch(rows, y[rows], np.zeros(len(rows), dtype=bool)))
    via = ["--patch", patch, "--via", reg, "--template", template]
    flat, rest = str(tmp_path / "flat.obj"), str(tmp_path / "lh.mine.patch.flat")
    for out in (flat, rest):
        assert main(["flatten", surface, out, *via]) == Exit.OK
        assert re.search(r"left out \d+ faces, [\d.]+% of the area, near", capsys.readouterr().err)
    labels = tmp_path / "lh.areas.label.gii"
    table = tuple(Label(key, name, (1, 1, 1, 1)) for key, name in enumerate(("rest", "wall")))
    write_scalars(labels, {"areas": (x[:, 2] < -0.7) * 1.0}, metadata={"labels": table})
    assert main(["flatten", surface, flat, *via, "--labels", str(labels), "-f"]) == Exit.OK
    assert re.search(r"left out [^;]*: 8\d% wall, 1\d% rest", capsys.readouterr().err)
    few = str(tmp_path / "few.npy")
    np.save(few, np.zeros(3))
    assert main(["flatten", surface, flat, *via, "--labels", few, "-f"]) == Exit.NO_MESH
    assert "few.npy holds no labels" in one_line(capsys)
    assert main(["check", flat, "-q"]) == Exit.OK
    assert main(["check", surface, rest, "-q"]) == Exit.OK
    assert len(read_patch(rest).rows) < len(np.unique(ism.read_mesh(flat).f)) < len(x)

    capsys.readouterr()
    for words, message in (
        ([*via, "--cut", "4"], "leave one of them out"),
        (["--patch", patch, "--via", template, "--template", template], "give a map of this mesh"),
        (
            ["--patch", patch, "--via", reg, "--template", "ico:1"],
            "the surface that it was cut from",
        ),
        (["--patch", patch, "--template", template], "--via"),
    ):
        assert main(["flatten", surface, str(tmp_path / "no.obj"), *words]) != Exit.OK
        assert message in one_line(capsys)
