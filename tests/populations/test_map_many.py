"""Many files: each has its row, finished work is not repeated, and nothing gets onto the wrong subject."""

import os
from concurrent.futures import BrokenExecutor, Future, ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap.errors import WorkersUnavailable
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.write_mesh import write_mesh
from igl_spheremap.io.written_map import read_mark
from igl_spheremap.populations.engine import Engine
from igl_spheremap.populations.map_many import manifest_of, map_many, targets_of
from igl_spheremap.populations.table import plain
from igl_spheremap.sphere.moebius import moebius

SOURCES = ["400.ply", "open.ply", "100.ply", "missing.ply", ".", "300.ply", "200.ply"]
STATUSES = ["certified", "no mesh", "certified", "file", "file", "certified", "certified"]


@pytest.fixture
def threads():
    with ThreadPoolExecutor(2) as executor:
        yield executor


@pytest.fixture
def run(desk, threads):
    """Runs over sources, by threads of this process."""

    def call(
        sources=("300.ply",), out="{stem}_out.ply", *, resume=True, retry_failed=False, **options
    ):
        engine = Engine(executor=threads, resume=resume, retry_failed=retry_failed)
        return map_many(sources, out, engine=engine, **options)

    return call


def figures(row):
    """The part that does not depend on the run; as for JSON, since NaN is not equal to itself."""
    return plain(replace(row, resumed=False, seconds=0, memory=0, worker=""))


def test_rows_are_those_of_single_maps(run):
    """They take no steps on good maps, by default, so that all members are treated alike."""
    rows = run(SOURCES, "{stem}_out.obj")
    assert [row.source for row in rows] == SOURCES
    assert [row.status for row in rows] == STATUSES
    for row in rows:
        if row.status == "certified":
            result = ism.spherical_conformal_map(*read_mesh(row.source), polish=None)
            size = np.abs(result.angle_differences()).ravel()
            assert np.array_equal(read_mesh(row.target).v, result.sphere)
            assert (row.energy, row.mean_angle, row.max_angle) == (
                result.energy,
                size.mean(),
                size.max(),
            )
            assert row.p99_angle == np.percentile(size, 99)
            assert row.max_area == np.abs(result.log_area_ratios()).max()
            edges = np.abs(ism.log_length_ratios(result.vertices, result.faces, result.sphere))
            assert row.max_edge == edges.max()


def test_a_method_by_its_name_takes_no_steps_on_good_maps(run):
    """Maps are those of single calls with the same polish."""
    maps = [
        read_mesh(run(out=f"{{stem}}_{k}.obj", **options)[0].target).v
        for k, options in enumerate(({}, {"method": "auto"}, {"method": ism.Auto(polish="angles")}))
    ]
    plain, polished = (
        ism.spherical_conformal_map(*read_mesh("300.ply"), polish=each).sphere
        for each in (None, "angles")
    )
    assert not np.array_equal(plain, polished)
    for found, expected in zip(maps, (plain, plain, polished), strict=True):
        assert np.array_equal(found, expected)


@pytest.mark.posix
def test_a_pipe_costs_its_row_only(run):
    os.mkfifo("pipe.ply")
    assert [row.status for row in run(["pipe.ply", "300.ply"])] == ["file", "certified"]


def test_another_run_maps_nothing_and_reports_the_same(run):
    first = run(SOURCES)
    times = {
        row.target: os.stat(row.target).st_mtime_ns for row in first if row.status == "certified"
    }
    second = run(SOURCES)
    assert [figures(row) for row in second] == [figures(row) for row in first]
    assert [row.resumed for row in second] == [status != "file" for status in STATUSES]
    assert times == {target: os.stat(target).st_mtime_ns for target in times}
    assert not any(row.resumed for row in run(SOURCES, resume=False))


def test_no_order_of_the_inputs_shifts_results(run):
    first = {row.source: figures(row) for row in run(SOURCES)}
    assert len({row["energy"] for row in first.values() if row["status"] == "certified"}) == 4
    for sources in (SOURCES[::-1], SOURCES[2:], sorted(SOURCES)):
        rows = run(sources)
        assert [row.source for row in rows] == sources
        assert all(figures(row) == first[row.source] for row in rows if row.status != "file")


