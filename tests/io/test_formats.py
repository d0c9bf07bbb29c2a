"""Files of other programs: read as they write them, or named with a conversion; sound ones are never called damaged."""

from __future__ import annotations

import gzip
import itertools
import zipfile

import numpy as np
import pytest
from other_programs import WRITERS, mni, xml

import igl_spheremap as ism
from igl_spheremap import FileError, MeshError
from igl_spheremap.io.files import read_mesh
from igl_spheremap.io.formats import FOREIGN, FOREIGN_MARKS, READ_ONLY
from igl_spheremap.io.scalars import read_scalars
from igl_spheremap.io.write_mesh import write_mesh


@pytest.mark.parametrize("name", WRITERS)
def test_surfaces_of_other_programs_are_read(name, ball, tmp_path):
    """By their first bytes, too."""
    v, f = ball
    for place in {"ball.obj": ["ball.obj"]}.get(name, [name, "mystery"]):
        (tmp_path / place).write_bytes(WRITERS[name](v, f))
        mesh = read_mesh(tmp_path / place)
        assert np.array_equal(mesh.v, v.astype("f4") if "mz3" in name else v)
        assert np.array_equal(mesh.f, f)


@pytest.mark.parametrize("name", WRITERS)
def test_files_that_are_cut_off_are_named(name, ball, tmp_path):
    content = WRITERS[name](*ball)
    for size in np.linspace(3, 0.95 * len(content), 20).astype(int):
        (tmp_path / name).write_bytes(content[:size])
        with pytest.raises(MeshError) as caught:
            read_mesh(tmp_path / name)
        assert "\n" not in str(caught.value)


def test_colours_of_mni_objects_are_passed_over(ball, tmp_path):
    v, f = ball
    for kind, rows in ((1, len(f)), (2, len(v))):
        colours = f"\n{kind} " + "0.5 0.5 0.5 1\n" * rows
        content = mni(v, f).replace(b"\n0 1 1 1 1\n", colours.encode())
        (tmp_path / "ball.obj").write_bytes(content)
        assert np.array_equal(read_mesh(tmp_path / "ball.obj").f, f)


def test_corners_of_mni_objects_are_whole_numbers(ball, tmp_path):
    *words, _ = mni(*ball).split()
    (tmp_path / "ball.obj").write_bytes(b" ".join([*words, b"0.5"]))
    with pytest.raises(MeshError, match="damaged"):
        read_mesh(tmp_path / "ball.obj")


@pytest.mark.parametrize(
    ("kind", "mode", "packer", "order", "header"),
    [
        *itertools.product(
            ("PolyData", "UnstructuredGrid"),
            ("Ascii", "Binary", "Appended", "Raw"),
            ("None", "ZLib", "LZMA"),
            ("Little", "Big"),
            ("UInt32", "UInt64"),
        )
    ],
)
def test_xml_is_read_as_vtk_writes_it(kind, mode, packer, order, header, ball, tmp_path):
    vtk = pytest.importorskip("vtkmodules.all")
    v, f = ball
    write_mesh(tmp_path / "ball.vtk", v, f, metadata={"point_data": {"z": v[:, 2], "v": v}})
    reader = vtk.vtkPolyDataReader()
    reader.SetFileName(str(tmp_path / "ball.vtk"))
    reader.Update()
    grid = vtk.vtkAppendFilter()
    grid.AddInputData(reader.GetOutput())
    grid.Update()
    writer = getattr(vtk, f"vtkXML{kind}Writer")()
    writer.SetInputData(reader.GetOutput() if kind == "PolyData" else grid.GetOutput())
    writer.SetEncodeAppendedData(mode == "Appended")
    writer.SetBlockSize(512)  # several blocks an array
    for setting in (
        f"DataModeTo{mode.replace('Raw', 'Appended')}",
        f"CompressorTypeTo{packer}",
        f"ByteOrderTo{order}Endian",
        f"HeaderTypeTo{header}",
    ):
        getattr(writer, f"Set{setting}")()
    writer.SetFileName(str(tmp_path / "ball.vtp"))
    assert writer.Write()
    mesh = read_mesh(tmp_path / "ball.vtp")
    tolerance = 1e-9 if mode == "Ascii" else 0
    assert np.abs(mesh.v - v).max() <= tolerance
    assert np.array_equal(mesh.f, f)
    assert np.abs(mesh.metadata["point_data"]["v"] - v).max() <= tolerance
    assert np.abs(read_scalars(tmp_path / "ball.vtp")["z"] - v[:, 2]).max() <= tolerance


