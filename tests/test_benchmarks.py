"""The benchmarks run: each has a name, a line that says what it measures, and what it calls exists."""

import subprocess
import sys

import pytest
from corpus import ROOT

pytestmark = pytest.mark.skipif(not (ROOT / "benchmarks").exists(), reason="the benchmarks are not installed")


def benchmark(*words):
    """What a benchmark prints."""
    done = subprocess.run([sys.executable, "-m", "benchmarks", *words], cwd=ROOT, capture_output=True, text=True)
    if "No module named" in done.stderr:
        pytest.skip(done.stderr.splitlines()[-1])
    assert done.returncode == 0, done.stderr
    return done.stdout


def names():
    return [line.split()[0] for line in benchmark("--list").splitlines()]


def test_the_list_says_what_each_measures():
    lines = benchmark("--list").splitlines()
    assert len(lines) > 5
    assert all(len(line.split()) > 4 for line in lines)
    assert {line.split()[0] for line in lines} <= {path.stem for path in (ROOT / "benchmarks").glob("*.py")}


OPTIONS = ("balanced_maps", "convergence", "factors", "gather", "peers", "player", "random_meshes", "repairs",
           "scaling", "shapes", "stages", "versions")


@pytest.mark.parametrize("name", OPTIONS)
def test_every_benchmark_with_options_explains_them(name):
    assert f"python -m benchmarks {name}" in benchmark(name, "--help")


@pytest.mark.parametrize("name", ["population", "throughput"])
def test_the_others_find_what_they_import(name):
    assert name in names()
    code = f"import sys; sys.path.insert(0, 'tests'); import benchmarks.{name}"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    if "No module named" in done.stderr and "igl_spheremap" not in done.stderr.splitlines()[-1]:
        pytest.skip(done.stderr.splitlines()[-1])
    assert done.returncode == 0, done.stderr


def test_a_level_of_scaling_is_a_line_of_figures():
    assert '"certified": true' in benchmark("scaling", "map", "sample:spheroid:n_vertices=500", "--levels", "0")
