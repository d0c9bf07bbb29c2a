"""`igl-spheremap map`, `p-harmonic` and `landmarks`: written maps are certified, flags are the options of records."""

from __future__ import annotations

import dataclasses
import json
import signal
from dataclasses import fields
from typing import get_args, get_type_hints

import numpy as np
import pytest
from shell import SAMPLE, one_line

import igl_spheremap as ism
from igl_spheremap import balanced_spherical_map, samples
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.commands import map as map_command
from igl_spheremap.apps.cli.parser import build_parser
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.float32 import Float32Map
from igl_spheremap.io.write_mesh import write_mesh
from igl_spheremap.io.written_map import read_map
from igl_spheremap.maps.options import METHODS, Auto
from igl_spheremap.verify.certificate import certify


def test_map_writes_certifies_and_reports(tmp_path, capsys):
    target, figures = tmp_path / "map.npz", tmp_path / "figures.json"
    assert main(["map", SAMPLE, str(target), "--json", str(figures)]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert "folding-free" in out
    assert "certified as written" in out
    result, written = read_map(target), json.loads(figures.read_text())
    assert written["vertices"] == len(result.vertices)
    assert written["energy"] == result.energy
    assert written["certificate"]["folding_free"] is True
    assert written["angle_differences"]["mean"] == pytest.approx(
        np.abs(result.angle_differences()).mean()
    )


def test_options_reach_the_method(tmp_path):
    target = tmp_path / "a.npz"
    main(
        [
            "map",
            SAMPLE,
            str(target),
            "-q",
            "--method",
            "lai2014",
            "--max-iterations",
            "2",
            "--gradient-tolerance",
            "1e-9",
        ]
    )
    result = read_map(target)
    assert (result.method, result.settings) == (
        "lai2014",
        {"max_iterations": 2, "gradient_tolerance": 1e-9},
    )


def test_max_iterations_count_anew_in_each_round(tmp_path, capsys):
    words = [
        "map",
        "sample:dino:n_vertices=1500",
        str(tmp_path / "a.npz"),
        "--method",
        "lai2014",
        "-q",
    ]
    main([*words, "--max-iterations", "100", "--json", str(tmp_path / "a.json")])
    rounds = [
        each["iterations"] for each in json.loads((tmp_path / "a.json").read_text())["rounds"]
    ]
    assert len(rounds) > 1
    assert rounds[0] == 100 < sum(rounds)
    assert max(rounds) == 100
    assert main(["map", "--help"]) == 0
    assert "of each minimisation, so of each round" in " ".join(capsys.readouterr().out.split())


def test_weights_reach_the_method(tmp_path, capsys):
    words = [
        "map",
        "sample:spheroid:n_vertices=500",
        str(tmp_path / "a.npz"),
        "--edge-weights",
        "cotangent",
    ]
    assert main([*words, "--method", "lai2014", "--json", str(tmp_path / "a.json")]) == 0
    assert json.loads((tmp_path / "a.json").read_text())["settings"] == {
        "edge_weights": "cotangent"
    }
    capsys.readouterr()
    assert main([*words, "-f"]) == 64
    assert capsys.readouterr().err == "igl-spheremap: --method auto takes no --edge-weights\n"


def test_a_run_as_printed_that_ends_with_foldings_is_written_and_named_so(tmp_path, capsys):
    words = [
        "map",
        "sample:bird:n_vertices=880",
        str(tmp_path / "a.npz"),
        "--method",
        "lai2014",
        "--as-printed",
    ]
    assert main([*words, "--max-iterations", "100", "--json", str(tmp_path / "a.json")]) == 3
    assert "not folding-free" in capsys.readouterr().out
    figures, result = json.loads((tmp_path / "a.json").read_text()), read_map(tmp_path / "a.npz")
    assert figures["certificate"]["flipped"]["count"] == len(result.certificate.flipped) > 0
    assert (figures["gauge"], figures["status"]) == ("free", "MAX_ITERATIONS")
    assert ism.Lai2014(**result.settings) == ism.Lai2014.as_printed(max_iterations=100)


def test_what_safeguards_did_is_printed_and_kept(tmp_path, capsys):
    words = ["map", "sample:dino:n_vertices=1500", str(tmp_path / "a.npz"), "--method", "lai2014"]
    assert main([*words, "--max-iterations", "300"]) == 0
    result = read_map(tmp_path / "a.npz")
    refused = sum((step.safeguards or {}).get("refused", 0) for step in result.history)
    assert f"{refused:,} steps that would fold were refused" in result.notes
    assert f"{refused:,} steps that would fold were refused" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--as-printed"], "--as-printed goes with --method lai2014"),
        (
            ["--method", "lai2014", "--gauge", "poles"],
            "unknown gauge 'poles': choose 'centred' or 'free'",
        ),
        (["--metric", "areas"], "--method auto takes no --metric"),
        (["--as-programmed"], "--as-programmed goes with --method lai2014"),
    ],
)
def test_flags_of_the_papers_method_are_refused_elsewhere(tmp_path, capsys, words, message):
    assert main(["map", SAMPLE, str(tmp_path / "a.obj"), *words]) == 64
    assert message in one_line(capsys)