def test_texts_in_binary_are_passed_over_whatever_their_length(ball, tmp_path):
    """As VTK writes them, their lengths take 1, 2, 4 and 8 bytes."""
    vtk = pytest.importorskip("vtkmodules.all")
    write_mesh(tmp_path / "ball.vtk", *ball)
    reader = vtk.vtkPolyDataReader()
    reader.SetFileName(str(tmp_path / "ball.vtk"))
    reader.Update()
    texts = vtk.vtkStringArray()
    texts.SetName("texts")
    for size in (0, 1, 63, 64, 16383, 16384, 70000):
        texts.InsertNextValue("x" * size)
    reader.GetOutput().GetFieldData().AddArray(texts)
    for version, binary in itertools.product((42, 51), (1, 2)):
        writer = vtk.vtkPolyDataWriter()
        writer.SetFileVersion(version)
        writer.SetFileType(binary)
        writer.SetInputData(reader.GetOutput())
        writer.SetFileName(str(tmp_path / "a.vtk"))
        assert writer.Write()
        assert np.array_equal(read_mesh(tmp_path / "a.vtk").f, ball[1])


def test_pieces_are_joined_and_pixels_have_their_corners_row_by_row(ball, tmp_path):
    v, f = ball
    text = xml(v, f).decode()
    piece = text[text.index("<Piece") : text.index("</Piece>") + 8]
    (tmp_path / "two.vtp").write_text(text.replace(piece, 2 * piece))
    mesh = read_mesh(tmp_path / "two.vtp")
    assert np.array_equal(mesh.f, np.concatenate([f, f + len(v)]))
    assert np.array_equal(mesh.metadata["point_data"]["z"], np.tile(v[:, 2], 2))
    (tmp_path / "pixel.vtk").write_text(
        "# vtk DataFile Version 3.0\na\nASCII\nDATASET UNSTRUCTURED_GRID\n"
        "POINTS 4 float\n0 0 0 1 0 0 0 1 0 1 1 0\nCELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n8\n"
    )
    assert read_mesh(tmp_path / "pixel.vtk", triangulate=True).f.tolist() == [[0, 1, 3], [0, 3, 2]]


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('type="PolyData"', 'type="ImageData"', "'ImageData', no polygons"),
        ("Piece Num", 'Piece NumberOfStrips="2" Num', "2 triangle strips"),
        ('Name="offsets">3 6', 'Name="offsets">6 3', "ends of polygons"),
        ("<!-- a ball -->", '<!DOCTYPE x [<!ENTITY a "b">]>', "defines entities"),
        ('format="ascii"', 'format="appended"', "damaged"),
    ],
)
def test_the_fault_of_xml_is_named(old, new, words, ball, tmp_path):
    text = (
        xml(*ball)
        .decode()
        .replace('NumberOfComponents="3">', 'NumberOfComponents="3" format="ascii">')
    )
    assert old in text
    (tmp_path / "a.vtp").write_text(text.replace(old, new))
    with pytest.raises(MeshError, match=words):
        read_mesh(tmp_path / "a.vtp")


