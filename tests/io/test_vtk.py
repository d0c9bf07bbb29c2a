"""VTK's legacy files: equal bit for bit to VTK's own reading, point data kept; damaged ones are named."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from mutants import legacy_polygons

import igl_spheremap as ism
from igl_spheremap import MeshError
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.scalars import read_scalars
from igl_spheremap.io.write_mesh import write_mesh

#: Point data of all types, as columns and as rows of several numbers.
TYPES = ("i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8")


def point_data(n):
    rng = np.random.default_rng(0)
    data = {f"data {kind}": rng.integers(0, 100, n).astype(kind) for kind in TYPES}
    data["vector"] = rng.normal(size=(n, 3)).astype("f4")
    data["two é%20"] = rng.normal(size=(n, 2))
    return data


@pytest.fixture(scope="module")
def vtk():
    """VTK's own readers and writers."""
    return pytest.importorskip("vtkmodules.all")


@pytest.fixture(scope="module")
def support(vtk):
    return pytest.importorskip("vtkmodules.util.numpy_support")


@pytest.fixture
def poly(vtk, support, ball):
    """The ball in VTK with what its files can hold beside triangles."""
    v, f = ball
    poly, points, cells = vtk.vtkPolyData(), vtk.vtkPoints(), vtk.vtkCellArray()
    points.SetData(support.numpy_to_vtk(np.ascontiguousarray(v, dtype="f4"), deep=1))
    for face in f.tolist():
        cells.InsertNextCell(3, face)
    poly.SetPoints(points)
    poly.SetPolys(cells)
    for name, values in point_data(len(v)).items():
        array = support.numpy_to_vtk(np.ascontiguousarray(values), deep=1)
        array.SetName(name)
        poly.GetPointData().AddArray(array)
    poly.GetPointData().SetActiveScalars("data f8")
    poly.GetPointData().SetActiveVectors("vector")
    poly.GetPointData().GetArray("vector").SetComponentName(0, "the first")
    number = vtk.vtkIdTypeArray()
    number.SetName("identifier")
    for value in range(len(v)):
        number.InsertNextValue(value)
    poly.GetPointData().AddArray(number)
    for holder, n in ((poly.GetCellData(), len(f)), (poly.GetFieldData(), 2)):
        array = support.numpy_to_vtk(np.arange(float(n)), deep=1)
        array.SetName("passed over")
        holder.AddArray(array)
    return poly