def test_foldings_that_remain_are_status_3_and_still_written(tmp_path, capsys, monkeypatch):
    def folded(*arguments, **options):
        result = balanced_spherical_map(*arguments, **options)
        x = result.sphere.copy()
        x[[10, 20]] = x[[20, 10]]
        return dataclasses.replace(result, sphere=x, certificate=certify(x, result.faces))

    monkeypatch.setattr(map_command, "balanced_spherical_map", folded)
    assert main(["map", SAMPLE, str(tmp_path / "a.obj")]) == 3
    assert "not folding-free" in capsys.readouterr().out
    assert main(["check", SAMPLE, str(tmp_path / "a.obj")]) == 3


def test_a_rounded_file_is_status_3_and_names_what_would_do(tmp_path, capsys, monkeypatch):
    pytest.importorskip("nibabel")

    def crowded(*arguments, **options):
        result = balanced_spherical_map(*arguments, **options)
        x, (i, j, _) = result.sphere.copy(), result.faces[0]
        x[j] = x[i] + 1e-9 * (x[j] - x[i])
        return dataclasses.replace(result, sphere=x)

    monkeypatch.setattr(map_command, "balanced_spherical_map", crowded)
    assert main(["map", SAMPLE, str(tmp_path / "rh.sphere.conformal")]) == 0
    assert "moved to keep float32 from folding" in " ".join(capsys.readouterr().out.split())

    def plainly(x, f, radius):
        return Float32Map(
            (radius * x).astype(np.float32), certify(x, f), np.empty(0, dtype=np.int64)
        )

    monkeypatch.setattr("igl_spheremap.io.written_map.certified_float32", plainly)
    assert main(["map", SAMPLE, str(tmp_path / "lh.sphere.conformal")]) == 3
    assert "rounded to this format" in " ".join(capsys.readouterr().out.split())


def test_freesurfer_from_end_to_end(tmp_path):
    freesurfer = pytest.importorskip("nibabel.freesurfer")
    v, f = samples.make("brain", n_vertices=4000)
    freesurfer.write_geometry(tmp_path / "lh.pial", v, f)
    assert (
        main(["map", str(tmp_path / "lh.pial"), str(tmp_path / "lh.sphere.conformal"), "-q"]) == 0
    )
    x, g = freesurfer.read_geometry(tmp_path / "lh.sphere.conformal")
    assert np.allclose(np.linalg.norm(x, axis=1), 100)
    assert np.array_equal(g, f)
    assert (
        main(["check", str(tmp_path / "lh.pial"), str(tmp_path / "lh.sphere.conformal"), "-q"]) == 0
    )


def test_gifti_keeps_what_the_source_said(tmp_path):
    nibabel = pytest.importorskip("nibabel")
    write_mesh(
        tmp_path / "in.surf.gii", *samples.sphere(162), metadata={"structure": "CortexRight"}
    )
    assert (
        main(
            [
                "map",
                str(tmp_path / "in.surf.gii"),
                str(tmp_path / "out.surf.gii"),
                "--radius",
                "2",
                "-q",
            ]
        )
        == 0
    )
    points = nibabel.load(tmp_path / "out.surf.gii").darrays[0]
    assert dict(points.meta) == {
        "AnatomicalStructurePrimary": "CortexRight",
        "GeometricType": "Spherical",
    }
    assert np.allclose(np.linalg.norm(points.data, axis=1), 2)