MARKS = {
    ".dae": b'<?xml version="1.0"?>\n<COLLADA/>',
    ".x3d": b"<!-- made --><X3D/>",
    ".xdmf": b"<Xdmf/>",
    ".wrl": b"#VRML V2.0 utf8",
    ".fbx": b"Kaydara FBX Binary",
    ".blend": b"BLENDER-v300",
    ".step": b"ISO-10303-21;",
    ".msh": b"$MeshFormat\n",
    ".mesh": b"MeshVersionFormatted 2",
    ".nrrd": b"NRRD0004\n",
    ".mhd": b"ObjectType = Image",
    ".png": b"\x89PNG\r\n",
    ".jpg": b"\xff\xd8\xff\xe0",
    ".tif": b"II*\0",
    ".patch.3d": b"\xff\xff\xff\xff\0\0\0\1",
    ".3mf": b"PK\x03\x04" + bytes(26) + b"[Content_Types].xml",
}


@pytest.mark.parametrize("end", FOREIGN)
def test_formats_that_are_not_read_are_named_with_a_conversion(end, tmp_path):
    """By their names, and by their first bytes; as something to be written they are unknown."""
    (tmp_path / f"a{end}").write_bytes(MARKS.get(end, b"something"))
    (tmp_path / "mystery").write_bytes(MARKS.get(end, b"something"))
    name, remedy = FOREIGN[end]
    places = [f"a{end}"] + ["mystery"] * (end in MARKS)
    for place in places:
        with pytest.raises(FileError) as caught:
            read_mesh(tmp_path / place)
        words = f"{tmp_path / place} is {name}, which is not read; {remedy.split('{')[0]}"
        assert str(caught.value).startswith(words)
        assert "damaged" not in str(caught.value)
    with pytest.raises(FileError, match="unknown format"):
        write_mesh(tmp_path / f"b{end}", np.zeros((3, 3)), [[0, 1, 2]])


def test_every_mark_of_a_format_that_is_not_read_is_tried():
    assert {*FOREIGN_MARKS.values()} == {*MARKS}


def test_what_is_packed_or_an_archive_of_something_else_is_named(ball, tmp_path):
    write_mesh(tmp_path / "ball.ply", *ball)
    (tmp_path / "ball.ply.gz").write_bytes(gzip.compress((tmp_path / "ball.ply").read_bytes()))
    with pytest.raises(FileError, match=r"packed by gzip; unpack it: gunzip .*ball\.ply\.gz"):
        read_mesh(tmp_path / "ball.ply.gz")
    with zipfile.ZipFile(tmp_path / "a.npz", "w") as archive:
        archive.writestr("notes.txt", "notes")
    with pytest.raises(MeshError, match=r"holds notes\.txt, which is no array"):
        read_mesh(tmp_path / "a.npz")


@pytest.mark.parametrize("end", READ_ONLY)
def test_what_is_read_only_names_what_is_written(end, tmp_path):
    with pytest.raises(FileError, match=f"{end} files are read only; write {READ_ONLY[end]}"):
        write_mesh(tmp_path / f"a{end}", np.zeros((3, 3)), [[0, 1, 2]])


def test_the_documented_conversions_work(tmp_path):
    """PyVista's, of a ball that trimesh made, and of a grid with volumes."""
    pyvista, trimesh = pytest.importorskip("pyvista"), pytest.importorskip("trimesh")
    pyvista.wrap(trimesh.creation.icosphere(1)).save(tmp_path / "a.vtp")
    pyvista.read(tmp_path / "a.vtp").save(tmp_path / "a.vtk")
    for name in ("a.vtp", "a.vtk"):
        assert ism.spherical_conformal_map(tmp_path / name).certificate.folding_free
    pyvista.ImageData(dimensions=(3, 3, 3)).save(tmp_path / "grid.vti")
    surface = pyvista.read(tmp_path / "grid.vti").extract_surface(algorithm=None).triangulate()
    surface.save(tmp_path / "surface.vtk")
    assert len(read_mesh(tmp_path / "surface.vtk").f) == 48


def test_a_binary_mni_object_is_named(tmp_path):
    (tmp_path / "mid.obj").write_bytes(b"p\0\0\x80\x3e" + bytes(200))
    with pytest.raises(MeshError, match="a binary MNI object"):
        ism.read_mesh(tmp_path / "mid.obj")
