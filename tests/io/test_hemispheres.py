"""Names of hemispheres' files, by the conventions of BIDS, FreeSurfer and HCP."""

import pytest

from igl_spheremap.errors import FileError
from igl_spheremap.io.hemispheres import Names, fill_sides, hemisphere_of, partner_of

LEFT, RIGHT = "CortexLeft", "CortexRight"


@pytest.mark.parametrize(
    ("path", "subject", "entities", "side", "kind"),
    [
        ("sub-01_hemi-L_white.surf.gii", "sub-01", "sub-01", "L", "white"),
        (
            "sub-01_ses-a_acq-x_hemi-R_midthickness.surf.gii",
            "sub-01",
            "sub-01_ses-a_acq-x",
            "R",
            "midthickness",
        ),
        ("subjects/bert/surf/lh.white", "bert", "sub-bert", "L", "white"),
        ("subjects/sub-7/surf/rh.smoothwm", "sub-7", "sub-7", "R", "white"),
        ("100307.R.pial.native.surf.gii", "100307", "sub-100307", "R", "pial"),
        ("lh.central.T1_of_me.gii", "T1_of_me", "sub-T1ofme", "L", "midthickness"),
        ("rh.pial", "x", "sub-x", "R", "pial"),
        ("fsaverage5/white_left.gii.gz", "x", "sub-x", "L", "white"),
        ("wm_lh.gii", "x", "sub-x", "L", "white"),
        ("lh.cortex.surf.gii", "cortex", "sub-cortex", "L", "surface"),
    ],
)
def test_names_tell_subject_side_and_kind(path, subject, entities, side, kind):
    found = hemisphere_of(path)
    assert (found.subject, found.entities, found.side, found.kind) == (
        subject,
        entities,
        side,
        kind,
    )


def test_the_side_may_come_from_the_file():
    assert hemisphere_of("white.surf.gii", RIGHT).hemi == "rh"
    with pytest.raises(FileError, match="does not say which hemisphere"):
        hemisphere_of("white.surf.gii")


@pytest.mark.parametrize(
    ("convention", "expected"),
    [
        (
            "bids",
            [
                "sub-1_hemi-L_sphere.surf.gii",
                "sub-1_hemi-L_space-fsaverage_desc-reg_sphere.surf.gii",
                "sub-1_hemi-L_space-fsLR_desc-reg_sphere.surf.gii",
                "sub-1_hemi-L_curv.shape.gii",
                "sub-1_hemi-L_space-fsLR_den-32k_midthickness.surf.gii",
                "sub-1_hemi-L_seg-aparc_dseg.label.gii",
            ],
        ),
        (
            "freesurfer",
            [
                "lh.sphere",
                "lh.sphere.reg",
                "lh.fsLR.sphere.reg",
                "lh.curv",
                "lh.midthickness.fsLR",
                "lh.aparc.annot",
            ],
        ),
        (
            "hcp",
            [
                "sub-1.L.sphere.native.surf.gii",
                "sub-1.L.sphere.reg.native.surf.gii",
                "sub-1.L.sphere.reg.reg_LR.native.surf.gii",
                "sub-1.L.curvature.native.shape.gii",
                "sub-1.L.midthickness.32k_fs_LR.surf.gii",
                "sub-1.L.aparc.native.label.gii",
            ],
        ),
    ],
)
def test_files_have_the_names_that_pipelines_expect(convention, expected):
    names = Names(convention, hemisphere_of("sub-1_hemi-L_white.surf.gii"))
    assert [
        names.of("sphere"),
        names.of("registered", "fsaverage"),
        names.of("registered", "fsLR"),
        names.of("curv"),
        names.of("resampled", "fsLR", vertices=32_492, kind="midthickness"),
        names.of("labels", "aparc"),
    ] == expected


@pytest.mark.parametrize("convention", ["bids", "freesurfer", "hcp"])
def test_no_two_files_have_one_name(convention):
    """Neither of two frames, nor of a surface and its mirror image; what belongs to the surface alone has one name."""
    half = hemisphere_of("rh.white")
    found = [
        name
        for mirrored in (False, True)
        for names in [Names(convention, half, mirrored)]
        for name in (
            *(
                names.of(what, space)
                for space in ("fsaverage", "fsLR", "mine")
                for what in ("registered", "distortion")
            ),
            *(
                names.of("resampled", space, vertices=642, kind="white")
                for space in ("fsaverage", "fsLR")
            ),
            names.of("labels", "a"),
            names.of("margin", "a"),
        )
    ]
    assert len(set(found)) == len(found)
    assert Names(convention, half, True).of("sulc") == Names(convention, half).of("sulc")


def test_the_pial_surface_beside_a_white_one_is_found(tmp_path):
    for name in (
        "lh.white",
        "lh.pial",
        "rh.white",
        "sub-white_hemi-L_white.gii",
        "sub-pial_hemi-L_pial.gii",
    ):
        (tmp_path / name).touch()
    assert partner_of(tmp_path / "lh.white") == str(tmp_path / "lh.pial")
    assert partner_of(tmp_path / "rh.white") is None
    assert partner_of(tmp_path / "lh.pial") is None
    assert partner_of(tmp_path / "sub-white_hemi-L_white.gii") is None


def test_sides_are_filled_in():
    assert fill_sides("{hemi}.{side}", LEFT) == "lh.L"


@pytest.mark.parametrize(
    ("white", "pial"),
    [
        ("lh.white", "lh.pial"),
        ("rh.smoothwm", "rh.pial"),
        ("wm_lh.gii", "pia_lh.gii"),
        ("a_white_surface_left.obj", "a_gray_surface_left.obj"),
        ("left.inner.dfs.gii", "left.pial.dfs.gii"),
    ],
)
def test_the_pial_surface_beside_a_white_one_is_found_by_its_name(white, pial, tmp_path):
    assert partner_of(tmp_path / white) is None
    (tmp_path / pial).touch()
    assert partner_of(tmp_path / white) == str(tmp_path / pial)
    assert partner_of(tmp_path / pial) is None
