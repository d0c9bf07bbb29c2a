"""Write a texture, vertex colours or a scalar map of a mapped surface.

    igl-spheremap export bunny.obj bunny_sphere.obj bunny.glb --show octahedral
    igl-spheremap export bunny.obj bunny_sphere.obj globe.obj --show equirectangular --image earth.png
    igl-spheremap export bunny.obj bunny_sphere.obj bunny_angles.ply --show angles
    igl-spheremap export lh.pial lh.sphere.conformal lh.factor.shape.gii --show factor
    igl-spheremap export lh.pial lh.sphere.conformal lh.factor --show factor
"""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from ....draw.palette import colours
from ....errors import import_optional
from ....io import read_picture, write_mesh, write_scalars, write_textured
from ....shapes.texture import checker_image, texture_atlas
from ....verify.distortion import vertex_maps
from ..failures import UsageError
from ..output import Findings
from ..pair import load_pair
from ..streams import check_outputs

_TEXTURES = ("equirectangular", "octahedral")


def run(args: Namespace) -> None:
    """Make and write."""
    target: str = args.target
    if args.show in _TEXTURES and not target.lower().endswith((".glb", ".obj")):
        raise UsageError(f"--show {args.show} writes .glb or .obj files, not {target}")
    if args.image is not None and args.show not in _TEXTURES:
        raise UsageError(f"--image goes with --show {' or '.join(_TEXTURES)}")
    if args.image is not None and Path(args.image).resolve() == Path(target).with_suffix(".png").resolve():
        raise UsageError(f"{args.image} is where the texture of {target} goes; write another OUT")
    check_outputs(args)
    if args.show in _TEXTURES:
        import_optional("PIL.Image", "a texture", "io")
    image = checker_image() if args.image is None else read_picture(args.image)
    pair = load_pair(args)
    source = pair.source
    found = Findings(source=source.name, sphere=pair.name, target=target, show=args.show)
    args.progress.stage(f"writing {target}")
    if args.show in _TEXTURES:
        # OBJ counts texture coordinates apart from vertices, so that the mesh need not be cut for them.
        cut = not (target.lower().endswith(".obj") and args.show == "equirectangular")
        atlas = texture_atlas(pair.x, source.f, args.show, cut=cut)
        write_textured(target, source.v, source.f, atlas, image, force=args.force)
        vertices, kind = int(atlas.vertex.max()) + 1, "cut along the seam" if cut else "the mesh as it is"
        found.figures |= {"vertices": vertices, "coordinates": len(atlas.uv), "faces": len(atlas.f)}
        outcome = f"{vertices} vertices, {len(atlas.f)} faces, {kind}"
    else:
        values = vertex_maps(source.v, source.f, pair.unit)[args.show]
        if target.lower().endswith(".ply"):
            metadata = {"vertex_properties": {**colours(values), "quality": values}}
            write_mesh(target, source.v, source.f, force=args.force, metadata=metadata)
        else:
            write_scalars(target, {args.show: values}, force=args.force, metadata=source.metadata)
        found.figures |= {"lowest": values.min(), "mean": values.mean(), "highest": values.max()}
        outcome = f"{values.min():.4g} to {values.max():.4g}, mean {values.mean():.4g}"
    found.add("written", f"{target}: {args.show}, {outcome}")
    found.report(args)