def test_files_that_changed_places_are_mapped_anew(run):
    before = {row.source: figures(row) for row in run(["300.ply", "400.ply"])}
    os.rename("300.ply", "x")
    os.rename("400.ply", "300.ply")
    os.rename("x", "400.ply")
    # what is there is ours, of another mesh
    after = {row.source: row for row in run(["300.ply", "400.ply"])}
    assert after["300.ply"].energy == before["400.ply"]["energy"]
    assert after["400.ply"].energy == before["300.ply"]["energy"]


def test_a_folder_that_moved_keeps_its_results(run, desk, monkeypatch):
    run(["300.ply"])
    os.rename(desk, moved := desk.with_name("elsewhere"))
    monkeypatch.chdir(moved)
    assert run(["300.ply"])[0].resumed


def test_results_of_other_options_or_versions_do_not_count(run, monkeypatch):
    assert run()[0].status == "certified"
    assert run(method=ism.Lai2014())[0].status == "file"
    assert run(balance=1)[0].status == "file"
    assert run()[0].resumed
    # nothing else changes a version
    monkeypatch.setattr("igl_spheremap.io.written_map.__version__", "0.0.0")
    monkeypatch.setattr(
        "igl_spheremap.populations.mapping.SphereMapping.__repr__", lambda self: "0.0.0"
    )
    assert run()[0].status == "file"


def test_failures_are_run_again_only_where_asked(run, monkeypatch):
    def broken(*_, **__):
        raise MemoryError

    with monkeypatch.context() as patch:
        patch.setattr("igl_spheremap.populations.mapping.read_mesh", broken)
        assert run()[0].notes.startswith("out of memory")
    assert (run()[0].status, run()[0].resumed) == ("failed", True)
    assert run(retry_failed=True)[0].status == "certified"


def test_a_file_that_was_repaired_is_mapped(run):
    assert run(["open.ply"])[0].status == "no mesh"
    write_mesh("open.ply", *ism.samples.sphere(42), force=True)
    assert run(["open.ply"])[0].status == "certified"


def test_a_target_that_was_changed_is_made_again(run):
    run()
    made = Path("300_out.ply").read_bytes()
    x, f = read_mesh("300_out.ply")
    write_mesh("300_out.ply", -x, f, force=True, metadata={"mark": read_mark("300_out.ply")})
    assert (run()[0].status, run()[0].resumed) == ("certified", True)
    assert Path("300_out.ply").read_bytes() == made


def test_an_input_that_changed_is_mapped_again_and_replaces_what_an_earlier_run_made(run):
    write_mesh("body.ply", *ism.samples.make("spheroid", n_vertices=300))
    assert run(["body.ply"])[0].status == "certified"
    made = Path("body_out.ply").read_bytes()
    write_mesh("body.ply", *ism.samples.sphere(42), force=True)
    (row,) = run(["body.ply"])
    assert (row.status, row.resumed, row.vertices) == ("certified", False, 42)
    Path("body_out.ply").write_bytes(made)  # an earlier run's, too, if not the last one's
    write_mesh("body.ply", *ism.samples.sphere(162), force=True)
    assert run(["body.ply"])[0].vertices == 162
    write_mesh("body_out.ply", *ism.samples.sphere(42), force=True)  # of somebody else
    write_mesh("body.ply", *ism.samples.sphere(42), force=True)
    assert "without the mark" in run(["body.ply"])[0].notes


def shift(x):
    """A Moebius map: certified, but not this package's."""
    return moebius(x, [0.4, 0.1, 0])


def fold(x):
    return x * np.where(np.arange(len(x)) < 5, -1, 1)[:, None]


@pytest.mark.parametrize("change", [shift, fold])
def test_what_others_made_is_neither_taken_for_a_result_nor_lost(change, run):
    """As FreeSurfer's own lh.sphere at the name that the pattern gives."""
    v, f = read_mesh("300.ply")
    write_mesh("300_out.ply", change(ism.spherical_conformal_map(v, f).sphere), f)
    before = Path("300_out.ply").read_bytes()
    (row,) = run()
    assert row.status == "file"
    assert "without the mark" in row.notes
    assert Path("300_out.ply").read_bytes() == before
    assert run(force=True)[0].status == "certified"
    assert Path("300_out.ply").read_bytes() != before


