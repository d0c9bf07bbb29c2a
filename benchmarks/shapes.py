"""Figures of docs/shapes.md: coefficients, rotations and registrations, against exact values.

    python -m benchmarks shapes --meshes FOLDER --fsaverage FOLDER [--only harmonics rotation hemispheres pial warps]

FOLDER of the meshes holds choi_hippocampus.obj and paper_putamen_10002.obj; that of fsaverage5 is
nilearn/datasets/data/fsaverage5 of the package nilearn. Seconds are of the CPU, one thread.
"""

from __future__ import annotations

from pathlib import Path

import igl
import nibabel
import numpy as np
from scipy.spatial.transform import Rotation

import igl_spheremap as ism
from igl_spheremap.features.feature_surface import depth_potential
from igl_spheremap.mesh.measure import vertex_areas
from igl_spheremap.shapes.harmonics.basis import (
    analysis,
    gauss_rows,
    grid_points,
    legendre,
    longitudes,
    synthesis,
)
from igl_spheremap.shapes.harmonics.rotation import best_rotations, rotate, rotation_angle
from igl_spheremap.sphere.rows import unit_rows

from .common import parser, timed

R = Rotation.from_euler("ZYZ", [1.0, 0.7, -2.0]).as_matrix()
#: Dunavant's rule of seven points, exact to degree 5.
NEAR, FAR = (6 - 15**0.5) / 21, (6 + 15**0.5) / 21
CORNERS = np.array(
    [[1 / 3] * 3] + [np.roll([1 - 2 * t, t, t], i) for t in (NEAR, FAR) for i in range(3)]
)
SHARES = np.array([0.225] + [(155 - 15**0.5) / 1200] * 3 + [(155 + 15**0.5) / 1200] * 3)


class Data:
    """Meshes, and maps that are made once."""

    def __init__(self, meshes: Path, fsaverage: Path) -> None:
        self._meshes, self._fsaverage, self._maps = meshes, fsaverage, {}

    def over_fsaverage(self, name):
        """Data over the vertices of fsaverage5."""
        return np.asarray(nibabel.load(self._fsaverage / f"{name}.gii.gz").darrays[0].data, float)

    def mesh(self, name):
        """A sample, a file, or a surface of fsaverage5, the right ones mirrored."""
        if name in ism.samples.names():
            return ism.samples.make(name)
        if (path := self._meshes / f"{name}.obj").exists():
            return tuple(ism.read_mesh(path))
        v, f = (
            np.asarray(each.data)
            for each in nibabel.load(self._fsaverage / f"{name}.gii.gz").darrays
        )
        v, f = v.astype(float), f.astype(np.int64)
        return (
            (v * [-1, 1, 1], np.ascontiguousarray(f[:, ::-1])) if name.endswith("right") else (v, f)
        )

    def map(self, name, balance=1.0):
        """Its map, area-preserving by default."""
        if (name, balance) not in self._maps:
            self._maps[name, balance] = ism.balanced_spherical_map(
                *self.mesh(name), balance=balance
            )
        return self._maps[name, balance]


def degrees(x, y):
    """Angles between unit rows."""
    return np.degrees(2 * np.arcsin(np.minimum(1, np.linalg.norm(x - y, axis=1) / 2)))


def mean(values, weights):
    return weights @ values / weights.sum()


def correlation(p, q, w):
    p, q = p - mean(p, w), q - mean(q, w)
    return w @ (p * q) / np.sqrt((w @ p**2) * (w @ q**2))


def curvature_of(result):
    """The depth potential of a width that leaves little but curvature."""
    return depth_potential(result.vertices, result.faces, ell=0.05)


def exact_coefficients(result, degree):
    """Integrals over the spherical triangles of the piecewise linear positions, faces split until they are small."""
    corners, values = result.sphere[result.faces], result.vertices[result.faces]
    small = []
    while len(corners):
        edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
        large = edges > 3 / degree * np.linalg.norm(corners.mean(axis=1), axis=1)
        small.append((corners[~large], values[~large]))
        corners, values = (quartered(each[large]) for each in (corners, values))
    corners, values = (np.concatenate(each) for each in zip(*small, strict=True))
    y, g = CORNERS @ corners, CORNERS @ values
    r = np.linalg.norm(y, axis=2)
    g *= (np.linalg.det(corners)[:, None] * SHARES / (2 * r**3))[:, :, None]
    return projected(unit_rows(y.reshape(-1, 3)), g.reshape(-1, 3), degree)


