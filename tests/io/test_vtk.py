"""VTK's files: equal bit for bit to what VTK itself reads of them, point data kept; damaged ones are named."""

from __future__ import annotations

import itertools
import re

import numpy as np
import pytest

import igl_spheremap as ism
from igl_spheremap import MeshError
from igl_spheremap.io.files import read_mesh, write_mesh
from igl_spheremap.io.scalars import read_scalars
from igl_spheremap.io.vtp import write as write_vtp

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
    text, number = vtk.vtkStringArray(), vtk.vtkIdTypeArray()
    for array, values in ((text, ["a b" * (k % 40) for k in range(len(v))]), (number, range(len(v)))):
        array.SetName(array.GetClassName())
        for value in values:
            array.InsertNextValue(value)
        poly.GetPointData().AddArray(array)
    for holder, n in ((poly.GetCellData(), len(f)), (poly.GetFieldData(), 2)):
        array = support.numpy_to_vtk(np.arange(float(n)), deep=1)
        array.SetName("passed over")
        holder.AddArray(array)
    return poly


def as_vtk_reads(vtk, support, path):
    """Points, triangles and arrays of numbers, as VTK reads a file."""
    reader = vtk.vtkPolyDataReader() if path.suffix == ".vtk" else vtk.vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    if path.suffix == ".vtk":
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


@pytest.mark.parametrize(("mode", "packed", "big", "wide", "encoded"), [
    *itertools.product(("Ascii", "Binary", "Appended"), (False, True), (False, True), (False, True), (False, True))])
def test_xml_files_are_read_as_vtk_reads_them(mode, packed, big, wide, encoded, vtk, support, poly, tmp_path):
    writer = vtk.vtkXMLPolyDataWriter()
    getattr(writer, f"SetDataModeTo{mode}")()
    getattr(writer, "SetCompressorTypeToZLib" if packed else "SetCompressorTypeToNone")()
    getattr(writer, "SetByteOrderToBigEndian" if big else "SetByteOrderToLittleEndian")()
    getattr(writer, "SetHeaderTypeToUInt64" if wide else "SetHeaderTypeToUInt32")()
    writer.SetEncodeAppendedData(encoded)
    writer.SetBlockSize(1024)  # several blocks an array
    writer.SetInputData(poly)
    writer.SetFileName(str(tmp_path / "a.vtp"))
    assert writer.Write()
    check_equal(read_mesh(tmp_path / "a.vtp"), as_vtk_reads(vtk, support, tmp_path / "a.vtp"))


@pytest.mark.parametrize("name", ["a.vtk", "a.vtp"])
def test_vtk_reads_what_is_written(name, vtk, support, ball, tmp_path):
    v, f = ball
    data = point_data(len(v))
    write_mesh(tmp_path / name, v, f, metadata={"point_data": data | {"too short": np.arange(3)}, "mark": "made by"})
    found = as_vtk_reads(vtk, support, tmp_path / name)
    assert np.array_equal(found[0], v)
    assert np.array_equal(found[1], f)
    assert sorted(found[2]) == sorted(data)
    assert all(np.array_equal(found[2][key], values) and found[2][key].dtype == values.dtype
               for key, values in data.items())


@pytest.mark.parametrize(("first", "second"), [("a.vtk", "b.vtp"), ("a.vtp", "b.vtk")])
def test_point_data_survive_both_formats(first, second, ball, tmp_path):
    data = point_data(len(ball[0]))
    write_mesh(tmp_path / first, *ball, metadata={"point_data": data})
    between = read_mesh(tmp_path / first)
    write_mesh(tmp_path / second, *between, metadata=between.metadata)
    check_equal(read_mesh(tmp_path / second), (*ball, data))


def test_point_data_are_scalar_maps(ball, tmp_path):
    for name in ("a.vtk", "a.vtp"):
        write_mesh(tmp_path / name, *ball, metadata={"point_data": {"height": ball[0][:, 2], "vector": ball[0]}})
        maps = read_scalars(tmp_path / name)
        assert list(maps) == ["height"]
        assert np.array_equal(maps["height"], ball[0][:, 2])