@pytest.mark.parametrize("content", [b"", b"notes", b"ply\n"])
def test_files_that_hold_no_mesh_are_left_as_they_are(content, run):
    Path("300_out.ply").write_bytes(content)
    assert run()[0].status == "file"
    assert Path("300_out.ply").read_bytes() == content
    Path("300_out.ply").unlink()
    assert run()[0].status == "certified"


def test_one_folder_that_takes_no_file_stops_no_other(run):
    for folder in ("a", "b"):
        os.mkdir(folder)
        write_mesh(f"{folder}/lh.ply", *ism.samples.sphere(42))
    Path("a/spheres").touch()
    rows = run(["a/lh.ply", "b/lh.ply"], "{folder}/spheres/{stem}.obj")
    assert [row.status for row in rows] == ["file", "certified"]
    assert "can't make the folder a/spheres" in rows[0].notes


def test_threads_give_equal_bits(desk):
    v, f = read_mesh("400.ply")
    alone = ism.spherical_conformal_map(v, f).sphere
    with ThreadPoolExecutor(4) as executor:
        maps = executor.map(lambda _: ism.spherical_conformal_map(v, f).sphere, range(12))
        assert all(np.array_equal(x, alone) for x in maps)


class Counting(ThreadPoolExecutor):
    """Counts the jobs in flight, and breaks on some of them this many times."""

    def __init__(self, **breaks):
        super().__init__(2)
        self.most = self.calls = self.flying = 0
        self.breaks = breaks

    def submit(self, call, job, options):
        self.flying += 1
        self.calls += 1
        self.most = max(self.most, self.flying)
        name = job.source.removesuffix(".ply")
        if self.breaks.get(f"of_{name}", 0) > 0:
            self.breaks[f"of_{name}"] -= 1
            call = broken
        future = super().submit(call, job, options)
        future.add_done_callback(lambda _: setattr(self, "flying", self.flying - 1))
        return future


def broken(*_):
    raise BrokenExecutor("gone")


def test_a_run_is_written_down_before_its_first_job(desk):
    class Reader(ThreadPoolExecutor):
        def submit(self, call, job, options):
            found.append(
                [
                    line.partition('"')[2].partition('"')[0]
                    for line in manifest.read_text().splitlines()
                ]
            )
            return super().submit(call, job, options)

    found, manifest = [], Path("maps.manifest.jsonl")
    with Reader(1) as executor:
        map_many(["100.ply", "200.ply"], "{stem}.obj", engine=Engine(executor=executor))
    assert found[0] == ["igl_spheremap run"]


class Swapped(ThreadPoolExecutor):
    """Replaces an input when its job is submitted, after it was listed, or while it is read."""

    def submit(self, call, job, options):
        return super().submit(self.swap, call, job, options)

    def swap(self, call, job, options):
        os.replace("400.ply", job.source)
        return call(job, options)


def test_a_file_that_changes_before_it_is_read_counts_as_what_was_read(desk):
    first = Path("300.ply").read_bytes()
    with Swapped(1) as executor:
        (row,) = map_many(["300.ply"], "{stem}.obj", engine=Engine(executor=executor))
    assert (row.status, row.vertices) == ("certified", len(read_mesh("300.ply").v))
    with ThreadPoolExecutor(1) as executor:
        assert map_many(["300.ply"], "{stem}.obj", engine=Engine(executor=executor))[0].resumed
        Path("300.ply").write_bytes(first)
        (row,) = map_many(["300.ply"], "{stem}.obj", engine=Engine(executor=executor), force=True)
    assert not row.resumed
    assert row.vertices == len(read_mesh("300.ply").v) == len(read_mesh("300.obj").v)


def test_a_file_that_changes_while_it_is_read_gives_no_map(desk, run, monkeypatch):
    def swapped(source, **options):
        monkeypatch.undo()
        monkeypatch.chdir(desk)
        loaded = read_mesh(source, **options)
        os.replace("400.ply", source)
        return loaded

    monkeypatch.setattr("igl_spheremap.populations.mapping.read_mesh", swapped)
    (row,) = run()
    assert (row.status, row.notes) == ("file", "300.ply changed while it was read; run it again")
    assert not Path("300_out.ply").exists()
    assert (run()[0].status, run()[0].resumed) == ("certified", True)


