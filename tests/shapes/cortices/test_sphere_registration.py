"""A body on another mesh finds its own template: spheres, labels and surfaces come to lie where they belong."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cortices import NAMES, body, turned, write_template
from shell import read_table

import igl_spheremap as ism
from igl_spheremap.io.files import read_sphere
from igl_spheremap.io.pictures import read_picture
from igl_spheremap.io.records import Label
from igl_spheremap.io.scalars import read_labels, read_scalars, write_scalars
from igl_spheremap.io.write_mesh import write_mesh
from igl_spheremap.io.written_map import certify_radius
from igl_spheremap.mesh.measure import surface_area, vertex_areas
from igl_spheremap.populations.table import RegistrationRow, write_table
from igl_spheremap.samples import sphere
from igl_spheremap.shapes.cortices.sphere_registration import register_hemispheres
from igl_spheremap.sphere.rows import unit_rows

pytest.importorskip("nibabel")
TABLE = (Label(0, NAMES[0], (1.0, 0.0, 0.0, 1.0)), Label(1, NAMES[1], (0.0, 0.0, 1.0, 1.0)))
THICK = 1.1  # the pial surface over the white one


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A left hemisphere with white and pial surface, registered under the names of all conventions, and its page."""
    desk = tmp_path_factory.mktemp("cortex")
    to = write_template(desk)
    x, _ = sphere(642)
    write_scalars(
        desk / "lh.halves.annot", {"halves": (x[:, 1] > 0) * 1.0}, metadata={"labels": TABLE}
    )
    y, f = turned(500)
    for kind, factor in (("white", 1.0), ("pial", THICK)):
        write_mesh(desk / f"sub-07_ses-1_hemi-L_{kind}.surf.gii", factor * body(y), f)
    options = {
        "to": [to],
        "names": ("bids", "freesurfer", "hcp"),
        "labels": [f"{desk}/{{hemi}}.halves.annot"],
    }
    (row,) = run(desk, **options, report=desk / "page")
    return desk, row, y, f, options


def run(desk, sources=("sub-07_ses-1_hemi-L_white.surf.gii",), out="out/{subject}", **options):
    with ThreadPoolExecutor(1) as threads:
        return register_hemispheres(
            [desk / source for source in sources],
            str(desk / out),
            **options,
            engine=ism.Engine(executor=threads, processes=1),
        )


def test_the_registered_sphere_lies_on_the_template(made):
    desk, row, y, _, _ = made
    assert row.status == "certified"
    assert row.unlike < 0.03
    for name in (
        "sub-07_ses-1_hemi-L_space-mine_desc-reg_sphere.surf.gii",
        "lh.mine.sphere.reg",
        "sub-07.L.sphere.reg.mine.native.surf.gii",
    ):
        x, g = read_sphere(desk / "out/sub-07" / name)
        check = certify_radius(x, g)
        assert check.folding_free
        assert abs(check.radius - 100) < 1e-4
        off = np.degrees(np.linalg.norm(unit_rows(x) - y, axis=1))
        assert np.median(off) < 1.5
        assert off.max() < 6


def test_labels_are_right_where_they_are_sure(made):
    desk, _, y, _, _ = made
    folder = desk / "out/sub-07"
    labels = next(iter(read_scalars(folder / "lh.halves.annot").values()))
    margin = next(
        iter(
            read_scalars(
                folder / "sub-07_ses-1_hemi-L_seg-halves_desc-margin_probseg.shape.gii"
            ).values()
        )
    )
    truth, border = y[:, 1] > 0, np.abs(y[:, 1])
    right = labels == truth
    assert 0.8 < (margin == 1).mean() < 1
    assert right[margin == 1].mean() > 0.98
    assert right[margin < 1].mean() < right[margin == 1].mean()
    assert border[margin < 1].max() < 0.3
    assert read_labels(folder / "lh.halves.annot") == TABLE
    for name in (
        "sub-07_ses-1_hemi-L_seg-halves_dseg.label.gii",
        "sub-07.L.halves.native.label.gii",
    ):
        assert np.array_equal(next(iter(read_scalars(folder / name).values())), labels)
        assert read_labels(folder / name) == TABLE


