"""File names of a hemisphere by the conventions of BIDS, FreeSurfer and HCP: what they tell, and what is written."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from ..errors import FileError, Remedy
from .formats import Convention, PathLike
from .gifti import structure_of

LEFT, RIGHT = "CortexLeft", "CortexRight"
#: The structures by the letters that stand for them.
SIDES = {"L": LEFT, "R": RIGHT}
#: Words of names for kinds of surfaces.
_KINDS = {"white": "white", "smoothwm": "white", "pial": "pial", "midthickness": "midthickness",
          "graymid": "midthickness", "central": "midthickness"}
_WORD = re.compile(r"[A-Za-z0-9]+")
_BIDS = re.compile(r"(sub-[A-Za-z0-9]+(?:_[a-z]+-[A-Za-z0-9]+)*?)_hemi-[LR]_")
_HCP = re.compile(r"([^.]+)\.[LR]\.")
_SIDE = re.compile(r"^[lr]h\.|_?hemi-[LR](?=_|\.|$)|(?<=\.)[LR]\.")
_SEGMENTATION = re.compile(r"(?:atlas|seg)-([A-Za-z0-9]+)")
_ENDS = re.compile(r"(\.(annot|gii|gz|label|npz|native|dlabel|32k_fs_LR|164k_fs_LR))+$|_dseg(?=\.)")


@dataclass(frozen=True)
class Hemisphere:
    """What the name of a surface's file tells.

    Attributes
    ----------
    subject : str
        sub-01 of sub-01_hemi-L_white.surf.gii, bert of bert/surf/lh.white, 100307 of 100307.L.white.native.surf.gii.
    entities : str
        How names of BIDS begin: sub-01, and what comes before the hemisphere.
    structure : str
        "CortexLeft" or "CortexRight".
    kind : str
        "white", "pial" or "midthickness"; a surface of another name counts as the last.
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


def other_side(structure: str) -> str:
    """The structure of the other side; another structure is that of both.

    >>> other_side("CortexLeft"), other_side("Cerebellum")
    ('CortexRight', 'Cerebellum')
    """
    return {LEFT: RIGHT, RIGHT: LEFT}.get(structure, structure)


def _letter(structure: str) -> str:
    return "L" if structure == LEFT else "R"


def hemisphere_of(path: PathLike, structure: str | None = None) -> Hemisphere:
    """What the name of a surface tells; the side may be known from elsewhere, as from the file.

    >>> hemisphere_of("sub-01_ses-2_hemi-L_white.surf.gii")
    Hemisphere(subject='sub-01', entities='sub-01_ses-2', structure='CortexLeft', kind='white')
    >>> hemisphere_of("subjects/bert-2/surf/rh.pial").entities, hemisphere_of("100307.R.white.native.surf.gii").subject
    ('sub-bert2', '100307')
    """
    path = Path(path)
    structure = structure_of(path.name).get("structure", structure)
    if structure not in (LEFT, RIGHT):
        raise FileError(f"{path} does not say which hemisphere it is: name it lh.NAME, rh.NAME or NAME_hemi-L, or give "
                        f"{Remedy(options={'hemisphere': None})} L or R")
    kind = next((_KINDS[word] for word in _WORD.findall(path.name) if word in _KINDS), "midthickness")
    if found := _BIDS.match(path.name):
        entities = found[1]
        return Hemisphere(entities.partition("_")[0], entities, structure, kind)
    hcp = _HCP.match(path.name)
    subject = path.resolve().parts[-3] if path.resolve().parent.name == "surf" else hcp[1] if hcp else _rest(path.name)
    label = re.sub(r"[^A-Za-z0-9]", "", subject.removeprefix("sub-")) or "x"
    return Hemisphere(subject, f"sub-{label}", structure, kind)


def _rest(name: str) -> str:
    """What a name holds besides side, kind and suffixes, as T1Prep's lh.central.NAME.gii.

    >>> _rest("lh.central.bert.gii"), _rest("white.surf.gii")
    ('bert', 'x')
    """
    known = {*_KINDS, "lh", "rh", "surf", "gii", "gz", "obj", "ply", "stl", "vtk", "off", ""}
    return "_".join(word for word in re.split(r"[._]", name) if word not in known) or "x"


def partner_of(path: PathLike) -> str | None:
    """The file of the pial surface beside a white one, of the same name but for that word; None if there is none."""
    name, count = re.subn(r"(?<![A-Za-z])white(?![A-Za-z])", "pial", Path(path).name)
    found = Path(path).with_name(name)
    return str(found) if count == 1 and found.is_file() else None


def atlas_of(path: PathLike) -> str:
    """The name of an atlas by that of its file.

    >>> atlas_of("lh.aparc_HCP_MMP1.annot"), atlas_of("tpl-fsLR_hemi-L_atlas-Glasser_dseg.label.gii")
    ('aparc_HCP_MMP1', 'Glasser')
    >>> atlas_of("fsaverage.L.BA.32k_fs_LR.label.gii")
    'fsaverage.BA'
    """
    name = Path(path).name
    found = _SEGMENTATION.search(name)
    return found[1] if found else _SIDE.sub("", _ENDS.sub("", name)) or "labels"


