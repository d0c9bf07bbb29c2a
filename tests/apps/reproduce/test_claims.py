"""Tables of the text's claims: pages that are whole, and what they predict against what is counted."""

from itertools import islice

import numpy as np
import pytest
from triangulations import icosphere

import igl_spheremap as ism
from igl_spheremap.apps.reproduce import claims, needs, runs, surfaces
from igl_spheremap.apps.reproduce.claims import in_a_row, predict
from igl_spheremap.apps.reproduce.items import reproduce
from igl_spheremap.apps.reproduce.surfaces import COUNTERPARTS, Counterpart, PaperSurface
from igl_spheremap.errors import NotConverged
from igl_spheremap.mesh.measure import vertex_areas
from igl_spheremap.sphere.rows import tangent, unit_rows


@pytest.fixture
def small(monkeypatch):
    """Every surface of the paper stood for by a small spheroid of its own."""
    tiny = {name: Counterpart("", "", f"spheroid:n_vertices={200 + 4 * k}", "") for k, name in enumerate(COUNTERPARTS)}
    monkeypatch.setattr(surfaces, "COUNTERPARTS", tiny)


def rows(out, name):
    (path,) = reproduce([name], out, max_iterations=60)
    table = [line for line in path.read_text(encoding="utf-8").splitlines() if line[:1] == "|"]
    head, _, *body = [[cell.strip() for cell in line.strip("|").split("|")] for line in table]
    assert {len(row) for row in body} == {len(head)}
    return [dict(zip(head, row, strict=True)) for row in body]


def test_maps_through_the_plane_stand_beside_the_papers(small, tmp_path, monkeypatch):
    monkeypatch.setattr(claims, "_PUNCTURES", 3)
    table = rows(tmp_path, "table4")
    assert len(table) == 3 * 7
    for plane in ("[11]", "[12]"):
        best, worst = (float(next(row for row in table if row["method"].startswith(f"{plane}, {which}"))["mean angle"])
                       for which in ("best", "worst"))
        assert best <= worst
    assert [row["folded faces"] for row in table if row["method"] == "default"] == ["0"] * 3


def test_a_puncture_without_a_map_is_counted(small, tmp_path, monkeypatch):
    real, calls = runs.spherical_conformal_map, []

    def fails(v, f, *, method, **options):
        calls.append(method)
        if isinstance(method, ism.Stereographic) and len(calls) % 3 == 1:
            raise NotConverged("no way")
        return real(v, f, method=method, **options)

    monkeypatch.setattr(runs, "spherical_conformal_map", fails)
    monkeypatch.setattr(claims, "_PUNCTURES", 3)
    assert rows(tmp_path, "table4")[0]["method"] == "[11], best of 3, no map for 1"


def test_long_bodies_need_the_weights(small, tmp_path, monkeypatch):
    """The second eigenfunction of a long body is a wave along it, not across."""
    bodies = [PaperSurface(f"{aspect}", *ism.samples.make("spheroid", n_vertices=500, aspect=aspect), "", "")
              for aspect in (1.2, 3)]
    for module in (claims, needs):
        monkeypatch.setattr(module, "all_surfaces", lambda folder: bodies)
    short, long = rows(tmp_path, "eigenfunctions")
    assert short["standard eigenfunctions"] == "0"
    assert long["standard eigenfunctions"].endswith("(0.5)")
    for name in ("weighted eigenfunctions", "default map"):
        assert short[name] == long[name] == "0"


def test_every_sample_and_every_closed_mesh_is_a_surface(tmp_path, monkeypatch):
    v, f = ism.samples.sphere(42)
    monkeypatch.setattr(surfaces.samples, "make", lambda name: (v, f))
    ism.write_mesh(tmp_path / "closed.obj", v, f)
    ism.write_mesh(tmp_path / "open.obj", v, f[1:])
    found = [surface.name for surface in surfaces.all_surfaces(tmp_path)]
    assert found == [*ism.samples.names(), "closed"]


def test_boosts_lower_the_energy_of_a_mesh(small, tmp_path):
    for row in rows(tmp_path, "boosts"):
        energies = [float(cell) for name, cell in row.items() if name.startswith("c =")]
        assert 12 < energies[0] < 4 * np.pi
        assert (np.diff(energies) < 0).all()


def test_projections_are_counted_from_both_starts(small, tmp_path, monkeypatch):
    monkeypatch.setattr(claims, "_LIMIT", 30)
    monkeypatch.setattr(claims, "TABLE_3", claims.TABLE_3[1:3])
    table = rows(tmp_path, "projections")
    assert [row["start"] for row in table] == ["Gauss map", "Algorithm 1"] * 2
    for row in table:
        assert 1 <= int(row["corrected"]) <= int(row["counted"]) <= int(row["predicted"])
        assert row["folded faces left: counted, corrected"] == "0, 0"


def moved(field):
    """A fine sphere moved by a field, and how far, root of the integral, a map of it is from the sphere."""
    v, f = icosphere(4)
    areas = vertex_areas(v, f)
    x = unit_rows(v + 0.05 * tangent(v, field(*v.T)))
    return ism.check_mesh(v, f), x, lambda y: np.sqrt(areas @ ((y - v) ** 2).sum(axis=1))


def degree_2(x, y, z):
    return np.column_stack((x, -y, 0 * z))


def degree_3(x, y, z):
    return np.column_stack((x**2 - y**2, -2 * x * y, 0 * z))


@pytest.mark.parametrize("field", [degree_2, degree_3])
def test_the_number_of_projections_is_predicted(field):
    mesh, x, distance = moved(field)
    first, *others = islice(in_a_row(mesh, x), 25)
    counted = next(k for k, step in enumerate([first, *others]) if distance(step.x) < 0.01)
    assert counted > 2
    assert abs(predict(first) - counted) <= 1


def test_corrected_projections_need_a_third():
    mesh, x, distance = moved(degree_2)
    plain, corrected = (
        next(k + 1 for k, step in enumerate(in_a_row(mesh, x, corrected)) if distance(step.x) < 0.01)
        for corrected in (False, True)
    )
    assert corrected <= plain / 3