def test_data_are_those_of_the_surfaces(made):
    desk, _, y, f, _ = made
    folder, white = desk / "out/sub-07", body(y)
    data = {
        name: next(iter(read_scalars(folder / f"lh.{name}").values()))
        for name in ("sulc", "curv", "area", "mine.distortion")
    }
    middle = ism.read_mesh(folder / "lh.midthickness")
    assert np.allclose(middle.v, white * (1 + THICK) / 2, rtol=1e-6)
    assert np.array_equal(middle.f, f)
    assert np.isclose(data["area"].sum(), surface_area(white, f), rtol=1e-5)
    own, registered = (
        vertex_areas(read_sphere(folder / f"lh.{name}").v, f)
        for name in ("sphere", "mine.sphere.reg")
    )
    assert np.allclose(data["mine.distortion"], np.log2(registered / own), atol=1e-3)
    height = np.linalg.norm(white, axis=1)
    # FreeSurfer's are high in valleys, HCP's on ridges
    assert np.corrcoef(data["curv"], height)[0, 1] < -0.5
    for convention, freesurfer in (("sulc", "sulc"), ("curvature", "curv")):
        theirs = next(
            iter(read_scalars(folder / f"sub-07.L.{convention}.native.shape.gii").values())
        )
        assert np.allclose(theirs, -data[freesurfer], rtol=1e-5, atol=1e-7)


def test_curvature_is_in_units_of_the_surface(tmp_path):
    """Of the same body twice as large sulc is twice as large, and curvature half."""
    to = write_template(tmp_path)
    y, f = turned(300)
    for scale in (1, 2):
        write_mesh(tmp_path / f"sub-{scale}_hemi-L_pial.surf.gii", scale * body(y), f)
    run(tmp_path, [f"sub-{scale}_hemi-L_pial.surf.gii" for scale in (1, 2)], "out", to=[to])
    for name, factor in (("sulc", 2), ("curv", 0.5), ("area", 4)):
        one, two = (
            next(iter(read_scalars(tmp_path / f"out/sub-{scale}_hemi-L_{name}.shape.gii").values()))
            for scale in (1, 2)
        )
        assert np.allclose(two, factor * one, rtol=1e-3, atol=1e-4 * np.abs(two).max())


def test_the_resampled_surface_has_the_templates_vertices(made):
    desk = made[0]
    x, f = sphere(642)
    found = ism.read_mesh(
        desk / "out/sub-07/sub-07_ses-1_hemi-L_space-mine_den-642_midthickness.surf.gii"
    )
    assert np.array_equal(found.f, f)
    assert found.metadata["structure"] == "CortexLeft"
    expected = body(x) * (1 + THICK) / 2
    assert np.median(np.linalg.norm(found.v - expected, axis=1)) < 0.03 * 70


def test_the_dataset_says_that_it_is_a_derivative(made):
    assert '"DatasetType": "derivative"' in (made[0] / "out/dataset_description.json").read_text()
    assert not (made[0] / "out/sub-07/dataset_description.json").exists()


def test_the_page_shows_the_borders_on_surface_and_template(made):
    desk, row = made[:2]
    html = (desk / "page/index.html").read_text("utf-8")
    assert "1 of 1 registrations are certified" in html
    assert f"correlation {1 - row.unlike:.3f}" in html
    (file,) = (desk / "page/subjects").glob("*.png")
    image = read_picture(file).astype(int)
    red = (image[..., 0] > 2 * image[..., 1]) & (image[..., 0] > 100)
    shares = [red[:, k * len(image) : (k + 1) * len(image)].mean() for k in range(4)]
    for on_surface, on_template in (shares[:2], shares[2:]):
        assert 0.3 < on_surface / on_template < 3
        assert on_template > 0.002


