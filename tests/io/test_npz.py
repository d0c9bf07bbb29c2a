"""Archives: maps and records of any depth come back, what holds none is named, arrays of any dtype are checked."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap import (
    FileError,
    MeshError,
    Status,
    balanced_spherical_map,
    landmark_map,
    samples,
    spherical_conformal_map,
)
from igl_spheremap.io.files import read_mesh, read_sphere
from igl_spheremap.io.written_map import certify_radius, read_map, write_map


def same(a, b):
    """Equal in every field, type and bit; NaN equals NaN."""
    if isinstance(a, np.ndarray):
        return (
            isinstance(b, np.ndarray)
            and a.dtype == b.dtype
            and np.array_equal(a, b, equal_nan=a.dtype.kind == "f")
        )
    if type(a) is not type(b):
        return False
    if dataclasses.is_dataclass(a):
        fields = (field.name for field in dataclasses.fields(a) if field.compare)  # all but timings
        return all(same(getattr(a, name), getattr(b, name)) for name in fields)
    if isinstance(a, tuple | list):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(a[key], b[key]) for key in a)
    return a == b or (a != a and b != b)


@pytest.mark.parametrize(
    "make",
    [
        spherical_conformal_map,
        lambda v, f: spherical_conformal_map(v, f, method="lai2014"),
        lambda v, f: spherical_conformal_map(v, f, gauge="centred"),
        lambda v, f: balanced_spherical_map(v, f, balance=0.5),
        lambda v, f: landmark_map(v, f, [0], [[0, 0.6, 0.8]]),
    ],
    ids=["auto", "lai2014", "centred", "balanced", "landmarks"],
)
def test_every_field_of_a_map_comes_back(make, tmp_path):
    result = make(*samples.make("spheroid", n_vertices=300))
    write_map(tmp_path / "map.npz", result)
    back = read_map(tmp_path / "map.npz")
    assert result.timings
    assert not back.timings
    assert same(result, back)


def test_fields_that_differ_from_their_defaults_come_back(result, tmp_path):
    settings = {"polish": "angles", "rounds": np.int64(2)}
    run = dataclasses.replace(
        result.run,
        gauge="poles",
        stretch=np.float64(3.25),
        notes=("one", "two"),
        settings=settings,
        status=Status.STALLED,
    )
    write_map(tmp_path / "map.npz", dataclasses.replace(result, run=run))
    back = read_map(tmp_path / "map.npz").run
    assert (back.gauge, back.stretch, back.notes, back.status) == (
        "poles",
        3.25,
        ("one", "two"),
        Status.STALLED,
    )
    assert back.settings == settings


def test_source_and_sphere_are_found_in_a_map(result, tmp_path):
    write_map(tmp_path / "map.npz", result)
    assert np.array_equal(read_mesh(tmp_path / "map.npz").v, result.vertices)
    assert np.array_equal(read_sphere(tmp_path / "map.npz").v, result.sphere)


def test_the_certificate_is_that_of_the_numbers_in_the_file(result, tmp_path):
    """Whatever the archive says of them."""
    write_map(tmp_path / "map.npz", dataclasses.replace(result, sphere=-result.sphere))
    assert not read_map(tmp_path / "map.npz").certificate.folding_free


def test_archives_that_hold_no_map(tmp_path):
    np.savez(tmp_path / "other.npz", a=np.arange(3))
    with pytest.raises(MeshError, match="no map"):
        read_map(tmp_path / "other.npz")
    with pytest.raises(MeshError, match="'vertices' and 'faces' but: a"):
        read_mesh(tmp_path / "other.npz")
    with pytest.raises(FileError, match="No such file"):
        read_map(tmp_path / "none.npz")


@pytest.mark.parametrize("dtype", ["<f8", ">f8", "<f4", ">f4", "<f2", "g"])
def test_arrays_of_any_real_dtype_become_float64_before_they_are_judged(dtype, result, tmp_path):
    """In float16, rows that are off the sphere by 1.5e-4 would pass a test of 1e-6."""
    stored = (result.sphere * (1 + 1.5e-4)).astype(dtype)
    np.savez(tmp_path / "a.npz", vertices=stored, sphere=stored, faces=result.faces.astype(">i4"))
    x, f = read_sphere(tmp_path / "a.npz")
    assert x.dtype == np.float64
    assert x.dtype.isnative
    assert f.dtype == np.int64
    assert np.array_equal(x, stored.astype(np.float64))
    assert np.array_equal(f, result.faces)
    off = (
        np.abs(np.linalg.norm(stored.astype(np.float64), axis=1) / certify_radius(x, f).radius - 1)
        > 1e-6
    )
    assert len(certify_radius(x, f).off_sphere) == off.sum()
    assert off.any() == (np.dtype(dtype).itemsize == 2)


@pytest.mark.parametrize("name", ["vertices", "sphere", "faces"])
@pytest.mark.parametrize(
    "spoil",
    [
        lambda a: a.astype(complex),
        lambda a: a.astype(str),
        lambda a: a.astype("S9"),
        lambda a: a[0, 0],
        lambda a: a[:, 0],
        lambda a: a[None],
        lambda a: a[:, :2],
        lambda a: a.astype("datetime64[s]"),
        lambda a: a + 0.5 if a.dtype.kind == "i" else a.astype("U3"),
        lambda a: np.zeros(len(a), dtype=[("x", "f8")]),
    ],
)
def test_arrays_that_hold_no_rows_of_numbers_are_named(name, spoil, result, tmp_path):
    write_map(tmp_path / "map.npz", result)
    with np.load(tmp_path / "map.npz") as archive:
        arrays = dict(archive)
    arrays[name] = spoil(
        arrays[name].astype(np.int64) if name == "faces" else np.round(arrays[name], 3)
    )
    np.savez(tmp_path / "bad.npz", **arrays)
    for reader in (read_map, read_sphere if name == "sphere" else read_mesh):
        with pytest.raises(MeshError, match=r"dtype|shape|whole|rows"):
            reader(tmp_path / "bad.npz")


def forged(tmp_path, result, **changes):
    """A file of a map, with other arrays."""
    write_map(tmp_path / "map.npz", result)
    with np.load(tmp_path / "map.npz") as archive:
        arrays = dict(archive) | changes
    np.savez(tmp_path / "map.npz", **arrays)
    return tmp_path / "map.npz"


def test_the_conformal_map_of_a_balanced_one_is_certified_on_its_own_numbers(tmp_path):
    """Whatever the file says of it: it comes back from rebalance."""
    balanced = balanced_spherical_map(*samples.make("spheroid", n_vertices=300), balance=0.5)
    folded = (
        np.where(np.arange(len(balanced.vertices)) < 5, -1, 1)[:, None] * balanced.conformal.sphere
    )
    back = read_map(forged(tmp_path, balanced, conformal=folded))
    assert back.certificate.folding_free
    assert not back.conformal.certificate.folding_free
    assert not back.rebalance(0).certificate.folding_free


@pytest.mark.parametrize("name", ["sphere", "conformal"])
def test_spheres_of_other_shapes_are_refused(name, tmp_path):
    balanced = balanced_spherical_map(*samples.make("spheroid", n_vertices=300), balance=0.5)
    with pytest.raises(MeshError, match=f"{name} .* rows|{name} has shape"):
        read_map(forged(tmp_path, balanced, **{name: balanced.sphere[:-1]}))


def test_texts_of_a_map_put_no_line_into_another_file(result, tmp_path, capsys):
    run = dataclasses.replace(
        result.run,
        method="auto\nv 0 0 0",
        notes=("one\ntwo\x1b[31m",),
        gauge="a\u202eb",
        settings={"a\rb": "\x00"},
    )
    write_map(tmp_path / "map.npz", dataclasses.replace(result, run=run))
    back = read_map(tmp_path / "map.npz")
    assert (back.run.method, back.run.notes, back.run.gauge) == (
        "auto\\nv 0 0 0",
        ("one\\ntwo\\x1b[31m",),
        "a\\u202eb",
    )
    assert back.run.settings == {"a\\rb": "\\x00"}
    for source in (back, dataclasses.replace(result, run=run)):  # of a file, and of a caller
        write_map(tmp_path / "map.obj", source, force=True)
        mark, *lines = (tmp_path / "map.obj").read_text().splitlines()
        assert mark.startswith("# igl_spheremap ")
        assert len(lines) == len(result.vertices) + len(result.faces)


def test_an_archive_without_the_record_of_its_run_is_refused_and_its_surfaces_are_read(tmp_path):
    v, f = ism.samples.sphere(42)
    path = tmp_path / "old.npz"
    np.savez(
        path, vertices=2 * v, faces=f, sphere=v, json=json.dumps({"energy": 12.6, "sphere": None})
    )
    with pytest.raises(
        MeshError, match="does not say how its map was made; its surfaces can be read"
    ):
        read_map(path)
    assert ism.sphere_map(*read_mesh(path), read_sphere(path).v).certificate.folding_free


def test_archives_by_the_names_of_the_readme_are_meshes(ball, tmp_path):
    v, f = ball
    np.savez(tmp_path / "ball.npz", v=v, f=f.astype("u4"))
    mesh = read_mesh(tmp_path / "ball.npz")
    assert np.array_equal(mesh.v, v)
    assert np.array_equal(mesh.f, f)


OTHER_KINDS = (None, True, 7, -1.5, "a\x1b[2J", [1], {"a": 1}, 10**400)


def outcome(path):
    """A map from a file is refused in one line, or written again."""
    try:
        back = read_map(path)
    except MeshError as error:
        return str(error)
    write_map(path, back, force=True)
    return " ".join((repr(back), back.explain(), *map(str, back.rounds)))


def test_records_of_other_kinds_are_refused_or_do_no_harm(tmp_path):
    """In every place of the record of a run, of its rounds and of its history."""
    path = tmp_path / "map.npz"
    write_map(path, balanced_spherical_map(*samples.make("pear", n_vertices=100), balance=1))
    with np.load(path) as archive:
        known = {name: archive[name] for name in archive.files}
    runs = json.loads(str(known["json"]))
    run = runs["sphere"]
    run["rounds"] = [
        {"round": 0, "start": "map", "foldings_before": 3, "foldings_after": 0, "iterations": 0,
         "energy": 1.0, "mean_angle_difference": 2.0, "status": "DONE", "seconds": 0.1}
    ]  # fmt: skip
    run["notes"] = ["one"]
    said = []
    for holder in (run, run["rounds"][0], run["notes"], run["history"][-1]):
        for name in list(holder) if isinstance(holder, dict) else range(len(holder)):
            before = holder[name]
            for value in OTHER_KINDS:
                holder[name] = value
                np.savez(path, **known | {"json": json.dumps(runs)})
                said.append(outcome(path).replace("\n", " "))
            holder[name] = before
    assert all(text.isprintable() for text in said)
    assert sum("damaged" in text for text in said) > len(said) / 2