def test_nothing_is_overwritten_without_force(sphere, capsys):
    before = sphere.read_bytes()
    assert main(["map", "sample:sphere:n_vertices=42", str(sphere)]) == 74
    assert "exists already" in one_line(capsys)
    assert sphere.read_bytes() == before
    assert main(["map", "sample:sphere:n_vertices=42", str(sphere), "--force", "-q"]) == 0
    assert sphere.read_bytes() != before


def test_ctrl_c_stops_at_the_next_iterate_and_keeps_it(tmp_path, monkeypatch):
    def pressed(*arguments, listener, **options):
        signal.raise_signal(signal.SIGINT)
        return balanced_spherical_map(*arguments, listener=listener, **options)

    monkeypatch.setattr(map_command, "balanced_spherical_map", pressed)
    before = signal.getsignal(signal.SIGINT)
    assert main(["map", SAMPLE, str(tmp_path / "a.npz"), "--method", "lai2014", "-q"]) == 130
    assert signal.getsignal(signal.SIGINT) is before
    result = read_map(tmp_path / "a.npz")
    assert result.status.name == "STOPPED"
    assert len(result.history) <= 1


def test_force_replaces_no_file_by_an_interrupted_map_that_folds(
    sphere, tmp_path, monkeypatch, capsys
):
    def pressed(v, f, balance, *, listener, **options):
        signal.raise_signal(signal.SIGINT)
        good = ism.sphere_map(v, f, ism.gauss_map(v, f))
        run = dataclasses.replace(good.run, status=ism.Status.STOPPED)
        return dataclasses.replace(good, sphere=folded, certificate=certify(folded, f), run=run)

    v, f = read_mesh(SAMPLE)
    folded = ism.gauss_map(v, f)
    folded[:5] *= -1
    monkeypatch.setattr(map_command, "balanced_spherical_map", pressed)
    before = sphere.read_bytes()
    assert main(["map", SAMPLE, str(sphere), "--force"]) == 130
    out, err = capsys.readouterr()
    assert (out, sphere.read_bytes()) == ("", before)
    assert err.count("\n") == 1
    assert "foldings; " in err
    assert "sphere.obj is kept as it was" in err
    assert main(["map", SAMPLE, str(tmp_path / "new.obj"), "-q"]) == 130
    assert main(["check", SAMPLE, str(tmp_path / "new.obj"), "-q"]) == 3


def test_polish_and_gauge_reach_the_method(tmp_path, capsys):
    figures = {}
    for name, flags in (("plain", []), ("polished", ["--polish", "angles"])):
        out = tmp_path / f"{name}.json"
        target = str(tmp_path / f"{name}.npz")
        assert main(["map", "sample:bird:n_vertices=1200", target, "--json", str(out), *flags]) == 0
        figures[name] = json.loads(out.read_text())
    assert figures["polished"]["settings"] == {"polish": "angles"}
    assert (
        figures["polished"]["angle_differences"]["mean"]
        < figures["plain"]["angle_differences"]["mean"]
    )
    capsys.readouterr()
    spring = ["map", "sample:spring:n_vertices=2500,turns=5", str(tmp_path / "s.npz"), "-f"]
    assert main(spring) == 0
    assert "times shorter" not in capsys.readouterr().out
    assert main([*spring, "--gauge", "centred"]) == 0
    assert "times shorter" in capsys.readouterr().out
    assert (
        main(
            [
                "map",
                "sample:bird",
                str(tmp_path / "b.npz"),
                "--polish",
                "angles",
                "--method",
                "lai2014",
            ]
        )
        == 64
    )
    assert "--polish" in capsys.readouterr().err


def test_balance_reaches_the_map_and_its_figures(tmp_path):
    target, figures = tmp_path / "map.npz", tmp_path / "figures.json"
    assert main(["map", SAMPLE, str(target), "--balance", "1", "--json", str(figures)]) == 0
    assert read_map(target).balance == 1
    assert json.loads(figures.read_text())["log_area_ratios"]["mean"] < 0.05
    assert main(["check", SAMPLE, str(target), "--json", str(figures)]) == 0
    assert json.loads(figures.read_text())["log_area_ratios"]["mean"] < 0.05