def test_names_of_point_data_break_no_file(ball, tmp_path):
    data = {"a\nb&": ball[0][:, 0], "\x00\x1b<\ud800": ball[0][:, 1], "": ball[0][:, 2]}
    for name in ("a.vtk", "a.vtp"):
        write_mesh(tmp_path / name, *ball, metadata={"point_data": data})
        mesh = read_mesh(tmp_path / name)
        assert np.array_equal(mesh.v, ball[0])
        assert len(mesh.metadata["point_data"]) == 2


def test_a_map_has_the_vertices_of_its_surface_in_their_order(tmp_path):
    """As ParaToSPHARMMesh takes it in place of what GenParaMesh writes."""
    from igl_spheremap.apps.cli import main

    v, f = ism.samples.make("spheroid", n_vertices=400)
    write_mesh(tmp_path / "X_surf.vtk", v, f, metadata={"point_data": {"sulc": v[:, 2]}})
    arguments = ["map", str(tmp_path / "X_surf.vtk"), str(tmp_path / "X_para.vtk"), "--balance", "1", "-q"]
    assert main(arguments) == 0
    surface, para = read_mesh(tmp_path / "X_surf.vtk"), read_mesh(tmp_path / "X_para.vtk")
    assert np.array_equal(para.f, surface.f)
    assert np.array_equal(para.v, ism.balanced_spherical_map(v, f, balance=1).sphere)
    assert np.array_equal(para.metadata["point_data"]["sulc"], v[:, 2])


HEAD = "# vtk DataFile Version {}\ntitle\n{}\nDATASET POLYDATA\n"
POINTS = "POINTS 3 float\n0 0 0 1 0 0 0 1 0\n"
OLD = HEAD.format("3.0", "ASCII") + POINTS + "POLYGONS 1 4\n3 0 1 2\n"
NEW = (HEAD.format("5.1", "ASCII") + POINTS
       + "POLYGONS 2 3\nOFFSETS vtktypeint64\n0 3\nCONNECTIVITY vtktypeint64\n0 1 2\n")
FIELD = "POINT_DATA 3\nFIELD FieldData 1\na 1 3 int\n7 8 9\n"


@pytest.mark.parametrize("text", [
    OLD, NEW, OLD.replace("\n", "\r\n"), OLD.replace("3.0", "2.0"), NEW.replace("5.1", "5.0"),
    OLD.replace("POINTS", "FIELD FieldData 1\nt 1 2 string\na%20b\nc\nPOINTS"),
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
    (tmp_path / "a.vtk").write_text(OLD + """CELL_DATA 1
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
""" + "1 2 3 4 5 6 7 8 9\n" * 3 + """GLOBAL_IDS g vtkIdType
4 5 6
FIELD f 2
bits 1 3 bit
1 0 1
wide 2 3 unsigned_char
1 2 3 4 5 255
""")
    data = read_mesh(tmp_path / "a.vtk").metadata["point_data"]
    assert {name: values.shape for name, values in data.items()} == {
        "s": (3,), "colour": (3, 2), "n n": (3, 3), "uv": (3, 2), "t": (3, 9), "g": (3,), "bits": (3,), "wide": (3, 2)}
    assert data["colour"].tolist() == [[0, 255], [128, 0], [255, 255]]
    assert data["g"].tolist() == [4, 5, 6]


def test_polygons_are_cut_where_that_is_asked_for(tmp_path):
    (tmp_path / "a.vtk").write_text(OLD.replace("POLYGONS 1 4\n", "POLYGONS 2 9\n4 0 1 2 0\n"))
    assert read_mesh(tmp_path / "a.vtk", triangulate=True).f.tolist() == [[0, 1, 2], [0, 2, 0], [0, 1, 2]]
    with pytest.raises(MeshError, match="faces are not triangles"):
        read_mesh(tmp_path / "a.vtk")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (OLD.replace("POLYDATA", "UNSTRUCTURED_GRID"), "UNSTRUCTURED_GRID"),
        (OLD.replace("ASCII", "MORSE"), "no header"),
        (OLD.replace("POINTS 3", "POINTS 999999999999"), "cut off"),
        (OLD.replace("POINTS 3", "POINTS -3"), "cut off"),
        (OLD.replace("POINTS 3", "POINTS 4"), "could not convert"),
        (OLD.replace("POLYGONS 1", "POLYGONS 2"), "do not hold 2 cells"),
        (OLD.replace("3 0 1 2", "3 0 1 99999999999"), "out of the range"),
        (OLD.replace("3 0 1 2", "3 0 1 two"), "invalid literal"),
        (OLD.replace("float", "string"), "'string' are not read"),
        (OLD.split("POLYGONS")[0], "no polygons"),
        (OLD + "TRIANGLE_STRIPS 1 4\n3 0 1 2\n", "triangle strips"),
        (OLD + "FOO BAR\n", "'FOO BAR' where a keyword"),
        (NEW.replace("0 3\n", "0 4\n"), "offsets of polygons"),
        (NEW.replace("0 3\n", "3 0\n"), "offsets of polygons"),
        (NEW.replace("OFFSETS vtktypeint64", "OFFSETS"), "where OFFSETS is expected"),
        (OLD + FIELD.replace("a 1 3 int", "a 1 99999999999 string"), "cut off"),
        (OLD + "POINT_DATA 3\nSCALARS s int\n1 2 3\n", "LOOKUP_TABLE"),
    ],
)
def test_the_fault_of_a_legacy_file_is_named(text, words, tmp_path):
    (tmp_path / "a.vtk").write_text(text)
    with pytest.raises(MeshError, match=words):
        read_mesh(tmp_path / "a.vtk")


