"""`disk` and `flatten`: maps of surfaces with one boundary loop to the plane, and their check."""

import os
from argparse import Namespace
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ....errors import FileError, MeshError, import_optional, naming
from ....io.files import read_mesh
from ....io.patch import read_patch
from ....io.plane_map import is_patch, read_images, write_plane_map
from ....io.scalars import read_landmarks
from ....mesh.arrays import FloatArray, IntArray, mean_position
from ....mesh.check import check_faces
from ....mesh.disk import check_disk
from ....mesh.edges import marked, touching
from ....mesh.measure import face_areas
from ....mesh_repair.polygons import triangulation
from ....mesh_repair.repair_disk import repair_disk
from ....mesh_repair.repair_mesh import RepairedMesh
from ....plane.cuts import carry_cuts
from ....plane.disk_map import balanced_disk_map
from ....plane.flat_map import flatten
from ....plane.plane_map import PlaneMap, given_map, plane_findings
from ....result import findings
from ....result.result import run_findings
from ....result.run import Iterate, Listener
from ....sphere.rows import unit_rows
from ....verify.certificate import Certificate
from ...report import write_plane_report
from ..arguments import repair_of, repair_options
from ..exits import Exit, UsageError, usage
from ..inputs import (
    STREAM,
    InputMap,
    InputMesh,
    load_pair,
    read_any,
    read_data,
    read_pair,
    read_table,
    read_target_sphere,
    sphere_name,
    up_of,
)
from ..output import Findings, check_outputs, check_plots
from ..workflow import as_written, map_and_report


def run_disk(args: Namespace) -> Exit:
    return _map_by(args, balanced_disk_map)


def run_flatten(args: Namespace) -> Exit:
    return _map_by(args, flatten)


def _map_by(args: Namespace, solve: Callable[..., PlaneMap]) -> Exit:
    """Map, write, certify the file, and report."""
    check_outputs(args, surface=not is_patch(args.target) and args.target != STREAM)
    check_plots(args)
    if args.target.lower().endswith(".glb"):
        import_optional("PIL.Image", "a texture", "io")
    source = _load(args)
    shown = args.progress.listener(source.f)

    def show(iterate: Iterate) -> None:
        if iterate.x.shape[1] == 3:
            shown(iterate)

    def solved(listener: Listener) -> PlaneMap:
        with naming(source.name):
            return solve(
                source.v, source.f, caps=source.caps, balance=args.balance, listener=listener
            )

    def write(result: PlaneMap) -> tuple[Certificate, Findings]:
        args.progress.begin(f"writing {args.target}")
        written = write_plane_map(
            args.target, result, force=args.force, rows=source.rows, up=up_of(args, source)
        )
        return written, _findings(source, args, result, written)

    return map_and_report(
        args,
        source,
        solved,
        [show],
        write,
        lambda result: result.plot(os.path.basename(source.name)),
        write_plane_report,
    )


def _findings(
    source: InputMesh, args: Namespace, result: PlaneMap, written: Certificate
) -> Findings:
    found = Findings(
        target=args.target,
        source=source.name,
        repairs=source.repairs,
        vertices=len(source.v),
        faces=len(source.f),
        rim=len(result.rim),
        balance=result.balance,
        status=result.status.name,
    )
    found.add(
        "mesh",
        f"{len(source.v):,} vertices, {len(source.f):,} faces, {len(result.rim):,} on the rim",
    )
    found.extend(run_findings(result))
    found.extend(plane_findings(result))
    said = as_written(result.certificate, written, ".obj or .npz")
    found.add("written", f"{args.target}, {said}")
    found.figures["file"] = {"certificate": findings.certificate_numbers(written)}
    return found


def _load(args: Namespace) -> InputMesh:
    """Read the mesh that the command line names; take the part that --patch names; repair it by the flags given."""
    args.progress.begin(f"reading {args.source}")
    repairs = repair_of(args) is not None
    mesh = read_any(args.source, args.format, lambda path: read_mesh(path, triangulate=repairs))
    source = InputMesh(args.source, mesh.v, mesh.f, mesh.metadata)
    v, f, rows = mesh.v, mesh.f, np.arange(len(mesh.v))
    options = _disk_options(args)
    if args.via is not None:
        options |= {"cut": _carried_cuts(args, source), "keep_largest": True}
    elif args.patch is not None:
        patch = read_patch(args.patch)
        rows = patch.rows
        v, f = patch.part(v, f)
    if not (repairs or args.patch or options):
        return InputMesh(args.source, v, f, rows=rows)
    with naming(args.source), usage("--"):
        # the faces of a patch may touch at vertices, or leave some apart
        disk = repair_disk(v, f, **options)
    if args.via is not None:
        disk = _left_by_cuts(disk, source, args)
    done = triangulation(mesh.triangulated, mesh.concave) + disk.actions
    if done:
        args.progress.write(f"igl-spheremap: repaired {args.source}: {'; '.join(done)}")
    rows = np.where(disk.vertex_source < 0, -1, rows[disk.vertex_source])
    return InputMesh(args.source, disk.v, disk.f, repairs=done, caps=disk.caps, rows=rows)