def test_at_most_two_jobs_a_worker_are_in_flight(desk):
    sources = [f"{k}.ply" for k in range(50)]  # none of them is there
    with Counting() as executor:
        assert len(map_many(sources, "{stem}.obj", engine=Engine(executor=executor))) == 50
    assert executor.most <= 4


def test_jobs_whose_worker_dies_are_run_again_and_bad_meshes_are_not(desk):
    with Counting(of_100=1, of_200=2, of_300=5) as executor:
        rows = map_many(
            ["100.ply", "200.ply", "300.ply", "open.ply"],
            "{stem}.obj",
            engine=Engine(executor=executor, retries=2),
        )
    assert [row.status for row in rows] == ["certified", "certified", "failed", "no mesh"]
    assert "its worker died 3 times" in rows[2].notes
    assert executor.calls == 2 + 3 + 3 + 1


def test_a_listener_ends_a_run_with_what_is_in_flight(run):
    heard = []

    def listener(row):
        heard.append(row)
        raise StopIteration

    sources = [*SOURCES[:3], *(f"{k}.ply" for k in range(50))]
    rows = run(sources, listener=listener)
    assert 1 <= len(rows) <= 4
    assert sorted(row.source for row in heard) == sorted(row.source for row in rows)
    assert len(run(sources)) == 53


def test_a_method_is_a_record_or_a_name(run):
    assert run(method="lai2014")[0].energy == run(method=ism.Lai2014(), resume=False)[0].energy
    with pytest.raises(ValueError, match="unknown method 'magic'"):
        run(method="magic")


def test_limits_are_refused_where_they_cannot_be_kept(threads):
    with pytest.raises(ValueError, match="not of other executors"):
        Engine(executor=threads, timeout=1)


def test_a_worker_of_another_version_is_refused_by_its_name(desk):
    class Other(ThreadPoolExecutor):
        def submit(self, call, job, options):
            return super().submit(call, job, replace(options, version="0.0.9"))

    with (
        Other(1) as executor,
        pytest.raises(WorkersUnavailable, match=r":\d+ has igl_spheremap .* 0\.0\.9"),
    ):
        map_many(["300.ply"], "{stem}.obj", engine=Engine(executor=executor))


def test_an_executor_that_drops_its_jobs_ends_the_run(desk):
    class Gone(ThreadPoolExecutor):
        def submit(self, call, job, options):
            future = Future()
            future.cancel()
            future.set_running_or_notify_cancel()
            return future

    with Gone(1) as executor, pytest.raises(WorkersUnavailable, match="run it again"):
        map_many(["300.ply"], "{stem}.obj", engine=Engine(executor=executor))


def test_meshes_that_only_move_give_the_bits_of_new_ones(desk):
    v, f = ism.samples.make("spheroid", n_vertices=400)
    shapes = [v * [1, 1, 1 + k / 4] for k in range(4)] + [v * np.nan, v * 0, v + 1]
    for k, shape in enumerate(shapes):
        write_mesh(f"moved{k}.ply", shape, f)
    with ThreadPoolExecutor(1) as executor:
        rows = map_many(
            [f"moved{k}.ply" for k in range(len(shapes))],
            "{stem}.obj",
            engine=Engine(executor=executor),
        )
    assert [row.status for row in rows] == ["certified"] * 4 + ["no mesh"] * 2 + ["certified"]
    for row, shape in zip(rows, shapes, strict=True):
        if row.status == "certified":
            assert np.array_equal(
                read_mesh(row.target).v, ism.spherical_conformal_map(shape, f).sphere
            )


def test_targets_follow_the_pattern():
    sources = ["s1/surf/lh.white", "s2/surf/rh.white"]
    assert targets_of("{folder}/{stem}.sphere.conformal", sources) == [
        "s1/surf/lh.sphere.conformal",
        "s2/surf/rh.sphere.conformal",
    ]


