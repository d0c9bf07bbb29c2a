"""The package runs from a zip, and within a program that PyInstaller froze: it reads no file beside its modules."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import igl_spheremap

ROOT = Path(igl_spheremap.__file__).parent
PROGRAM = """
import igl_spheremap as ism
v, f = ism.samples.make("spheroid", n_vertices=500)
print(ism.spherical_conformal_map(v, f).certificate.folding_free, ism.__file__)
"""


def test_a_zip_of_the_package_is_imported(tmp_path):
    """A sample is mapped, a mesh is refused with its repair, help is printed, and a page is written."""
    shutil.make_archive(str(tmp_path / "all"), "zip", ROOT.parent, ROOT.name)
    program = (
        PROGRAM
        + """
from igl_spheremap.apps.cli import main
try:
    ism.check_mesh(v, f[1:])
except ism.MeshError as error:
    print(error)
assert main(["map", "--help"]) == main(["map", "sample:sphere", "a.obj", "--report", "a.html", "-q"]) == 0
"""
    )
    out = subprocess.run(
        [sys.executable, "-c", program],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(tmp_path / "all.zip")},
        capture_output=True,
        text=True,
    )
    assert not out.returncode, out.stderr
    folding_free, file = out.stdout.splitlines()[0].split()
    assert folding_free == "True"
    assert str(tmp_path / "all.zip") in file
    assert "repair_mesh(v, f, holes='fill')" in out.stdout
    assert (tmp_path / "a.html").exists()


def test_a_frozen_program_maps(tmp_path):
    pytest.importorskip("PyInstaller")
    (tmp_path / "three.py").write_text(PROGRAM)
    hooks = ROOT / "_pyinstaller"
    command = [sys.executable, "-m", "PyInstaller", "--onedir", "--paths", str(ROOT.parent)]
    done = subprocess.run(
        [*command, "--additional-hooks-dir", str(hooks), "three.py"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert not done.returncode, done.stderr
    program = tmp_path / "dist" / "three" / "three"
    out = subprocess.run([program], cwd=tmp_path, capture_output=True, text=True)
    assert out.stdout.startswith("True"), out.stderr