def as_vtk_reads(vtk, support, path):
    """Points, triangles and arrays of numbers, as VTK reads a file."""
    reader = vtk.vtkPolyDataReader()
    reader.SetFileName(str(path))
    for switch in ("Scalars", "Vectors", "Normals", "Tensors", "Fields", "ColorScalars", "TCoords"):
        getattr(reader, f"ReadAll{switch}On")()
    reader.Update()
    found = reader.GetOutput()
    data = found.GetPointData()
    arrays = [data.GetAbstractArray(k) for k in range(data.GetNumberOfArrays())]
    kept = {array.GetName(): support.vtk_to_numpy(array) for array in arrays if array.IsNumeric()}
    faces = support.vtk_to_numpy(found.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    return support.vtk_to_numpy(found.GetPoints().GetData()), faces, kept


def check_equal(mesh, expected):
    v, f, data = expected
    assert np.array_equal(mesh.v, v.astype(np.float64))
    assert np.array_equal(mesh.f, f)
    kept = mesh.metadata["point_data"]
    assert sorted(kept) == sorted(data)
    for name, values in data.items():
        assert np.array_equal(kept[name], values, equal_nan=True), name
        assert kept[name].dtype == values.dtype, name


@pytest.mark.parametrize(("version", "binary"), [*itertools.product((42, 51), (False, True))])
def test_legacy_files_are_read_as_vtk_reads_them(version, binary, vtk, support, poly, tmp_path):
    writer = vtk.vtkPolyDataWriter()
    writer.SetFileVersion(version)
    writer.SetFileType(2 if binary else 1)
    writer.SetInputData(poly)
    writer.SetFileName(str(tmp_path / "a.vtk"))
    assert writer.Write()
    check_equal(read_mesh(tmp_path / "a.vtk"), as_vtk_reads(vtk, support, tmp_path / "a.vtk"))


def test_vtk_reads_what_is_written(vtk, support, ball, tmp_path):
    v, f = ball
    data = point_data(len(v))
    write_mesh(
        tmp_path / "a.vtk",
        v,
        f,
        metadata={"point_data": data | {"short": np.arange(3)}, "mark": "made by"},
    )
    found = as_vtk_reads(vtk, support, tmp_path / "a.vtk")
    assert np.array_equal(found[0], v)
    assert np.array_equal(found[1], f)
    assert sorted(found[2]) == sorted(data)
    assert all(
        np.array_equal(found[2][key], values) and found[2][key].dtype == values.dtype
        for key, values in data.items()
    )


def test_point_data_survive(ball, tmp_path):
    data = point_data(len(ball[0]))
    write_mesh(tmp_path / "a.vtk", *ball, metadata={"point_data": data})
    between = read_mesh(tmp_path / "a.vtk")
    write_mesh(tmp_path / "b.vtk", *between, metadata=between.metadata)
    check_equal(read_mesh(tmp_path / "b.vtk"), (*ball, data))


def test_point_data_are_scalar_maps(ball, tmp_path):
    write_mesh(
        tmp_path / "a.vtk",
        *ball,
        metadata={"point_data": {"height": ball[0][:, 2], "vector": ball[0]}},
    )
    maps = read_scalars(tmp_path / "a.vtk")
    assert list(maps) == ["height"]
    assert np.array_equal(maps["height"], ball[0][:, 2])


def test_names_of_point_data_break_no_file(ball, tmp_path):
    data = {"a\nb&": ball[0][:, 0], "\x00\x1b<\ud800": ball[0][:, 1], "": ball[0][:, 2]}
    write_mesh(tmp_path / "a.vtk", *ball, metadata={"point_data": data})
    mesh = read_mesh(tmp_path / "a.vtk")
    assert np.array_equal(mesh.v, ball[0])
    assert len(mesh.metadata["point_data"]) == 2


def test_a_map_has_the_vertices_of_its_surface_in_their_order(tmp_path):
    """As ParaToSPHARMMesh takes it in place of what GenParaMesh writes."""
    from igl_spheremap.apps.cli import main

    v, f = ism.samples.make("spheroid", n_vertices=400)
    write_mesh(tmp_path / "X_surf.vtk", v, f, metadata={"point_data": {"sulc": v[:, 2]}})
    arguments = [
        "map",
        str(tmp_path / "X_surf.vtk"),
        str(tmp_path / "X_para.vtk"),
        "--balance",
        "1",
        "-q",
    ]
    assert main(arguments) == 0
    surface, para = read_mesh(tmp_path / "X_surf.vtk"), read_mesh(tmp_path / "X_para.vtk")
    assert np.array_equal(para.f, surface.f)
    assert np.array_equal(para.v, ism.balanced_spherical_map(v, f, balance=1).sphere)
    assert np.array_equal(para.metadata["point_data"]["sulc"], v[:, 2])


HEAD = "# vtk DataFile Version {}\ntitle\n{}\nDATASET POLYDATA\n"
POINTS = "POINTS 3 float\n0 0 0 1 0 0 0 1 0\n"
OLD = HEAD.format("3.0", "ASCII") + POINTS + "POLYGONS 1 4\n3 0 1 2\n"
NEW = (
    HEAD.format("5.1", "ASCII")
    + POINTS
    + "POLYGONS 2 3\nOFFSETS vtktypeint64\n0 3\nCONNECTIVITY vtktypeint64\n0 1 2\n"
)
GRID = (
    OLD.replace("POLYDATA", "UNSTRUCTURED_GRID").replace("POLYGONS", "CELLS") + "CELL_TYPES 1\n5\n"
)
FIELD = "POINT_DATA 3\nFIELD FieldData 1\na 1 3 int\n7 8 9\n"


@pytest.mark.parametrize("text", [
    OLD, NEW, GRID, OLD.replace("\n", "\r\n"), OLD.replace("3.0", "2.0"), NEW.replace("5.1", "5.0"),
    OLD.replace("POINTS", "FIELD FieldData 1\nt 1 2 int\n4 5\nPOINTS"),
    OLD.replace("POINTS", "FIELD FieldData 2\nname 1 2 string\na ball\n\nt 1 1 bit\n1\nPOINTS"),
    GRID.replace("CELLS 1 4", "CELLS 2 7\n2 0 1").replace("CELL_TYPES 1", "CELL_TYPES 2\n3"),
    OLD.replace("POLYGONS", "polygons").replace("float", "Float"),
    OLD.replace("POLYGONS", "VERTICES 1 2\n1 0\nLINES 1 3\n2 0 1\nPOLYGONS"),
    OLD.replace("POLYGONS", "METADATA\nINFORMATION 1\nNAME X LOCATION Y\nDATA 2\n\nPOLYGONS"),
])  # fmt: skip
def test_dialects(text, tmp_path):
    (tmp_path / "a.vtk").write_bytes((text + FIELD).encode())
    mesh = read_mesh(tmp_path / "a.vtk")
    assert mesh.v.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]
    assert mesh.f.tolist() == [[0, 1, 2]]
    assert mesh.metadata["point_data"]["a"].tolist() == [7, 8, 9]