@pytest.mark.parametrize(
    ("sources", "pattern"),
    [
        (["a/1.ply", "b/1.ply"], "out/{stem}.ply"),
        (["1.ply", "1.ply"], "{stem}.obj"),
        (["1.ply", "./1.ply"], "{stem}.obj"),
        (["1.ply"], "{folder}/{name}"),
        (["1.ply", "2.ply"], "{folder}/2.ply"),
        (["1.ply"], "{stem}.stl"),
        (["1.ply"], "spheres/"),
        (["1.ply"], "{where}.ply"),
        (["1.ply"], "{stem:>9999999999}.ply"),
    ],
)
def test_what_would_be_lost_is_refused(sources, pattern):
    with pytest.raises(ValueError, match="out "):
        targets_of(pattern, sources)


@pytest.mark.parametrize(
    ("sources", "out", "options"),
    [
        (["a\n1.ply", "b/a\n1.ply"], "{name}.npz", {}),
        (["1.ply"], "a\n{where}.ply", {}),
        (["1.ply"], "a\n.stl", {}),
        (["1.ply"], "{stem}.npz", {"report": "a\n.png"}),
    ],
)
def test_a_refusal_is_one_line_whatever_files_are_called(sources, out, options, tmp_path):
    with pytest.raises(ValueError, match=r"a\\n") as refused:
        map_many(sources, str(tmp_path / out), **options)
    assert "\n" not in str(refused.value)


def test_a_manifest_lies_in_the_folder_of_all_targets():
    patterns = [
        "{stem}.ply",
        "out/{stem}.ply",
        "{folder}/{stem}.ply",
        "/tmp/{stem}.ply",
        "out/a_{stem}/b.ply",
        "one.ply",
    ]
    assert [os.path.dirname(manifest_of(pattern)) for pattern in patterns] == [
        "",
        "out",
        "",
        "/tmp",
        "out",
        "",
    ]
    assert {os.path.basename(manifest_of(pattern)) for pattern in patterns} == {
        "maps.manifest.jsonl"
    }


def test_folders_of_targets_are_made(run):
    (row,) = run(out="a/b/{stem}.ply")
    assert row.status == "certified"
    assert sorted(os.listdir("a/b")) == ["300.ply", "maps.manifest.jsonl"]


def test_holes_are_filled_and_caps_are_no_figure(tmp_path):
    v, f = ism.samples.sphere(642)
    ism.write_mesh(tmp_path / "open.ply", v, f[1:])
    sources, out = [tmp_path / "open.ply"], str(tmp_path / "{stem}_sphere.ply")
    with pytest.raises(ValueError, match="repair has 'hole'; give options of repair_mesh"):
        ism.map_many(sources, out, repair={"hole": "fill"})
    (refused,) = ism.map_many(sources, out, repair=True)
    assert refused.status == "no mesh"
    assert "holes='fill'" in refused.notes
    (row,) = ism.map_many(sources, out, repair={"holes": "fill"})
    assert row.status == "certified"
    mesh = ism.repair_mesh(v, f[1:], holes="fill")
    result = ism.spherical_conformal_map(mesh.v, mesh.f, caps=mesh.face_source < 0)
    assert row.mean_angle == pytest.approx(np.abs(result.angle_differences()).mean())
    (again,) = ism.map_many(sources, out, repair={"holes": "fill"})
    assert again.resumed


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("retries", -1),
        ("retries", 1.5),
        ("timeout", -1),
        ("timeout", float("nan")),
        ("timeout", "1"),
        ("processes", 0),
        ("processes", -2),
        ("executor", 3),
    ],
)
def test_what_says_who_runs_jobs_is_checked_as_it_is_said(option, value):
    with pytest.raises((TypeError, ValueError), match=f"^{option} is "):
        Engine(**{option: value})


@pytest.mark.parametrize("sources", ["300.ply", 3])
def test_sources_are_checked_before_a_file_is_touched(sources, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(TypeError, match=r"^sources is "):
        map_many(sources, "{stem}.obj")
    assert list(tmp_path.iterdir()) == []


def test_sources_may_come_one_by_one(run):
    assert [row.status for row in run(f"{size}.ply" for size in (300, 400))] == ["certified"] * 2