@dataclass(frozen=True)
class Names:
    """The names of all files of a hemisphere, by one convention.

    Those of a registration take the frame, and `mirrored` if the hemisphere's mirror image was registered; resampled
    surfaces their number of vertices, too.
    """

    convention: Convention
    hemisphere: Hemisphere
    mirrored: bool = False

    def scalars(self, quantity: Literal["sulc", "curv", "area"]) -> str:
        """Data at the vertices of the surface."""
        words = {"curv": "curvature"} if self.convention == "hcp" else {}
        return self._name(bids=f"{quantity}.shape.gii", freesurfer=quantity,
                          hcp=f"{words.get(quantity, quantity)}.native.shape.gii")

    def surface(self, kind: Literal["sphere", "midthickness"]) -> str:
        """The sphere, as it was mapped, or the midthickness."""
        return self._name(bids=f"{kind}.surf.gii", freesurfer=kind, hcp=f"{kind}.native.surf.gii")

    def registered(self, space: str) -> str:
        """The registered sphere."""
        hcp = {"fsaverage": "sphere.reg", "fsLR": "sphere.reg.reg_LR"}.get(space, f"sphere.reg.{space}")
        return self._name(bids=f"space-{_label(space)}_desc-{self._tag('reg')}_sphere.surf.gii",
                          freesurfer=f"{self._frame(space)}sphere.reg", hcp=f"{hcp}{self._dotted}.native.surf.gii")

    def distortion(self, space: str) -> str:
        """How areas changed."""
        return self._name(bids=f"space-{_label(space)}_desc-{self._tag('reg')}_arealdistortion.shape.gii",
                          freesurfer=f"{self._frame(space)}distortion",
                          hcp=f"ArealDistortion_{space}{self._dotted}.native.shape.gii")

    def resampled(self, space: str, vertices: int, kind: str) -> str:
        """The surface with the vertices of the template."""
        thousands = f"{round(vertices / 1000)}k" if vertices >= 1000 else str(vertices)
        side = _letter(self.hemisphere.other if self.mirrored else self.hemisphere.structure)
        hcp = {"fsaverage": f"fsavg_{side}", "fsLR": "fs_LR"}.get(space, space)
        desc = "_desc-mirrored" if self.mirrored else ""
        return self._name(bids=f"space-{_label(space)}_den-{thousands}{desc}_{kind}.surf.gii",
                          freesurfer=f"{kind}{self._dotted}.{space}",
                          hcp=f"{kind}{self._dotted}.{thousands}_{hcp}.surf.gii")

    def labels(self, atlas: str) -> str:
        """Labels of an atlas."""
        return self._name(bids=f"seg-{_label(atlas)}{'_desc-mirrored' * self.mirrored}_dseg.label.gii",
                          freesurfer=f"{atlas}{self._dotted}.annot", hcp=f"{atlas}{self._dotted}.native.label.gii")

    def margin(self, atlas: str) -> str:
        """How sure labels are."""
        return self._name(bids=f"seg-{_label(atlas)}_desc-{self._tag('margin')}_probseg.shape.gii",
                          freesurfer=f"{atlas}{self._dotted}.margin",
                          hcp=f"{atlas}_margin{self._dotted}.native.shape.gii")

    def _name(self, *, bids: str, freesurfer: str, hcp: str) -> str:
        h = self.hemisphere
        return {"bids": f"{h.entities}_hemi-{h.side}_{bids}", "freesurfer": f"{h.hemi}.{freesurfer}",
                "hcp": f"{h.subject}.{h.side}.{hcp}"}[self.convention]

    @property
    def _dotted(self) -> str:
        return ".mirrored" if self.mirrored else ""

    def _tag(self, word: str) -> str:
        return f"{word}mirrored" if self.mirrored else word

    def _frame(self, space: str) -> str:
        """FreeSurfer's own frame is not named; others are, as `surfreg` names them: lh.fsLR.sphere.reg."""
        words = [word for word, there in ((space, space != "fsaverage"), ("mirrored", self.mirrored)) if there]
        return "".join(f"{word}." for word in words)


def _label(text: str) -> str:
    """A value of an entity of BIDS, which has letters and digits only."""
    return re.sub(r"[^A-Za-z0-9]", "", text) or "x"


def fill_sides(pattern: str, structure: str) -> str:
    """A path with {hemi} and {side} replaced by lh or rh, and L or R.

    >>> fill_sides("atlas/{hemi}.aparc.annot", "CortexRight")
    'atlas/rh.aparc.annot'
    """
    side = _letter(structure)
    return pattern.replace("{hemi}", f"{side.lower()}h").replace("{side}", side)