def test_what_is_there_is_not_made_again(made):
    """Until one of its files, or one of those that were read, changes."""
    desk, row, _, _, options = made
    (again,) = run(desk, **options)
    assert again.resumed
    assert again.unlike == row.unlike
    taken = desk / "out/sub-07/lh.sulc"
    before = taken.read_bytes()
    taken.unlink()
    (again,) = run(desk, **options)
    assert not again.resumed
    assert taken.read_bytes() == before


def test_files_of_others_are_kept(made):
    desk, _, _, _, options = made
    (desk / "other").mkdir()
    (desk / "other/lh.sphere").write_text("precious")
    freesurfer = options | {"names": ["freesurfer"]}
    (row,) = run(desk, out="other", **freesurfer)
    assert row.status == "file"
    assert "lh.sphere exists" in row.notes
    assert (desk / "other/lh.sphere").read_text() == "precious"
    (row,) = run(desk, out="other", **freesurfer, force=True)
    assert row.status == "certified"


def test_rows_go_through_tables(made, tmp_path):
    for suffix in (".tsv", ".csv"):
        write_table(
            tmp_path / f"rows{suffix}", [made[1], replace(made[1], target="b", status="no mesh")]
        )
        first, second = read_table(tmp_path / f"rows{suffix}")
        assert isinstance(first, RegistrationRow)
        assert first == replace(made[1])
        assert second.status == "no mesh"


def test_a_mirror_image_lies_on_the_other_side(tmp_path):
    """The left body, mirrored, is the right template: the sphere fits the left surface as it is."""
    to = write_template(tmp_path, hemi="rh")
    y, f = turned(400)
    write_mesh(tmp_path / "lh.pial.stand-in.surf.gii", body(y), f)
    (row,) = run(
        tmp_path, ["lh.pial.stand-in.surf.gii"], "out", to=[to], names=["freesurfer"], reflect=True
    )
    assert row.status == "certified"
    x, g = read_sphere(tmp_path / "out/lh.mine.mirrored.sphere.reg")
    assert certify_radius(x, g).folding_free
    assert np.median(np.degrees(np.linalg.norm(unit_rows(x) - y, axis=1))) < 1.5
    right = ism.read_mesh(tmp_path / "out/lh.pial.mirrored.mine")
    middle = body(sphere(642)[0]) * [-1, 1, 1]
    assert np.median(np.linalg.norm(right.v - middle, axis=1)) < 0.03 * 70


def test_surfaces_of_other_meshes_are_refused(tmp_path):
    (tmp_path / "template").mkdir()
    to = write_template(tmp_path / "template")
    for name, (y, f) in (("white", turned(300)), ("pial", turned(400))):
        write_mesh(tmp_path / f"lh.{name}", body(y), f)
    y, f = turned(300)
    write_mesh(tmp_path / "lh.open.surf.gii", body(y), f[1:])
    rows = run(
        tmp_path, ["lh.white", "lh.open.surf.gii", "lh.none.surf.gii"], "out/{subject}", to=[to]
    )
    assert [row.status for row in rows] == ["no mesh", "no mesh", "file"]
    assert "other vertices or faces" in rows[0].notes
    assert "open surface" in rows[1].notes


def test_readers_of_others_take_the_files(made):
    nilearn = pytest.importorskip("nilearn.surface")
    folder = made[0] / "out/sub-07"
    mesh = nilearn.load_surf_mesh(
        folder / "sub-07_ses-1_hemi-L_space-mine_desc-reg_sphere.surf.gii"
    )
    assert np.array_equal(mesh.faces, made[3])
    assert np.allclose(np.linalg.norm(mesh.coordinates, axis=1), 100)
    for name in ("sub-07_ses-1_hemi-L_sulc.shape.gii", "lh.sulc", "lh.halves.annot"):
        path = str(folder / name)
        assert len(nilearn.load_surf_data(path)) == len(made[2])
    assert nilearn.load_surf_mesh(str(folder / "lh.sphere")).faces.shape == made[3].shape


