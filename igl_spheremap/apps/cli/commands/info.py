"""`info`, `samples` and `completion`: what a mesh is, which shapes the package makes, and help for the shell."""

import inspect
from argparse import Namespace
from dataclasses import asdict

from .... import samples
from ....errors import import_optional
from ....mesh.check import check_mesh
from ....mesh.quality import MeshQuality, mesh_quality
from ....operators.laplacian import build_operators
from ..inputs import load_source
from ..output import Findings, check_outputs
from ..parser import build_parser


def run_info(args: Namespace) -> None:
    """Measure a mesh: size, quality of its triangles, and which weights its Laplacian can have.

    igl-spheremap info sample:octopus
    igl-spheremap info lh.pial --json -
    """
    check_outputs(args)
    source = load_source(args)
    args.progress.stage(f"measuring {source.name}")
    mesh = check_mesh(source.v, source.f)
    quality = mesh_quality(mesh)
    operators = build_operators(mesh)
    found = Findings(genus=0, components=1, weights=operators.weights, notes=operators.notes, **asdict(quality))
    found.source(source)
    _describe(found, quality, len(mesh.f) * 3 // 2)
    found.report(args)


def _describe(found: Findings, quality: MeshQuality, edges: int) -> None:
    """The summary of a mesh's quality."""
    found.add("topology", "closed, oriented, connected, genus 0: it can be mapped")
    found.add(
        "size",
        f"{' x '.join(f'{side:.4g}' for side in quality.extent)}, area {quality.area:.4g}, "
        f"volume {abs(quality.volume):.4g}{' (oriented inwards)' * (quality.volume < 0)}",
    )
    found.add(
        "edges",
        f"{edges}, {quality.shortest_edge:.3g} to {quality.longest_edge:.3g} long, mean {quality.mean_edge:.3g}; "
        f"at most {quality.largest_valence} at a vertex",
        edges=edges,
    )
    found.add(
        "angles",
        f"{quality.smallest_angle:.3g} to {quality.largest_angle:.4g} degrees; "
        f"{quality.slivers} slivers below 1 degree, {quality.zero_area_faces} faces of zero area, "
        f"{quality.coincident_vertices} coincident vertices",
    )
    found.add("weights", f"{quality.non_delaunay_edges} of {edges} edges are not Delaunay: negative weights there")


def run_samples(args: Namespace) -> None:
    """List the shapes that the package makes itself.

    igl-spheremap samples
    """
    check_outputs(args)
    found = Findings()
    for name in samples.names():
        shape = getattr(samples, name)
        line = (inspect.getdoc(shape) or "").partition("\n")[0]
        parameters = {key: entry.default for key, entry in inspect.signature(shape).parameters.items()}
        listed = ", ".join(f"{key}={value}" for key, value in parameters.items())
        found.add(name, f"{line} ({listed})", **{name: {"is": line, "parameters": parameters}})
    found.report(args)


def run_completion(args: Namespace) -> None:
    """Print a script that completes command lines in a shell.

    igl-spheremap completion bash > ~/.local/share/bash-completion/completions/igl-spheremap
    """
    shtab = import_optional("shtab", "shell completion", "completion")
    print(shtab.complete(build_parser(), shell=args.shell))
