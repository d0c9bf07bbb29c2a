"""`export`: textures, vertex colours and scalar maps of a mapped surface."""

from argparse import Namespace
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ....draw.palette import colours
from ....draw.plot import upright
from ....errors import MeshError, import_optional
from ....io.formats import format_of
from ....io.pictures import read_picture
from ....io.scalars import write_scalars
from ....io.textured import TexturedMesh, read_textured, write_textured
from ....io.write_mesh import write_mesh
from ....mesh.arrays import FloatArray, own_unit
from ....plane.plane_map import unit_square
from ....resampling.texture import (
    SIDE,
    Atlas,
    Projection,
    bake,
    checker_image,
    plane_atlas,
    texture_atlas,
)
from ....verify.distortion import vertex_maps
from ..arguments import refuse_flags
from ..exits import UsageError
from ..inputs import InputMap, InputMesh, sphere_name, up_of
from ..output import Findings, check_outputs
from .plane import load_map

_SCALARS = {
    "factor": "u of the conformal factor e^(2u)",
    "angles": "angle differences in degrees",
}
_TEXTURED = (".glb", ".obj")
_COLOURED = (".ply", ".glb")


def run_export(args: Namespace) -> None:
    target: str = args.target
    _check_export(args)
    check_outputs(args)
    pair = load_map(args)
    if not isinstance(pair, InputMap):
        _export_plane(args, *pair)
        return
    source = pair.source
    found = Findings(
        source=source.name, sphere=pair.name, target=target, show=args.show, texture=args.texture
    )
    args.progress.begin(f"writing {target}")
    up = up_of(args, source)
    if up == "auto":
        up = upright(source.v)
    if args.texture == "carried":
        texture = read_textured(args.source)
        atlas = _own_atlas(texture, source)
        write_textured(
            target, pair.x, source.f, atlas, texture.image, force=args.force, metadata={"up": up}
        )
        outcome = f"SOURCE's coordinates and picture on {pair.name}"
    elif args.show in _SCALARS:
        outcome = f"{_SCALARS[args.show]}, {_export_scalars(args, pair, up, found)}"
    else:
        outcome = _export_texture(args, pair, up, found)
    found.add("written", f"{target}: {outcome}")
    found.report(args)


def _export_texture(args: Namespace, pair: InputMap, up: str, found: Findings) -> str:
    """Write a texture by a projection of the sphere, and name the files."""
    # OBJ counts texture coordinates apart from vertices, so that the mesh need not be cut for them.
    projection: Projection = "octahedral"
    if args.show:
        projection = args.show
    suffix, source = Path(args.target).suffix.lower(), pair.source
    cut = bool(args.texture) or suffix != ".obj" or projection != "equirectangular"
    atlas = texture_atlas(pair.x, source.f, projection=projection, cut=cut)
    write_textured(
        args.target,
        source.v,
        source.f,
        atlas,
        _image(args, source, atlas),
        force=args.force,
        metadata={"up": up},
    )
    vertices = len(atlas.uv)
    if suffix == ".obj":
        vertices = int(atlas.vertex.max()) + 1
    found.figures |= {"vertices": vertices, "coordinates": len(atlas.uv), "faces": len(atlas.f)}
    outcome = f"{projection}, {vertices} vertices, {len(atlas.f)} faces"
    if cut:
        return f"{outcome}, cut along the seam"
    return f"{outcome}, the mesh as it is"


def _export_scalars(args: Namespace, pair: InputMap, up: str, found: Findings) -> str:
    """Write a scalar map, as colours if the format has them, and say its range."""
    source = pair.source
    values = vertex_maps(source.v, source.f, pair.unit)[args.show]
    if args.target.lower().endswith(_COLOURED):
        metadata = {"vertex_properties": {**colours(values), "quality": values}, "up": up}
        write_mesh(args.target, source.v, source.f, force=args.force, metadata=metadata)
    else:
        write_scalars(
            args.target,
            {args.show: values},
            surface=(source.v, source.f),
            force=args.force,
            metadata=source.metadata,
        )
    found.figures |= {"lowest": values.min(), "mean": values.mean(), "highest": values.max()}
    return f"{values.min():.4g} to {values.max():.4g}, mean {values.mean():.4g}"