def quartered(triangles):
    a, b, c = (triangles[:, k] for k in range(3))
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    return np.concatenate(
        [np.stack(each, axis=1) for each in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    )


def projected(x, g, degree):
    """Sums of g Y_lm(x) over the points."""
    c = np.zeros(((degree + 1) ** 2, g.shape[1]))
    for start in range(0, len(x), 4096):
        here, data = x[start : start + 4096], g[start : start + 4096]
        s = np.hypot(here[:, 0], here[:, 1])
        turn = (here[:, 0] + 1j * here[:, 1]) / np.maximum(s, np.finfo(float).tiny)
        turn = np.broadcast_to(turn, (degree, len(here)))
        waves = np.sqrt(2) * np.cumprod(turn, axis=0)
        for ell, P in enumerate(legendre(degree, here[:, 2].copy(), s)):
            middle, Y = ell * ell + ell, P[1:] * waves[:ell]
            c[middle] += P[0] @ data
            c[middle + 1 : middle + ell + 1] += Y.real @ data
            c[middle - ell : middle] += (Y.imag @ data)[::-1]
    return c


def harmonics(data):
    """Round trips, reconstructions, and coefficients against exact integrals."""
    for degree in (50, 200):
        c = np.random.default_rng(degree).normal(size=((degree + 1) ** 2, 3))
        z, w = gauss_rows(degree + 1)
        values = synthesis(c, grid_points(z, longitudes(2 * degree + 2)).reshape(-1, 3))
        off = np.abs(analysis(values.reshape(degree + 1, -1, 3), z, w, degree) - c).max()
        print(f"round trip at degree {degree}: {off:.1e}")
    for name in ("choi_hippocampus", "paper_putamen_10002", "dino", "brain", "white_left"):
        for balance in (0.0, 1.0):
            result = data.map(name, balance)
            shape, seconds = timed(lambda: ism.shapes.spherical_harmonics(result))  # noqa: B023
            line = f"{name}, balance {balance:g}: {shape.error()[15]:.3f} percent at degree 15, {seconds:.2f} s"
            if name != "paper_putamen_10002":
                c = ism.shapes.spherical_harmonics(result, degree=50).coefficients
                exact = exact_coefficients(result, 50)
                off = np.linalg.norm((c - exact)[1:]) / np.linalg.norm(exact[1:])
                line += f"; degree 50 off the exact integrals by {off:.1e}"
            print(line, flush=True)
    v, f = ism.samples.make("brain", n_vertices=41_000)
    result = ism.spherical_conformal_map(v, f)
    for degree in (15, 50):
        seconds = timed(lambda: ism.shapes.spherical_harmonics(result, degree=degree))[1]  # noqa: B023
        print(f"{len(v)} vertices, degree {degree}: {seconds:.2f} s", flush=True)


def rotation(data):
    """Planted rotations: of coefficients, and of copies with 60 percent of the faces, mapped anew."""
    rng = np.random.default_rng(0)
    c = rng.normal(size=(32**2, 2))
    best_rotations(c, c, 32)
    found, seconds = timed(lambda: best_rotations(rotate(c, R), c, 32))
    print(
        f"planted rotation, B = 32: {np.radians(rotation_angle(found[0].rotation @ R.T)):.1e} rad, {seconds:.2f} s"
    )
    for name in ("dino", "white_left"):
        target, copy = (
            data.map(name, 0.0),
            ism.spherical_conformal_map(*decimated(*data.mesh(name))),
        )
        curvature = curvature_of(copy), curvature_of(target)
        off = []
        for _ in range(3):
            Q = Rotation.random(random_state=rng).as_matrix()
            turned = ism.sphere_map(copy.vertices, copy.faces, copy.sphere @ Q.T)
            found = ism.shapes.register(turned, target, features=curvature, stages=["rotation"])
            off.append(rotation_angle(found.rotation @ Q))
        print(f"copy of {name}: {max(off):.3f} degrees", flush=True)


def decimated(v, f):
    """60 percent of the faces."""
    return tuple(
        np.asarray(each) for each in igl.qslim(v, f, int(0.6 * len(f))) if np.ndim(each) == 2
    )


def hemispheres(data):
    """The mirrored right white surface on the left one by sulc; curvature and thickness are not used."""
    source, target = data.map("white_right"), data.map("white_left")
    sulc = data.over_fsaverage("sulc_right"), data.over_fsaverage("sulc_left")
    ism.shapes.register(source, target, features=sulc, stages=["rotation"])
    result, seconds = timed(lambda: ism.shapes.register(source, target, features=sulc))
    for stage in result.stages:
        print(f"{stage.name}: correlation {stage.correlation[0]:.4f}, |log J| {stage.strain:.3f}")
    areas = vertex_areas(source.vertices, source.faces)
    for name in ("curv", "thick"):
        right, left = data.over_fsaverage(f"{name}_right"), data.over_fsaverage(f"{name}_left")
        pairs = [
            correlation(right, ism.transfer(target, left, x), areas) for x in (source, result.map)
        ]
        print(f"{name}: {pairs[0]:.3f} before, {pairs[1]:.3f} after")
    print(f"{result.map.certificate}; {seconds:.2f} s", flush=True)


def pial(data):
    """The pial surface on the white one, whose vertices are the same ones."""
    for side in ("left", "right"):
        source, target = data.map(f"pial_{side}"), data.map(f"white_{side}")
        areas = vertex_areas(source.vertices, source.faces)
        result, seconds = timed(lambda: ism.shapes.register(source, target))  # noqa: B023
        before, after = (
            mean(degrees(x, target.sphere), areas) for x in (source.sphere, result.map.sphere)
        )
        print(
            f"pial {side}: {before:.2f} -> {after:.3f} degrees, {seconds:.2f} s; {result.map.certificate}"
        )


def warps(data):
    """Planted smooth warps of a copy with 60 percent of the faces, by curvature."""
    target = data.map("white_left")
    copy = ism.balanced_spherical_map(*decimated(target.vertices, target.faces), balance=1.0)
    _, faces, nearest = igl.point_mesh_squared_distance(
        copy.vertices, target.vertices, target.faces
    )
    corners = target.faces[faces]
    triangle = (np.ascontiguousarray(target.vertices[corners[:, k]]) for k in range(3))
    weights = igl.barycentric_coordinates(nearest, *triangle)
    truth = unit_rows(np.einsum("ij,ijk->ik", weights, target.sphere[corners]))
    areas = vertex_areas(copy.vertices, copy.faces)
    for size in (0.12, 0.25):
        x = warped(copy.sphere, size) @ R.T
        if not ism.certify(x, copy.faces).folding_free:
            x = ism.repair_foldings(copy.vertices, copy.faces, x).sphere
        source = ism.sphere_map(copy.vertices, copy.faces, x)
        curvature = curvature_of(source), curvature_of(target)
        rigid = ism.shapes.register(
            source, target, features=curvature, stages=["rotation", "moebius"]
        )
        result, seconds = timed(lambda: ism.shapes.register(source, target, features=curvature))  # noqa: B023
        start, middle, end = (
            mean(degrees(y, truth), areas) for y in (x, rigid.map.sphere, result.map.sphere)
        )
        print(
            f"warp of {np.degrees(size):.0f} degrees: {start:.1f}, Moebius {middle:.2f}, end {end:.3f} degrees, "
            f"{result.map.certificate}, {seconds:.2f} s",
            flush=True,
        )


def turning(c):
    """Coefficients (3, (L + 1)^2, k) of x cross grad f: how f changes as x turns about each axis."""
    h = 1e-6
    turns = (Rotation.from_rotvec(h * axis).as_matrix() for axis in np.eye(3))
    return np.stack([(rotate(c, R.T) - rotate(c, R)) / (2 * h) for R in turns])


def warped(x, size, steps=20):
    """The flow of a random tangent field of degree up to 4, `size` radians rms."""
    c = np.random.default_rng(3).normal(size=(25, 2))
    c[:4] = 0
    c[4:] /= np.repeat([6, 12, 20], [5, 7, 9])[:, None]
    turns = turning(c)  # coefficients of x cross the gradient
    for _ in range(steps):
        first, second = (synthesis(turns[:, :, k].T, x) for k in range(2))
        field = second - np.cross(x, first)
        x = unit_rows(x + size / steps * field / np.sqrt((field**2).sum(axis=1).mean()))
    return x


def main(argv: list[str]) -> None:
    """Print the figures."""
    parts = {part.__name__: part for part in (harmonics, rotation, hemispheres, pial, warps)}
    arguments = parser(__doc__)
    arguments.add_argument("--meshes", type=Path, required=True)
    arguments.add_argument("--fsaverage", type=Path, required=True)
    arguments.add_argument("--only", nargs="+", choices=parts, default=list(parts))
    args = arguments.parse_args(argv)
    data = Data(args.meshes, args.fsaverage)
    for name in args.only:
        parts[name](data)
