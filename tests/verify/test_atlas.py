"""Chart atlases: the certificate agrees with rational arithmetic at every scale, and angles are those that closed."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from bodies import random_body

from igl_spheremap import MeshError, atlas_angle_differences, spherical_conformal_map
from igl_spheremap.io import read_map, write_map
from igl_spheremap.mesh.check import check_mesh
from igl_spheremap.mesh.measure import corner_angles
from igl_spheremap.untangle.angles import close_angles, proper_angles
from igl_spheremap.untangle.blocks import VertexBlocks
from igl_spheremap.untangle.charts import make_atlas
from igl_spheremap.untangle.layout import Layout
from igl_spheremap.verify.atlas import certify_atlas


@pytest.fixture(scope="module")
def body():
    """A body with limbs beyond float64, its closed angles, and their atlas."""
    mesh = check_mesh(*random_body(2, depth=60))
    source = proper_angles(corner_angles(mesh.v, mesh.f))
    closed = close_angles(VertexBlocks(mesh.f), source, hole=int((mesh.f.max(axis=1) < 642).argmax()))
    layout = Layout(mesh.f, closed.angles, closed.hole)
    return mesh, closed, make_atlas(layout, root=int(mesh.f[closed.hole, 0]))


def rational_signs(atlas, f):
    """Orientation of every face, all positions being fractions."""
    origins = [(Fraction(0), Fraction(0))]
    for parent, origin in zip(atlas.parent[1:].tolist(), atlas.origin[1:].tolist(), strict=True):
        x, y = origins[parent]
        origins.append((x + Fraction(origin.real), y + Fraction(origin.imag)))
    p = [(Fraction(z.real) + origins[k][0], Fraction(z.imag) + origins[k][1])
         for z, k in zip(atlas.z.tolist(), atlas.chart.tolist(), strict=True)]
    det = [(p[b][0] - p[a][0]) * (p[c][1] - p[a][1]) - (p[b][1] - p[a][1]) * (p[c][0] - p[a][0])
           for a, b, c in f.tolist()]
    return np.array([(d > 0) - (d < 0) for d in det])


def test_a_body_beyond_float64_is_free_of_foldings_in_charts(body):
    mesh, closed, atlas = body
    assert atlas.certificate.folding_free
    assert len(atlas.parent) > 3
    signs = rational_signs(atlas, mesh.f)
    assert signs[closed.hole] == -1
    assert (np.delete(signs, closed.hole) == 1).all()
    z = atlas.z + atlas.origin[atlas.chart]
    assert len(np.unique(z)) < len(z)  # one set of coordinates does not tell all vertices apart


@pytest.mark.parametrize("power", [0, -900, 900])
def test_planted_foldings_are_those_of_rational_arithmetic(body, power):
    mesh, closed, atlas = body
    rng = np.random.default_rng(0)
    z = atlas.z.copy()
    for a, b, c in mesh.f[rng.choice(len(mesh.f), 40)]:
        z[a] = z[b] if rng.random() < 0.3 else 2 * z[c] - z[a]
    with np.errstate(under="ignore", over="ignore"):
        size = 2.0 ** power
        wrong = replace(atlas, z=z * size, origin=atlas.origin * size)
    certificate, signs = certify_atlas(wrong, mesh.f), rational_signs(wrong, mesh.f)
    others = np.arange(len(mesh.f)) != closed.hole
    assert certificate.flipped.tolist() == np.flatnonzero((signs < 0) & others).tolist()
    assert certificate.degenerate.tolist() == np.flatnonzero((signs == 0) & others).tolist()
    assert certificate.foldings > 20
    assert certificate.degree == int(signs[closed.hole] == -1)


def test_another_outer_face_or_the_mirror_image_is_refused(body):
    mesh, closed, atlas = body
    elsewhere = certify_atlas(replace(atlas, hole=(closed.hole + 1) % len(mesh.f)), mesh.f)
    assert (elsewhere.degree, elsewhere.flipped.tolist()) == (0, [closed.hole])
    mirrored = certify_atlas(replace(atlas, z=atlas.z.conj(), origin=atlas.origin.conj()), mesh.f)
    assert (mirrored.degree, len(mirrored.flipped)) == (0, len(mesh.f) - 1)


def test_angles_in_charts_are_the_closed_ones(body):
    mesh, closed, atlas = body
    differences = atlas_angle_differences(mesh.v, mesh.f, atlas)
    expected = np.degrees(closed.angles - corner_angles(mesh.v, mesh.f))
    assert np.isnan(differences[closed.hole]).all()
    assert np.abs(np.delete(differences - expected, closed.hole, 0)).max() < 1e-3


def test_numbers_that_are_not_finite_or_do_not_fit_are_named(body):
    mesh, _, atlas = body
    z = atlas.z.copy()
    z[7] = np.inf
    assert certify_atlas(replace(atlas, z=z), mesh.f).not_finite.tolist() == [7]
    chart, parent = atlas.chart.copy(), atlas.parent.copy()
    chart[3], parent[1] = len(parent), 1
    for damaged in (replace(atlas, chart=chart), replace(atlas, parent=parent), replace(atlas, z=z[1:]),
                    replace(atlas, hole=-1)):
        with pytest.raises(MeshError, match="atlas"):
            certify_atlas(damaged, mesh.f)


def test_a_map_brings_its_atlas_if_asked_and_an_archive_keeps_it(tmp_path):
    v, f = random_body(1, depth=90)
    result = spherical_conformal_map(v, f, gauge="centred", atlas=True)
    assert result.atlas.certificate.folding_free
    assert result.stretch > 1
    angles = np.abs(atlas_angle_differences(v, f, result.atlas))
    assert np.nanmean(angles) < 0.8 * np.abs(result.angle_differences()).mean()
    write_map(tmp_path / "map.npz", result)
    read = read_map(tmp_path / "map.npz").atlas
    assert read.hole == result.atlas.hole
    for name in ("chart", "z", "parent", "origin"):
        assert np.array_equal(getattr(read, name), getattr(result.atlas, name))
    assert read.certificate.folding_free
    plain = spherical_conformal_map(v, f, gauge="centred")
    assert plain.atlas is None
    assert any("atlas=True" in note for note in plain.notes)
    assert np.array_equal(plain.sphere, result.sphere)
