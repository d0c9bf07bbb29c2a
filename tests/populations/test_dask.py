"""A real Dask scheduler and real workers on the loopback interface: workers die, and nothing is lost or there twice."""

import inspect
import json
import os
import socket
import subprocess
import sys
import time
from collections import Counter

import errands
import pytest
from corpus import ROOT
from shell import read_table

import igl_spheremap as ism
from igl_spheremap.apps.cli import main
from igl_spheremap.apps.cli.exits import Exit
from igl_spheremap.populations.child import own_child
from igl_spheremap.populations.engine import connect, deaths_in
from igl_spheremap.populations.map_many import map_many

pytest.importorskip("distributed")


class Cluster:
    """A scheduler, and workers that can be started and killed one by one."""

    def __init__(self, folder):
        self.file = str(folder / "scheduler.json")
        self.processes = [self._start("scheduler", "--host", "127.0.0.1", "--port", "0")]

    def worker(self, path=ROOT):
        """Start a worker process that finds this package, or another one, in a folder."""
        scratch = os.path.dirname(self.file)
        options = (
            "--host",
            "127.0.0.1",
            "--no-nanny",
            "--nthreads",
            "1",
            "--local-directory",
            scratch,
        )
        self.processes.append(self._start("worker", *options, path=path))
        return self.processes[-1]

    def _start(self, kind, *options, path=ROOT):
        environment = {**os.environ, "PYTHONPATH": str(path), "OMP_NUM_THREADS": "1"}
        command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", "--no-dashboard"]
        return subprocess.Popen(
            [*command, "--scheduler-file", self.file, *options],
            env=environment,
            stderr=subprocess.DEVNULL,
        )

    def ready(self, workers):
        """The executor of a client, when this many workers have come."""
        deadline = time.monotonic() + 60
        while not os.path.exists(self.file) and time.monotonic() < deadline:
            time.sleep(0.05)
        executor = connect(self.file, 60)
        executor._client.wait_for_workers(workers, timeout=60)
        return executor

    def end(self):
        for process in self.processes:
            process.kill()
            process.wait()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    cluster = Cluster(tmp_path_factory.mktemp("dask"))
    yield cluster
    cluster.end()


@pytest.fixture(scope="module")
def executor(cluster):
    for _ in range(2):
        cluster.worker()
    executor = cluster.ready(2)
    yield executor
    executor.shutdown()
    executor._client.close()


@pytest.fixture
def sources(tmp_path, monkeypatch):
    """Names of 24 small meshes, no two alike."""
    monkeypatch.chdir(tmp_path)
    names = [f"{k}.ply" for k in range(24)]
    for k, name in enumerate(names):
        ism.write_mesh(name, *ism.samples.make("spheroid", n_vertices=200, aspect=1.5 + k / 10))
    return names


def test_a_worker_that_dies_loses_nothing_and_doubles_nothing(executor, cluster, sources):
    victims = []

    def kill_its_worker(row):
        if not victims:
            pid = int(row.worker.rpartition(":")[2])
            victims.append(pid)
            os.kill(pid, errands.KILL)

    rows = map_many(
        sources, "{stem}.obj", engine=ism.Engine(executor=executor), listener=kill_its_worker
    )
    cluster.worker()
    assert [row.source for row in rows] == sources
    assert {row.status for row in rows} == {"certified"}
    assert len({row.energy for row in rows}) == len(sources)
    with open("maps.manifest.jsonl") as file:
        lines = [json.loads(line) for line in file]
    assert set(Counter(line["key"] for line in lines if "row" in line).values()) == {1}
    again = map_many(sources, "{stem}.obj", engine=ism.Engine(executor=executor))
    assert all(row.resumed for row in again)
    alone = ism.spherical_conformal_map(*ism.read_mesh(sources[7]))
    assert rows[7].energy == alone.energy
    assert (ism.read_mesh(rows[7].target).v == alone.sphere).all()


def test_limits_end_jobs_in_a_process_beside_the_worker(executor, sources):
    rows = map_many(sources[:2], "{stem}.obj", engine=ism.Engine(executor=executor, timeout=0.001))
    assert all(row.notes == "it took more than 0.001 s, the limit" for row in rows)
    (row,) = map_many(
        sources[:1],
        "{stem}.obj",
        engine=ism.Engine(executor=executor, timeout=60, retry_failed=True),
    )
    assert row.status == "certified"


def test_a_process_that_dies_beside_its_worker_is_a_death(executor):
    error = executor.submit(lambda: own_child().call(os._exit, 3)).exception(60)
    assert isinstance(error, deaths_in(executor))
    assert "its process ended with status 3" in str(error)


def test_the_command_runs_on_the_cluster(executor, cluster, sources):
    arguments = ["--out", "{stem}.obj", "--scheduler", cluster.file, "--summary", "all.tsv", "-q"]
    assert main(["batch", *sources[:4], *arguments]) == Exit.OK
    assert [row.status for row in read_table("all.tsv")] == ["certified"] * 4


def test_a_worker_of_another_version_is_refused_by_its_name(
    executor, cluster, sources, tmp_path, capsys
):
    other = tmp_path / "other" / "igl_spheremap"
    other.mkdir(parents=True)
    (other / "__init__.py").write_text('__version__ = "0.0.9"\n')
    worker = cluster.worker(other.parent)
    executor._client.wait_for_workers(3, timeout=60)
    try:
        assert (
            main(["batch", *sources, "--out", "{stem}.obj", "--scheduler", cluster.file])
            == Exit.UNAVAILABLE
        )
    finally:
        worker.kill()
    err = capsys.readouterr().err
    assert err.startswith("igl-spheremap: worker tcp://127.0.0.1:")
    assert "has igl_spheremap 0.0.9, this is" in err


@pytest.fixture
def silent():
    """The address of a program that takes calls and never answers."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        yield f"tcp://127.0.0.1:{listener.getsockname()[1]}"


@pytest.fixture
def of_a_worker(executor):
    return next(iter(executor._client.nthreads()))


@pytest.fixture(
    params=["tcp://127.0.0.1:9", "nowhere", "a.json", "ftp://x:1", "silent", "of_a_worker"]
)
def wrong_place(request, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.json").write_text("{}")
    return (
        request.getfixturevalue(request.param)
        if request.param in ("silent", "of_a_worker")
        else request.param
    )


def test_a_scheduler_that_does_not_answer_takes_one_line(wrong_place, monkeypatch, capsys):
    monkeypatch.setattr(
        "igl_spheremap.apps.cli.commands.batch.connect", lambda place: connect(place, 0.5)
    )
    assert (
        main(["batch", "a.ply", "--out", "{stem}.obj", "--scheduler", wrong_place])
        == Exit.UNAVAILABLE
    )
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert f"no Dask scheduler answers at {wrong_place}" in err


def test_it_is_given_less_than_ten_seconds():
    assert 1 < inspect.signature(connect).parameters["seconds"].default < 10