def test_nitransforms_resamples_through_the_registered_sphere(made, tmp_path):
    surface = pytest.importorskip("nitransforms.surface")
    desk, _, y, _, _ = made
    reference = tmp_path / "template_sphere.surf.gii"
    write_mesh(
        reference, *read_sphere(desk / "lh.sphere"), metadata={"geometric_type": "Spherical"}
    )
    moving = desk / "out/sub-07/sub-07_ses-1_hemi-L_space-mine_desc-reg_sphere.surf.gii"
    nibabel = pytest.importorskip("nibabel")
    meshes = [surface.SurfaceMesh(nibabel.load(path)) for path in (reference, moving)]
    height = surface.SurfaceResampler(*meshes).apply(y[:, 2])
    assert np.abs(height - sphere(642)[0][:, 2]).max() < 0.15


def test_neuromaps_takes_data_and_spheres(made):
    images = pytest.importorskip("neuromaps.images")
    folder = made[0] / "out/sub-07"
    image = images.load_gifti(folder / "sub-07_ses-1_hemi-L_sulc.shape.gii")
    assert image.agg_data().shape == (len(made[2]),)
    path = folder / "sub-07_ses-1_hemi-L_space-mine_desc-reg_sphere.surf.gii"
    points, faces = images.load_gifti(path).agg_data()
    assert points.shape == (len(made[2]), 3)
    assert np.array_equal(faces, made[3])


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        (
            {"to": ["fsaverage9"]},
            ValueError,
            "to fsaverage9: give NAME=SURFACE,SPHERE, or one of fsaverage3",
        ),
        ({"to": ["mine=\na"]}, ValueError, r"mine=\\na: give NAME=SURFACE,SPHERE"),
        ({"to": ["mine=a.ply,b.ply"]}, OSError, "b.ply"),
        ({"names": ["spm"]}, ValueError, "unknown names 'spm': choose from bids"),
        ({"labels": ["lh.short.annot"]}, ism.MeshError, "has 3 labels, but mine has 642 vertices"),
        (
            {"out": "a\n{here}"},
            ValueError,
            r"a\\n\{here\}: only {folder} and {subject} can stand in it",
        ),
        ({"out": "lh.white"}, ism.FileError, "lh.white is a file"),
        ({"sources": ["lh.white", "lh.white"]}, ValueError, r"use \{subject\}"),
        ({"sources": ["white.ply"]}, ism.FileError, "does not say which hemisphere it is"),
        ({"twice": True}, ValueError, "each hemisphere, template and atlas once"),
    ],
)
def test_wrong_arguments_are_named_before_the_work(options, error, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    to = write_template(tmp_path)
    y, f = turned(300)
    write_mesh("lh.white", body(y), f)
    write_mesh("white.ply", body(y), f)
    write_scalars("lh.short.annot", {"short": np.array([0.0, 1, 1])}, metadata={"labels": TABLE})
    before = sorted(os.listdir())
    words = {
        "sources": ["lh.white"],
        "out": "out",
        "to": [to] * (1 + options.pop("twice", False)),
    } | options
    sources, out = words.pop("sources"), words.pop("out")
    with pytest.raises(error, match=message):
        register_hemispheres(sources, out, **words)
    assert sorted(os.listdir()) == before


def test_no_label_is_lost_on_the_way(made):
    """Files that name another side are left out."""
    desk, _, _, _, options = made
    write_scalars(
        desk / "rh.halves.annot", {"halves": np.zeros(3)}, metadata={"labels": TABLE}, force=True
    )
    labels = [f"{desk}/{hemi}.halves.annot" for hemi in ("lh", "rh")]
    (row,) = run(desk, **options | {"labels": labels})
    assert row.status == "certified"
    assert Path(desk / "out/sub-07/lh.halves.annot").is_file()


#: The surfaces that smriprep's io_spec.json asks for, of each hemisphere: suffix and extension, space, desc; None means
#: that the name must not have it.
SMRIPREP = {
    "white": ("white.surf.gii", None, ...), "pial": ("pial.surf.gii", None, ...),
    "midthickness": ("midthickness.surf.gii", None, ...), "sphere": ("sphere.surf.gii", None, None),
    "thickness": ("thickness.shape.gii", None, ...), "sulc": ("sulc.shape.gii", None, ...),
    "curv": ("curv.shape.gii", None, ...), "sphere_reg": ("sphere.surf.gii", "fsaverage", "reg"),
    "sphere_reg_fsLR": ("sphere.surf.gii", "fsLR", "reg"), "sphere_reg_msm": ("sphere.surf.gii", "fsLR", "msmsulc"),
    "cortex_mask": ("mask.label.gii", None, "cortex"),
}  # fmt: skip


KEYS = "space", "desc"


def found_by(query, names):
    """The names that a query finds, by entities as readers of BIDS take them apart."""
    end, *wanted = query
    found = []
    for name in names:
        *entities, suffix = name.split("_")
        values = dict(entity.split("-", 1) for entity in entities)
        if suffix == end and all(
            want in (..., values.get(key)) for key, want in zip(KEYS, wanted, strict=True)
        ):
            found.append(name)
    return found


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    """fMRIPrep's set of a left hemisphere, whose template has a medial wall where y is below -.6."""
    desk = tmp_path_factory.mktemp("fmriprep")
    files = write_template(desk).partition("=")[2]
    x, _ = sphere(642)
    table = (
        Label(0, "Medial_wall", (1.0, 0.0, 0.0, 1.0)),
        Label(1, "cortex", (0.0, 0.0, 1.0, 1.0)),
    )
    # -1: no label, as in FreeSurfer's own
    values = np.where(x[:, 1] > -0.6, 1.0, np.where(x[:, 0] > 0, 0.0, -1.0))
    write_scalars(desk / "lh.aparc.annot", {"aparc": values}, metadata={"labels": table})
    y, f = turned(500)
    for kind, factor in (("white", 1.0), ("pial", THICK)):
        write_mesh(desk / f"sub-07_ses-1_hemi-L_{kind}.surf.gii", factor * body(y), f)
    options = {"to": [f"{space}={files}" for space in ("fsaverage", "fsLR")], "names": ["fmriprep"]}
    (row,) = run(desk, out="out/{subject}/anat", **options, labels=[f"{desk}/{{hemi}}.aparc.annot"])
    assert row.status == "certified"
    return desk, options, y, f


def test_smriprep_finds_each_of_its_files_once(prepared):
    folder = prepared[0] / "out/sub-07/anat"
    names = [path.name for path in folder.iterdir()]
    assert (
        '"DatasetType": "derivative"' in (prepared[0] / "out/dataset_description.json").read_text()
    )
    assert {key: len(found_by(query, names)) for key, query in SMRIPREP.items()} == dict.fromkeys(
        SMRIPREP, 1
    )
    for key in ("sphere", "sphere_reg", "sphere_reg_fsLR", "sphere_reg_msm"):
        assert certify_radius(*read_sphere(folder / found_by(SMRIPREP[key], names)[0])).folding_free


def test_thickness_is_that_between_the_surfaces_and_none_on_the_medial_wall(prepared):
    desk, _, y, _ = prepared
    begin = desk / "out/sub-07/anat/sub-07_ses-1_hemi-L_"
    mask, thickness, margin = (
        next(iter(read_scalars(f"{begin}{end}").values()))
        for end in (
            "desc-cortex_mask.label.gii",
            "thickness.shape.gii",
            "seg-aparc_desc-margin_probseg.shape.gii",
        )
    )
    assert [label.name for label in read_labels(f"{begin}desc-cortex_mask.label.gii")] == [
        "???",
        "cortex",
    ]
    assert (mask == (y[:, 1] > -0.6))[margin == 1].mean() > 0.98
    assert (thickness[mask == 0] == 0).all()
    white, pial = (ism.read_mesh(f"{begin}{kind}.surf.gii") for kind in ("white", "pial"))
    assert np.array_equal(white.v, ism.read_mesh(desk / "sub-07_ses-1_hemi-L_white.surf.gii").v)
    gap = np.linalg.norm(pial.v - white.v, axis=1)
    assert (thickness <= gap * (1 + 1e-6)).all()
    assert np.median((thickness / gap)[mask == 1]) > 0.8


def test_what_the_set_of_fmriprep_lacks_is_named(prepared, tmp_path):
    desk, options, y, f = prepared
    write_mesh(tmp_path / "sub-1_hemi-L_white.surf.gii", body(y), f)
    with pytest.raises(
        ism.FileError,
        match="needs a pial surface beside it and labels whose table names the medial",
    ):
        run(desk, [tmp_path / "sub-1_hemi-L_white.surf.gii"], **options)


@pytest.mark.parametrize("wrong", [0.5, np.nan])
def test_labels_that_are_no_whole_numbers_are_named(made, tmp_path, wrong):
    desk, _, _, _, options = made
    values = np.zeros(642)
    values[7] = wrong
    write_scalars(tmp_path / "lh.a.npz", {"a": values})
    with pytest.raises(
        ism.MeshError, match=f"has the label {wrong:g} at vertex 7; give whole numbers"
    ):
        run(desk, to=options["to"], labels=[str(tmp_path / "lh.a.npz")])


def test_a_file_that_says_another_side_than_its_name_is_refused(made, tmp_path):
    y, f = turned(300)
    write_mesh(tmp_path / "lh.white.surf.gii", body(y), f, metadata={"structure": "CortexRight"})
    (row,) = run(made[0], [tmp_path / "lh.white.surf.gii"], str(tmp_path / "out"), to=made[4]["to"])
    assert row.status == "no mesh"
    assert "is taken for CortexLeft, and says itself that it is CortexRight" in row.notes


def test_a_template_that_is_inside_out_is_named(made, tmp_path):
    x, f = sphere(642)
    write_mesh(tmp_path / "lh.pial", body(x) * [-1, 1, 1], f)
    write_mesh(tmp_path / "lh.sphere", 100 * x, f)
    (row,) = run(
        made[0], out=str(tmp_path / "out"), to=[f"mine={tmp_path}/lh.pial,{tmp_path}/lh.sphere"]
    )
    assert row.status == "file"
    assert "lh.sphere" in row.notes
    assert "inside out: its faces point inwards" in row.notes


@pytest.mark.parametrize("name", ["lh.wm.ply", "lh.cortex.ply"])
def test_a_surface_alone_keeps_the_name_of_its_kind_and_a_pial_one_is_given(name, made, tmp_path):
    *_, y, f, options = made
    kind = {"lh.wm.ply": "white"}.get(name, "surface")
    write_mesh(tmp_path / name, body(y), f)
    write_mesh(tmp_path / "outside_L.ply", THICK * body(y), f)
    (row,) = run(tmp_path, [name], out="alone", to=options["to"], names=("freesurfer",))
    assert f"files are called {kind}; for the midthickness give pial FILE" in row.notes
    made_of = {path.name for path in (tmp_path / "alone").iterdir()}
    assert f"lh.{kind}.mine" in made_of
    assert not any("midthickness" in each for each in made_of)
    given = str(tmp_path / "outside_{side}.ply")
    (row,) = run(tmp_path, [name], out="both", to=options["to"], names=("freesurfer",), pial=given)
    assert "midthickness" not in row.notes
    middle = ism.read_mesh(tmp_path / "both/lh.midthickness")
    assert np.allclose(middle.v, body(y) * (1 + THICK) / 2, rtol=1e-6)