def _check_export(args: Namespace) -> None:
    """Raise a UsageError for flags that contradict each other or OUT, before anything is read."""
    target: str = args.target
    if args.show in _SCALARS:
        refuse_flags(args, ("--texture", "--image"), f"--show {args.show}")
        if not target.lower().endswith(_COLOURED):
            format_of(target, data=True)
        return
    if args.texture:
        refuse_flags(args, ["--image"], f"--texture {args.texture}")
    if args.texture == "carried":
        refuse_flags(args, ["--show"], "--texture carried")
    if not target.lower().endswith(_TEXTURED):
        raise UsageError(f"a texture goes into .glb or .obj files, not {target}")
    picture, named = args.image, args.image
    if args.texture:
        picture, named = Path(args.source).with_suffix(".png"), args.source
    own = Path(target).with_suffix(".png").resolve()
    if picture is not None and Path(picture).resolve() == own:
        raise UsageError(f"{named} is where the texture of {target} goes; write another OUT")
    import_optional("PIL.Image", "a texture", "io")


def _image(args: Namespace, source: InputMesh, atlas: Atlas) -> NDArray[np.uint8]:
    """The picture of a texture: a given one, SOURCE's own, baked, or a checkerboard."""
    if args.image is not None:
        return read_picture(args.image)
    if args.texture is None:
        return checker_image()
    texture = read_textured(args.source)
    return bake(
        atlas,
        source.f,
        _corners(texture, source),
        texture.image,
        max(SIDE, *texture.image.shape[:2]),
    )


def _corners(texture: TexturedMesh, source: InputMesh) -> FloatArray:
    """Coordinates (m, 3, 2) of the corners of a surface as its file has them; NaN in caps.

    A repair may reverse faces: the order whose corners lie nearer is theirs.
    """
    rows = source.face_source
    if rows is None:
        rows = np.arange(len(source.f))
    if len(rows) and rows.max() >= len(texture.uv):
        raise MeshError(
            f"{source.name} has {len(texture.uv)} textured faces, not {len(source.f)}; give the file alone"
        )
    own, unit = own_unit(source.v)
    here, there, uv = own[source.f], np.ldexp(texture.v[rows], -unit), texture.uv[rows]
    ahead, back = (
        np.linalg.norm(each - here, axis=2).sum(axis=1) for each in (there, there[:, ::-1])
    )
    uv = np.where((ahead > back)[:, None, None], uv[:, ::-1], uv)
    return np.where((rows < 0)[:, None, None], np.nan, uv)


def _own_atlas(texture: TexturedMesh, source: InputMesh) -> Atlas:
    """The atlas of a surface by the coordinates of its file."""
    kept, uv = source.f, _corners(texture, source)
    if source.caps is not None:
        kept, uv = kept[~source.caps], uv[~source.caps]
    corners = np.column_stack((kept.ravel(), uv.reshape(-1, 2)))
    rows, index = np.unique(corners, axis=0, return_inverse=True)
    f = index.reshape(-1, 3).astype(np.int64)
    return plane_atlas(
        np.ascontiguousarray(rows[:, 1:]), f, rows[:, 0].astype(np.int64), len(source.v)
    )


def _export_plane(args: Namespace, source: InputMesh, p: FloatArray) -> None:
    """Write a texture by a map to the plane, whose image in the unit square is its coordinates."""
    if args.show:
        raise UsageError(
            f"{sphere_name(args)} is a map to the plane: its texture coordinates are its own, "
            f"leave out --show {args.show}"
        )
    v, f = source.v, source.f
    assert source.rows is not None
    whole = source.rows.max() + 1
    if whole < len(v):  # cut along a seam
        v, f = np.empty((whole, 3)), source.rows[f]
        v[source.rows] = source.v
    uv, known = unit_square(p)
    args.progress.begin(f"writing {args.target}")
    if args.texture == "carried":
        texture = read_textured(args.source)
        atlas, image, v = (
            _own_atlas(texture, source),
            texture.image,
            np.column_stack((p, np.zeros(len(p)))),
        )
        f = source.f
    else:
        rows = np.arange(len(p))
        if len(v) < len(p):
            rows = source.rows
        atlas = plane_atlas(uv, source.f, rows, len(v))
        image = _image(args, replace(source, v=v, f=f), atlas)
    up = up_of(args, source)
    if args.up is None and args.texture == "carried":
        up = "y"  # a plane image stands as it is drawn
    metadata = {"up": up, "extras": known}
    write_textured(args.target, v, f, atlas, image, force=args.force, metadata=metadata)
    found = Findings(
        source=source.name,
        sphere=args.sphere,
        target=args.target,
        show=args.show,
        texture=args.texture,
    )
    kind = args.texture
    if kind is None:
        kind = "checkerboard"
    found.add(
        "written",
        f"{args.target}: {kind}, {len(atlas.uv)} texture coordinates, {len(atlas.f)} faces",
    )
    found.report(args)
