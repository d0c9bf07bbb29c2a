"""File names of a hemisphere by the conventions of BIDS, FreeSurfer and HCP: their words, and names of new files."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import FileError, Remedy
from .formats import Convention

if TYPE_CHECKING:  # help and wrong lines load no numpy
    from ..gate import PathLike

LEFT, RIGHT = "CortexLeft", "CortexRight"
#: The structures by the letters that stand for them.
SIDES = {"L": LEFT, "R": RIGHT}
#: Words of names for kinds of surfaces, by FreeSurfer, pycortex, BrainSuite and CIVET, HCP and CAT.
_KINDS = {word: kind for kind, words in (
    ("white", ("white", "smoothwm", "wm", "inner")), ("pial", ("pial", "pia", "gray")),
    ("midthickness", ("midthickness", "graymid", "central", "mid")),
) for word in words}  # fmt: skip
#: The word of the pial surface beside a white one, by the word of that one.
_PARTNERS = {
    "white": ("pial", "gray"),
    "smoothwm": ("pial",),
    "wm": ("pia", "pial"),
    "inner": ("pial",),
}
_STRUCTURE = re.compile(r"(?:^|[._-])(lh|rh|hemi-[LR])(?:[._-]|$)|\.([LR])\.|_(left|right)\.gii")
_WORD = re.compile(r"[A-Za-z0-9]+")
_BIDS = re.compile(r"(sub-[A-Za-z0-9]+(?:_[a-z]+-[A-Za-z0-9]+)*?)_hemi-[LR]_")
_HCP = re.compile(r"([^.]+)\.[LR]\.")
_SIDE = re.compile(r"^[lr]h\.|_?hemi-[LR](?=_|\.|$)|(?<=\.)[LR]\.")
_SEGMENTATION = re.compile(r"(?:atlas|seg)-([A-Za-z0-9]+)")
_ENDS = re.compile(r"(\.(annot|gii|gz|label|npz|native|dlabel|32k_fs_LR|164k_fs_LR))+$|_dseg(?=\.)")


@dataclass(frozen=True)
class Hemisphere:
    """Facts in the name of a surface's file.

    Attributes
    ----------
    subject : str
        sub-01 of sub-01_hemi-L_white.surf.gii, bert of bert/surf/lh.white, 100307 of 100307.L.white.native.surf.gii.
    entities : str
        Beginning of names of BIDS: sub-01, and all before the hemisphere.
    structure : str
        "CortexLeft" or "CortexRight".
    kind : str
        "white", "pial" or "midthickness"; if the name says none of them, "surface".
    """

    subject: str
    entities: str
    structure: str
    kind: str

    @property
    def side(self) -> str:
        """L or R."""
        return _letter(self.structure)

    @property
    def hemi(self) -> str:
        """lh or rh."""
        return f"{self.side.lower()}h"

    @property
    def other(self) -> str:
        """The structure of the other side."""
        return other_side(self.structure)


def structure_of(path: PathLike) -> dict[str, str]:
    """The hemisphere that a file's name has by the convention of FreeSurfer, BIDS, HCP or nilearn, as metadata.

    >>> structure_of("/data/lh.pial"), structure_of("sub-01_hemi-R_pial.surf.gii"), structure_of("alhambra.obj")
    ({'structure': 'CortexLeft'}, {'structure': 'CortexRight'}, {})
    >>> structure_of("100307.L.white.native.surf.gii"), structure_of("white_right.gii.gz")
    ({'structure': 'CortexLeft'}, {'structure': 'CortexRight'})
    """
    found = _STRUCTURE.search(Path(path).name)
    if found is None:
        return {}
    if {"lh", "hemi-L", "L", "left"} & {*found.groups()}:
        return {"structure": LEFT}
    return {"structure": RIGHT}


def other_side(structure: str) -> str:
    """The structure on the other side; one that has no side is returned as it is.

    >>> other_side("CortexLeft"), other_side("Cerebellum")
    ('CortexRight', 'Cerebellum')
    """
    return {LEFT: RIGHT, RIGHT: LEFT}.get(structure, structure)


def _letter(structure: str) -> str:
    if structure == LEFT:
        return "L"
    return "R"


def _entity(name: str) -> str:
    """A name as that of an entity of BIDS, which has no other letters than these.

    >>> _entity("HCP_MMP1"), _entity("-")
    ('HCPMMP1', 'x')
    """
    letters = re.sub(r"[^A-Za-z0-9]", "", name)
    if not letters:
        return "x"
    return letters


def hemisphere_of(path: PathLike, structure: str | None = None) -> Hemisphere:
    """Facts in the name of a surface; the side may be known from elsewhere, as from the file.

    >>> hemisphere_of("sub-01_ses-2_hemi-L_white.surf.gii")
    Hemisphere(subject='sub-01', entities='sub-01_ses-2', structure='CortexLeft', kind='white')
    >>> hemisphere_of("subjects/bert-2/surf/rh.pial").entities, hemisphere_of("100307.R.white.native.surf.gii").subject
    ('sub-bert2', '100307')
    """
    path = Path(path)
    structure = structure_of(path.name).get("structure", structure)
    if structure not in (LEFT, RIGHT):
        raise FileError(
            f"{path} does not say which hemisphere it is: name it lh.NAME, rh.NAME or NAME_hemi-L, or give "
            f"{Remedy(options={'hemisphere': None})} L or R"
        )
    kind = next((_KINDS[word] for word in _WORD.findall(path.name) if word in _KINDS), "surface")
    if found := _BIDS.match(path.name):
        entities = found[1]
        return Hemisphere(entities.partition("_")[0], entities, structure, kind)
    if path.resolve().parent.name == "surf":
        subject = path.resolve().parts[-3]
    elif hcp := _HCP.match(path.name):
        subject = hcp[1]
    else:
        subject = _rest(path.name)
    return Hemisphere(subject, f"sub-{_entity(subject.removeprefix('sub-'))}", structure, kind)


def _rest(name: str) -> str:
    """Rest of a name without side, kind and suffixes, as T1Prep's lh.central.NAME.gii.

    >>> _rest("lh.central.bert.gii"), _rest("white.surf.gii")
    ('bert', 'x')
    """
    others = r"|lh|rh|left|right|surf|gii|gz|obj|ply|stl|vtk|off"
    words = [
        word
        for word in re.split(r"[._]", name)
        if word not in _KINDS and not re.fullmatch(others, word)
    ]
    if not words:
        return "x"
    return "_".join(words)


def partner_of(path: PathLike) -> str | None:
    """The file of the pial surface beside a white one, of the same name but for that word; None if there is none."""
    path = Path(path)
    for white, words in _PARTNERS.items():
        for pial in words:
            name, count = re.subn(rf"(?<![A-Za-z]){white}(?![A-Za-z])", pial, path.name)
            if count == 1 and path.with_name(name).is_file():
                return str(path.with_name(name))
    return None


def atlas_of(path: PathLike) -> str:
    """The name of an atlas, read from the name of its file.

    >>> atlas_of("lh.aparc_HCP_MMP1.annot"), atlas_of("tpl-fsLR_hemi-L_atlas-Glasser_dseg.label.gii")
    ('aparc_HCP_MMP1', 'Glasser')
    >>> atlas_of("fsaverage.L.BA.32k_fs_LR.label.gii")
    'fsaverage.BA'
    """
    name = Path(path).name
    if found := _SEGMENTATION.search(name):
        return found[1]
    if rest := _SIDE.sub("", _ENDS.sub("", name)):
        return rest
    return "labels"


#: Ends of names of files by their contents, for BIDS, FreeSurfer and HCP; words in braces are those of `Names.of`. The
#: last rows are of fMRIPrep's set alone, whose names are those of BIDS derivatives.
_ENDINGS = {
    "sulc": ("sulc.shape.gii", "sulc", "sulc.native.shape.gii"),
    "curv": ("curv.shape.gii", "curv", "curvature.native.shape.gii"),
    "area": ("area.shape.gii", "area", "area.native.shape.gii"),
    "sphere": ("sphere.surf.gii", "sphere", "sphere.native.surf.gii"),
    "midthickness": ("midthickness.surf.gii", "midthickness", "midthickness.native.surf.gii"),
    "registered": (
        "space-{label}_desc-reg{mirrored}_sphere.surf.gii",
        "{frame}sphere.reg",
        "{registered}{dotted}.native.surf.gii",
    ),
    "distortion": (
        "space-{label}_desc-reg{mirrored}_arealdistortion.shape.gii",
        "{frame}distortion",
        "ArealDistortion_{name}{dotted}.native.shape.gii",
    ),
    "resampled": (
        "space-{label}_den-{density}{desc}_{kind}.surf.gii",
        "{kind}{dotted}.{name}",
        "{kind}{dotted}.{density}_{mesh}.surf.gii",
    ),
    "labels": (
        "seg-{label}{desc}_dseg.label.gii",
        "{name}{dotted}.annot",
        "{name}{dotted}.native.label.gii",
    ),
    "margin": (
        "seg-{label}_desc-margin{mirrored}_probseg.shape.gii",
        "{name}{dotted}.margin",
        "{name}_margin{dotted}.native.shape.gii",
    ),
    "white": ("white.surf.gii",),
    "pial": ("pial.surf.gii",),
    "thickness": ("thickness.shape.gii",),
    "cortex": ("desc-cortex{mirrored}_mask.label.gii",),
    "msmsulc": ("space-{label}_desc-msmsulc{mirrored}_sphere.surf.gii",),
}


@dataclass(frozen=True)
class Names:
    """The names of all files of a hemisphere, by one convention; if its mirror image was registered, `mirrored`."""

    convention: Convention
    hemisphere: Hemisphere
    mirrored: bool = False

    def of(self, what: str, name: str = "", *, kind: str = "", vertices: int = 0) -> str:
        """The name of the file of ``sulc``, ``curv``, ``area``, ``sphere`` or ``midthickness``, or of the others below.

        fMRIPrep's set has ``white``, ``pial``, ``thickness``, ``cortex`` and, of a frame, ``msmsulc``, too. Of a frame
        `name` ``registered`` is the sphere, ``distortion`` the change of areas, ``resampled`` the surface of a kind
        with the vertices of the template; of an atlas `name` ``labels``, and ``margin`` their confidence.
        """
        h, mirrored, dotted, desc = self.hemisphere, "", "", ""
        side, density = h.side, str(vertices)
        if self.mirrored:
            mirrored, dotted, desc = "mirrored", ".mirrored", "_desc-mirrored"
            side = _letter(h.other)
        if vertices >= 1000:
            density = f"{round(vertices / 1000)}k"
        words = {
            "name": name,
            "kind": kind,
            "mirrored": mirrored,
            "label": _entity(name),
            "dotted": dotted,
            "desc": desc,
            # FreeSurfer's own frame is not named; others are, as `surfreg` names them: lh.fsLR.sphere.reg.
            "frame": "".join(
                f"{word}." for word in (name, mirrored) if word not in ("fsaverage", "")
            ),
            "registered": {"fsaverage": "sphere.reg", "fsLR": "sphere.reg.reg_LR"}.get(
                name, f"sphere.reg.{name}"
            ),
            "density": density,
            "mesh": {"fsaverage": f"fsavg_{side}", "fsLR": "fs_LR"}.get(name, name),
        }
        begin, column = {
            "bids": (f"{h.entities}_hemi-{h.side}_", 0),
            "fmriprep": (f"{h.entities}_hemi-{h.side}_", 0),
            "freesurfer": (f"{h.hemi}.", 1),
            "hcp": (f"{h.subject}.{h.side}.", 2),
        }[self.convention]
        return begin + _ENDINGS[what][column].format(**words)


def fill_sides(pattern: str, structure: str) -> str:
    """A path with {hemi} and {side} replaced by lh or rh, and L or R.

    >>> fill_sides("atlas/{hemi}.aparc.annot", "CortexRight")
    'atlas/rh.aparc.annot'
    """
    side = _letter(structure)
    return pattern.replace("{hemi}", f"{side.lower()}h").replace("{side}", side)