def test_a_balance_outside_is_refused(tmp_path, capsys):
    assert main(["map", SAMPLE, str(tmp_path / "map.npz"), "--balance", "1.5"]) != 0
    assert "give a number from 0 to 1" in one_line(capsys)


def flags():
    """Flags of `map` by the name of the option that they set."""
    commands = next(action for action in build_parser()._actions if action.dest == "command")
    return {action.dest: action for action in commands.choices["map"]._actions}


def test_methods_are_those_of_the_records_and_the_default_is_the_front_doors():
    assert tuple(flags()["method"].choices) == tuple(METHODS)
    assert flags()["method"].default == Auto.name


def test_flags_have_the_names_choices_and_defaults_of_options():
    options = {option.name for method in METHODS.values() for option in fields(method)}
    found = {name: flag for name, flag in flags().items() if name in options}
    assert set(found) == {
        "tolerance",
        "gradient_tolerance",
        "max_iterations",
        "gauge",
        "polish",
        "edge_weights",
        "metric",
    }
    for name, flag in found.items():
        assert flag.option_strings == ["--" + name.replace("_", "-")]
        assert flag.default is None  # the record's own default holds
        hints = [
            get_type_hints(method)[name]
            for method in METHODS.values()
            if name in get_type_hints(method)
        ]
        hint = hints[0]
        if flag.choices is not None:
            parts = [part for each in hints for part in (each, *get_args(each))]
            assert set(flag.choices) - {"none"} <= {
                choice for part in parts for choice in get_args(part) or [part]
            }
            assert ("none" in flag.choices) == (name == "polish" and type(None) in get_args(hint))
        elif hint is not bool:
            assert type(flag.type("1")) is hint


def test_timings_are_figures(tmp_path):
    words = ["map", "sample:spheroid", str(tmp_path / "a.obj"), "--json", str(tmp_path / "a.json")]
    assert main(words) == 0
    figures = json.loads((tmp_path / "a.json").read_text())
    assert 0 < sum(figures["timings"].values()) <= figures["seconds"]


def test_a_surface_is_written_with_its_sphere_beside_it(tmp_path):
    path = str(tmp_path / "both.ply")
    assert main(["map", "sample:spheroid:n_vertices=300", path, "--with-surface", "-q"]) == 0
    assert main(["check", "sample:spheroid:n_vertices=300", path, "-q"]) == 0
    assert np.array_equal(read_mesh(path).v, ism.samples.make("spheroid", n_vertices=300)[0])


def test_holes_are_filled_on_request_and_their_caps_are_no_figure(tmp_path, capsys):
    v, f = samples.sphere(642)
    f = f[v[f].mean(axis=1)[:, 2] < 0.7]
    used, f = np.unique(f, return_inverse=True)
    source, target, figures = (
        tmp_path / "bowl.obj",
        tmp_path / "sphere.ply",
        tmp_path / "figures.json",
    )
    write_mesh(source, v[used], f.reshape(-1, 3))
    flags = ["--repair", "--fill-holes", "--json", str(figures)]
    assert main(["map", str(source), str(target)]) == 2
    assert "; close the holes (--repair --fill-holes does)" in one_line(capsys)
    assert main(["map", str(source), str(target), *flags]) == 0
    out, err = capsys.readouterr()
    assert "filled 1 hole" in err
    caps = len(read_mesh(target).f) - len(f.reshape(-1, 3))
    assert f"{caps} of its" in out
    made = json.loads(figures.read_text())
    assert made["certificate"]["caps"] == caps > 0
    assert main(["check", str(source), str(target), *flags]) == 0
    checked = json.loads(figures.read_text())
    assert checked["certificate"]["caps"] == caps
    assert checked["angle_differences"] == pytest.approx(made["angle_differences"], abs=1e-3)
    assert main(["map", str(source), str(tmp_path / "map.npz"), "-q", *flags]) == 0
    assert main(["check", str(tmp_path / "map.npz"), "--json", str(figures)]) == 0
    assert json.loads(figures.read_text())["certificate"]["caps"] == caps
    assert main(["map", str(source), str(target), "-f", "--fill-holes"]) == 0
    assert "repaired" in capsys.readouterr().err  # which the flag implies
