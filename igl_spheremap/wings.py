"""Calls from the spine to the wings, which it never imports: each is imported when one of its functions is called.

The spine takes arrays, maps them and certifies the maps. Users' other requests are served here.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from .errors import Remedy
    from .maps.sphere_map import SphereMap
    from .mesh.arrays import FloatArray, IntArray
    from .mesh_repair.refusal import Refusal
    from .result.run import Listener


def arrays_of_mesh(
    names: Sequence[str], places: int, args: tuple[Any, ...], options: dict[str, Any]
) -> tuple[tuple[Any, ...], dict[str, Any]]:
    """The arguments of a function with these names, `places` of them positional, with arrays for a mesh object."""
    from .io.objects import arrays_of_mesh

    return arrays_of_mesh(names, places, args, options)


def sphere_and_faces(given: Any) -> tuple[ArrayLike, ArrayLike | None]:
    """The positions and the faces of a mesh object or a file; anything else comes back, without faces."""
    from .io.objects import sphere_and_faces

    return sphere_and_faces(given)


def faces_of(given: Any) -> ArrayLike:
    """The faces of a mesh object or a file; anything else comes back."""
    from .io.objects import faces_of

    return faces_of(given)


def refusal(f: IntArray, n: int, v: FloatArray | None, asked: Remedy) -> Refusal:
    """The sentences that say why faces are no sphere and no disk, and name the repair."""
    from .mesh_repair.refusal import Refusal

    return Refusal(f, n, v, asked)


def refuse_polygons(v: FloatArray, f: ArrayLike) -> None:
    """Refuse faces that are an array of polygons, and name the repair."""
    from .mesh_repair.refusal import refuse_polygons

    refuse_polygons(v, f)


def rebalanced(result: SphereMap, balance: float, listener: Listener | None) -> SphereMap:
    """A map without foldings at another balance."""
    from .balance.rebalance import rebalanced

    return rebalanced(result, balance, listener)


def notebook(result: SphereMap) -> str:
    """A map as notebooks show it."""
    from .draw.sphere_map import notebook

    return notebook(result)


def plot(result: SphereMap) -> Any:
    """The figure of a map's run, its angles and its areas."""
    from .draw.sphere_map import plot

    return plot(result)