def xml(tmp_path, ball):
    write_mesh(tmp_path / "a.vtp", *ball)
    return (tmp_path / "a.vtp").read_text()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('type="PolyData"', 'type="ImageData"', "ImageData"),
        ("<VTKFile", '<VTKFile compressor="vtkLZ4DataCompressor"', "vtkLZ4DataCompressor"),
        ('format="binary"', 'format="morse"', "morse"),
        ('NumberOfStrips="0"', 'NumberOfStrips="1"', "strips"),
        ('NumberOfPolys="320"', 'NumberOfPolys="0"', "no polygons"),
        ("UInt64", "UInt32", "offsets|bytes|buffer|damaged"),
        ("</Points>", "", "mismatched tag"),
        (r'binary">\w{9}', 'binary">AAAA!AAAA', "damaged"),
        (r'binary">\w{9}', 'binary">/////////', "follow where"),
        (r'format="binary">', 'format="appended" offset="7">', "follow where"),
    ],
)
def test_the_fault_of_an_xml_file_is_named(old, new, words, ball, tmp_path):
    text = xml(tmp_path, ball)
    (tmp_path / "a.vtp").write_text(re.sub(old, new, text))
    with pytest.raises(MeshError, match=words):
        read_mesh(tmp_path / "a.vtp")


def test_pieces_become_one_mesh(ball, tmp_path):
    v, f = ball
    metadata = {"point_data": {"a": v[:, 0]}}
    for name, g in (("a", f[:100]), ("b", f[100:])):
        write_vtp(tmp_path / f"{name}.vtp", v, g, metadata)
    one, other = ((tmp_path / f"{name}.vtp").read_text() for name in "ab")
    piece = re.search(r"<Piece.*</Piece>", other, re.DOTALL)[0]
    (tmp_path / "c.vtp").write_text(one.replace("</Piece>", f"</Piece>{piece}"))
    mesh = read_mesh(tmp_path / "c.vtp")
    assert np.array_equal(mesh.v, np.concatenate([v, v]))
    assert np.array_equal(mesh.f, np.concatenate([f[:100], f[100:] + len(v)]))
    assert np.array_equal(mesh.metadata["point_data"]["a"], np.concatenate([v[:, 0], v[:, 0]]))


def test_a_block_that_many_arrays_name_does_not_take_much_memory(ball, tmp_path):
    """Each array is 1 MB of the same bytes, and their words take 100."""
    text = xml(tmp_path, ball).rstrip()
    block = (1 << 20).to_bytes(8, "little") + bytes(1 << 20)
    arrays = "".join(f'<DataArray type="Int8" Name="{k}" format="appended" offset="0"/>\n' for k in range(10_000))
    text = text.replace("<PointData>", f"<PointData>{arrays}")
    (tmp_path / "a.vtp").write_bytes(text.replace("</VTKFile>", '<AppendedData encoding="raw">_').encode() + block
                                     + b"</AppendedData></VTKFile>")
    with pytest.raises(MeshError, match="expand to"):
        read_mesh(tmp_path / "a.vtp")