def _carried_cuts(args: Namespace, source: InputMesh) -> IntArray:
    """The edges of a registered surface that stand for the cuts of its template's patch."""
    if args.cut is not None:
        raise UsageError("--cut: the patch says where --via cuts; leave one of them out")
    with naming(args.source):
        faces = check_faces(source.f, len(source.v))
    x = unit_rows(read_pair(source, args.via).unit)
    there, g = read_target_sphere(args.template, source)
    with naming(args.patch):
        kept, patch_f = read_patch(args.patch).part(unit_rows(there), g)
        return carry_cuts(faces, x, patch_f, kept)


def _left_by_cuts(disk: RepairedMesh, source: InputMesh, args: Namespace) -> RepairedMesh:
    """Report the part beyond the cuts; if each vertex is to come once, leave out the faces along slits, too."""
    v, f, actions, kept = source.v, source.f, disk.actions, disk.face_source
    once = is_patch(args.target)
    while (
        once and (twice := np.bincount(disk.vertex_source + 1, minlength=len(v) + 1)[1:] > 1).any()
    ):
        kept = kept[(kept >= 0) & ~touching(f[kept], twice)]
        disk = repair_disk(v, f[kept], keep_largest=True)
        kept = kept[disk.face_source]
    lost = ~marked(kept[kept >= 0], len(f))
    areas = face_areas(v, f)
    text = (
        f"left out {lost.sum()} faces, {areas[lost].sum() / areas.sum():.1%} of the area, near "
        f"{mean_position(v[f[lost].ravel()], v)}"
    )
    if args.labels is not None:
        text += f": {_shares(args.labels, source, areas * lost)}"
    return replace(disk, actions=(*actions, text))


def _shares(path: str, source: InputMesh, areas: FloatArray) -> str:
    """The labels that lie on areas of faces by their shares, largest first, those of a percent and more."""
    table = read_table(path)
    if table is None:
        raise MeshError(
            f"{path} holds no labels; give an .annot or .label.gii file of this surface"
        )
    corners = read_data(path, source)[source.f, 0].astype(np.int64)
    found = [
        (areas @ (corners == label.key).mean(axis=1) / areas.sum(), label.name) for label in table
    ]
    return ", ".join(f"{share:.0%} {name}" for share, name in sorted(found)[::-1] if share >= 0.01)


def _disk_options(args: Namespace) -> dict[str, Any]:
    """The options of `repair_disk` that flags stand for."""
    if args.cut_handles and args.cut is None:
        raise UsageError(
            "--cut-handles goes with --cut here: give the number of points to cut through"
        )
    options = repair_options(args)
    if args.rim is not None:
        options["rim"] = args.rim
    if isinstance(args.cut, str):
        options["cut"] = read_landmarks(args.cut)
    elif args.cut is not None:
        options["cut"] = args.cut
    return options


def find_plane_map(args: Namespace) -> tuple[InputMesh, FloatArray] | None:
    """If the command line names a surface and its map to the plane, these; else None."""
    name = sphere_name(args)
    if STREAM in (args.source, args.sphere) or repair_of(args) is not None:
        return None
    mesh = read_any(args.source, args.format, read_mesh)
    try:
        images = read_images(name)
    except (MeshError, FileError):
        if is_patch(name):
            raise
        return None  # its faults were found before
    v, f = images.cut(mesh.v, mesh.f, name)
    rows = images.vertex
    if rows is None:
        rows = np.arange(len(mesh.v))
    return InputMesh(args.source, v, f, caps=mesh.caps, rows=rows), images.plane


def load_map(args: Namespace, mirror: bool = False) -> InputMap | tuple[InputMesh, FloatArray]:
    """The map that the command line names: to the sphere, or else to the plane.

    If its file holds the surface itself, as one with texture coordinates does, it is a map to the plane.
    """
    try:
        pair = load_pair(args, mirror)
    except (MeshError, UsageError, FileError):
        plane = find_plane_map(args)
        if plane is None:
            raise
        return plane
    if args.sphere is not None and np.array_equal(pair.x, pair.source.v):
        plane = find_plane_map(args)
        if plane is not None:
            return plane
    return pair


def check_plane_map(args: Namespace, source: InputMesh, p: FloatArray) -> Exit:
    """Certify a map of a disk to the plane, and report its figures."""
    name = sphere_name(args)
    args.progress.begin(f"certifying {name}")
    disk = check_disk(source.v, source.f, caps=source.caps)
    result = given_map(disk, p)
    found = Findings(
        source=args.source, plane=name, vertices=len(disk.v), faces=len(disk.f), rim=len(disk.rim)
    )
    found.add(
        "source",
        f"{args.source}: {len(disk.v)} vertices, {len(disk.f)} faces, {len(disk.rim)} on the rim",
    )
    found.add("plane", name)
    known = plane_findings(result)
    if len(result.certificate.not_finite):
        known = known[-1:]  # the verdict alone
    found.extend(known)
    return found.report(args, result.certificate)
