"""A group in files: all of it in an archive, the mean surface in the formats of other programs, members in a table."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import MeshError
from ...gate import PathLike, gate
from ...io import npz
from ...io.reading import reading
from ...io.replacing import make_folder
from ...io.scalars import write_scalars
from ...io.tables import write_cells
from ...io.write_mesh import write_mesh
from ...io.written_map import write_map
from ...mesh.arrays import FloatArray, IntArray
from .group import Group, Member

#: The archive in a group's folder.
ARCHIVE = "group.npz"
#: Fields of a group that are arrays, and those that are lists.
_ARRAYS = (
    "vertices", "faces", "sphere", "shapes", "modes", "variances", "scores", "areas", "spread", "features",
)  # fmt: skip
_LISTS = ("changes", "feature_names", "notes")
#: Facts of each member.
FIGURES = ("correlation", "size", "distance")


@gate
def write_group(folder: PathLike, group: Group, *, force: bool = False) -> None:
    """Write a group into a folder, which is made if it is missing.

    ``group.npz`` holds all arrays and the members' records, which `read_group` reads. ``mean.ply``, ``mean.vtk`` and,
    with nibabel, ``mean.surf.gii`` hold the mean surface with areas, spread and features at the vertices; GIFTI keeps
    these in ``mean.shape.gii``, VTK the modes, too. ``members.tsv`` has the members' figures and scores, and left-out
    sources; the folder ``members`` each member's map in the template's frame, for `read_map`.

    Parameters
    ----------
    folder : str or path-like
        Target folder.
    group : Group
        The group.
    force : bool
        Replace existing files.

    Raises
    ------
    FileError
        If a file exists and `force` is not set, or it can't be written.

    Examples
    --------
    >>> import tempfile
    >>> import igl_spheremap as ism
    >>> v, f = ism.samples.make("pear", n_vertices=100)
    >>> group = ism.shapes.template([(v * [1.3 + 0.1 * k, 1, 1], f) for k in range(3)], target="ico:1")
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     ism.shapes.write_group(folder, group)
    ...     again = ism.shapes.read_group(folder)
    >>> bool((again.scores == group.scores).all())
    True
    """
    out = make_folder(Path(folder) / "members", follow=False).parent
    arrays = {name: getattr(group, name) for name in _ARRAYS}
    arrays |= {
        f"member_{name}": np.array([getattr(member, name) for member in group.members])
        for name in FIGURES
    }
    known = {
        "names": [member.name for member in group.members],
        "left_out": dict(group.left_out),
        "rigid": group.rigid,
        "balance": group.balance,
        "doubts": [member.doubts for member in group.members],
    }
    known |= {name: getattr(group, name) for name in _LISTS}
    npz.save_arrays(out / ARCHIVE, arrays | {"json": json.dumps(known)}, force)
    over = {"area": group.areas, "spread": group.spread}
    names = group.feature_names
    if not names:
        names = tuple(f"feature_{k + 1}" for k in range(group.features.shape[2]))
    over |= dict(zip(names, group.feature_mean.T, strict=True))
    over |= dict(zip([f"{name}_sd" for name in names], group.feature_sd.T, strict=True))
    moves = {
        f"mode_{k}": mode * np.sqrt(variance)
        for k, (mode, variance) in enumerate(zip(group.modes, group.variances, strict=True), 1)
    }
    write_mean(out, group.vertices, group.faces, over, moves, force=force)
    write_cells(out / "members.tsv", member_rows(group), force=force)
    for member, name in zip(
        group.members, file_names([member.name for member in group.members]), strict=True
    ):
        if member.map is not None:
            write_map(out / "members" / f"{name}.npz", member.map, force=force)


def write_mean(
    out: Path,
    v: FloatArray,
    f: IntArray,
    over: Mapping[str, FloatArray],
    moves: Mapping[str, FloatArray],
    *,
    force: bool,
) -> None:
    """Write a mean surface with data over its vertices, and fields that VTK alone takes, in the formats of others."""
    for ending in (".ply", ".vtk"):
        write_mesh(
            out / f"mean{ending}",
            v,
            f,
            force=force,
            metadata={"vertex_properties": over, "point_data": {**over, **moves}},
        )
    if find_spec("nibabel"):
        write_mesh(out / "mean.surf.gii", v, f, force=force)
        write_scalars(out / "mean.shape.gii", over, surface=(v, f), force=force)


@gate
def read_group(folder: PathLike) -> Group:
    """Read a group from its folder, or from its archive.

    Parameters
    ----------
    folder : str or path-like
        Folder or archive by `write_group` or ``igl-spheremap template``.

    Returns
    -------
    Group
        Equal to the one that was written, except that its members have no maps: `read_map` reads them one by one.

    Raises
    ------
    FileError
        If the archive can't be read.
    MeshError
        If it holds no group.
    """
    path = Path(folder)
    if path.is_dir():
        path /= ARCHIVE
    with reading(path):
        arrays = npz.read_arrays(path)
        if not {*_ARRAYS, "json", *(f"member_{name}" for name in FIGURES)} <= arrays.keys():
            raise MeshError(
                "the archive holds no group; give one that `igl-spheremap template` wrote"
            )
        known = json.loads(str(arrays["json"]))
        figures = (arrays[f"member_{name}"].tolist() for name in FIGURES)
        rows = zip(known["names"], *figures, map(tuple, known["doubts"]), strict=True)
        members = tuple(Member(str(name), None, *others) for name, *others in rows)
        lists: dict[str, Any] = {name: tuple(known[name]) for name in _LISTS}
        fields: dict[str, Any] = {name: arrays[name] for name in _ARRAYS}
        return Group(
            **fields,
            members=members,
            **lists,
            left_out=known["left_out"],
            rigid=known["rigid"],
            balance=known["balance"],
        )


def member_rows(group: Group) -> Iterator[Sequence[object]]:
    """The table of members, and of left-out sources."""
    yield (
        "member",
        "status",
        "reason",
        "doubts",
        *FIGURES,
        *(f"mode_{k + 1}" for k in range(len(group.modes))),
    )
    for member, scores in zip(group.members, group.scores, strict=True):
        yield member_row(member, scores)
    for name, reason in group.left_out.items():
        yield name, "left out", reason, *[""] * (1 + len(FIGURES) + len(group.modes))


def member_row(member: Member, scores: FloatArray) -> tuple[object, ...]:
    """A row of the table."""
    figures = (getattr(member, name) for name in FIGURES)
    return member.name, "member", "", "; ".join(member.doubts), *figures, *scores.tolist()


def file_names(names: Sequence[str]) -> list[str]:
    """A file's name for each member: that of its source without folder and suffix; if two agree, with a number.

    >>> file_names(["a/one.ply", "b/one.ply", "b/two.ply"])
    ['one_1', 'one_2', 'two']
    """
    return distinct([Path(name).stem for name in names])


def distinct(stems: Sequence[str]) -> list[str]:
    """Names that differ even on disks that ignore case: equal ones are numbered."""
    # of which a disk may make no difference
    several, taken = Counter(stem.lower() for stem in stems), set[str]()
    found = []
    for stem in stems:
        name, k = stem, 0
        while name.lower() in taken or several[name.lower()] > 1:
            k += 1
            name = f"{stem}_{k}"
        taken.add(name.lower())
        found.append(name)
    return found