def test_all_kinds_of_attributes_are_kept(tmp_path):
    (tmp_path / "a.vtk").write_text(
        OLD
        + """CELL_DATA 1
SCALARS c float 1
LOOKUP_TABLE default
5
POINT_DATA 3
SCALARS s short
LOOKUP_TABLE mine
1 2 3
LOOKUP_TABLE mine 1
0 0 1 1
COLOR_SCALARS colour 2
0 1 .5 0 1 1
NORMALS n%20n double
1 0 0 0 1 0 0 0 1
TEXTURE_COORDINATES uv 2 float
0 0 1 0 0 1
TENSORS t float
"""
        + "1 2 3 4 5 6 7 8 9\n" * 3
        + """GLOBAL_IDS g vtkIdType
4 5 6
FIELD f 1
wide 2 3 unsigned_char
1 2 3 4 5 255
"""
    )
    data = read_mesh(tmp_path / "a.vtk").metadata["point_data"]
    assert {name: values.shape for name, values in data.items()} == {
        "s": (3,),
        "colour": (3, 2),
        "n n": (3, 3),
        "uv": (3, 2),
        "t": (3, 9),
        "g": (3,),
        "wide": (3, 2),
    }
    assert data["colour"].tolist() == [[0, 255], [128, 0], [255, 255]]
    assert data["g"].tolist() == [4, 5, 6]


def test_polygons_are_cut_where_that_is_asked_for(tmp_path):
    (tmp_path / "a.vtk").write_text(OLD.replace("POLYGONS 1 4\n", "POLYGONS 2 9\n4 0 1 2 0\n"))
    assert read_mesh(tmp_path / "a.vtk", triangulate=True).f.tolist() == [
        [0, 1, 2],
        [0, 0, 2],
        [0, 1, 2],
    ]
    with pytest.raises(MeshError, match="faces are not triangles"):
        read_mesh(tmp_path / "a.vtk")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (OLD.replace("POLYDATA", "RECTILINEAR_GRID"), "RECTILINEAR_GRID.*extract_surface"),
        (GRID.replace("5\n", "10\n"), "no polygons .VTK's types 10.*extract_surface"),
        (GRID.replace("CELL_TYPES 1\n5\n", "CELL_TYPES 0\n"), "fewer than its cells"),
        (GRID.replace("CELL_TYPES 1\n5\n", ""), "no polygons"),
        (OLD.replace("ASCII", "MORSE"), "no header"),
        (OLD.replace("POINTS 3", "POINTS 999999999999"), "cut off"),
        (OLD.replace("POINTS 3", "POINTS -3"), "cut off"),
        (OLD.replace("POINTS 3", "POINTS 4"), "not 12 numbers of that type"),
        (OLD.replace("POLYGONS 1", "POLYGONS 2"), "do not hold 2 cells"),
        (OLD.replace("3 0 1 2", "3 0 1 99999999999"), "not 4 numbers"),
        (OLD.replace("3 0 1 2", "3 0 1 two"), "not 4 numbers"),
        (OLD.replace("float", "variant"), "'variant' are not read"),
        (OLD.split("POLYGONS")[0], "no polygons"),
        (OLD + "TRIANGLE_STRIPS 1 4\n3 0 1 2\n", "triangle strips"),
        (OLD + "FOO BAR\n", "'FOO BAR' where a keyword"),
        (NEW.replace("0 3\n", "0 4\n"), "ends of polygons"),
        (NEW.replace("0 3\n", "3 0\n"), "do not begin with 0"),
        (NEW.replace("OFFSETS vtktypeint64", "OFFSETS"), "where OFFSETS is expected"),
        (OLD + FIELD.replace("int", "string"), "cut off"),
        (OLD + "POINT_DATA 3\nSCALARS s int\n1 2 3\n", "LOOKUP_TABLE"),
    ],
)
def test_the_fault_of_a_legacy_file_is_named(text, words, tmp_path):
    (tmp_path / "a.vtk").write_text(text)
    with pytest.raises(MeshError, match=words):
        read_mesh(tmp_path / "a.vtk")


def test_the_work_on_many_arrays_is_in_proportion_to_the_file(ball, tmp_path, monkeypatch):
    copied = []

    class Counted(bytes):
        def __getitem__(self, where):
            part = super().__getitem__(where)
            copied.append(len(part))
            return part

    text = legacy_polygons(*ball, new=False) + "FIELD F 2000\n"
    text += "".join(f"a{k} 1 1 int\n{k}\n" for k in range(2000))
    (tmp_path / "a.vtk").write_text(text)
    monkeypatch.setattr(Path, "read_bytes", lambda path: Counted(text.encode()))
    assert np.array_equal(read_mesh(tmp_path / "a.vtk").f, ball[1])
    assert sum(copied) < 10 * len(text)


@pytest.mark.parametrize("between", [" ", "\n", " " * 1000])
def test_numbers_may_lie_far_apart(between, ball, tmp_path):
    """Longer than the part of the text that is split first, which must not cut a number."""
    v, f = ball
    points = between.join(f"{number:.17g}" for number in v.ravel())
    head, _, rest = legacy_polygons(v, f, new=False).partition("POINTS")
    tail = rest[rest.index("POLYGONS") :]
    (tmp_path / "a.vtk").write_text(f"{head}POINTS {len(v)} double\n{points}\n{tail}")
    assert np.array_equal(read_mesh(tmp_path / "a.vtk").v, v)
