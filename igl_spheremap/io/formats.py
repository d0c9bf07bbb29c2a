"""The table of formats. It imports no reader: a format's module is imported when a file is read or written."""

from __future__ import annotations

import contextlib
import re
import zlib
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

from ..errors import FileError

if TYPE_CHECKING:  # help and wrong lines load no numpy
    from ..gate import PathLike

#: By whose convention a hemisphere's files are named. FreeSurfer's are written in its formats, the others as GIFTI.
Convention = Literal["bids", "freesurfer", "hcp", "fmriprep"]
CONVENTIONS = get_args(Convention)


@dataclass(frozen=True)
class Format:
    """A row of the table of formats."""

    name: str
    # of this room, with `read` and `write` of meshes, `read_scalars` and `write_scalars` of data
    module: str
    suffixes: tuple[str, ...]  # ends of file names, lower case; the first is the usual one
    magic: bytes = b""  # a regular expression of how files begin, where all do
    radius: float = 1.0  # of spheres, by the convention of the format's users
    single: bool = False  # positions are held in float32
    ordered: bool = True  # vertices keep their order
    both: bool = False  # a file can hold the sphere of its surface, too
    package: str = ""  # of an extra, without which files are neither read nor written
    data: bool = False  # a file can hold maps over the vertices
    packed: bool = False  # a file may be gzip's
    sides: bool = False  # a file can hold data of several structures
    labels: bool = False  # an image, of which each label has a surface

    @property
    def functions(self) -> Any:
        """The module, imported."""
        return import_module(f"{__package__}.{self.module}")


def _root(name: bytes) -> bytes:
    """Beginning of files of XML: the root stands behind a declaration and comments."""
    return rb"(\xef\xbb\xbf)?\s*(?=<).*?<" + name


#: FreeSurfer's kinds of surfaces, and two of this package, so that its results take no name of FreeSurfer's files.
_KINDS = (
    "pial", "white", "sphere", "inflated", "smoothwm", "orig", "midthickness", "graymid", "qsphere", "reg", "surf",
    "conformal", "balanced",
)  # fmt: skip
#: Ends of names of images of voxels.
IMAGES = (".nii", ".nii.gz", ".mgz", ".mgh")
#: Ends of names of CIFTI-2 files of numbers; of those of labels another one.
CIFTI_SCALARS, CIFTI_SERIES = ".dscalar.nii", ".dtseries.nii"
#: Beginnings of names of FreeSurfer's files.
HEMISPHERES = ("lh.", "rh.")
#: All formats of meshes. A further one is a module with `read` and `write`, and a row here.
FORMATS = (
    Format("OBJ", "obj", (".obj",)),
    Format("OFF", "off", (".off",), magic=rb"C?N?OFF\s"),
    Format("PLY", "ply", (".ply",), magic=rb"ply\s", both=True, data=True),
    Format("STL", "stl", (".stl",), single=True, ordered=False),
    Format("VTK", "vtk", (".vtk",), magic=rb"# vtk DataFile", data=True),
    Format("shape model", "plates", (".tab", ".ver", ".icq")),
    Format("VTK XML", "vtk_xml", (".vtp", ".vtu"), magic=_root(b"VTKFile"), data=True),
    Format("MZ3", "mz3", (".mz3",), magic=rb"MZ", single=True, packed=True),
    Format("glTF", "gltf", (".glb", ".gltf"), magic=rb"glTF", single=True, package="trimesh"),
    Format(
        "GIFTI",
        "gifti",
        (".gii", ".gii.gz"),
        magic=_root(b"GIFTI"),
        radius=100.0,
        single=True,
        package="nibabel",
        data=True,
        packed=True,
    ),
    Format(
        "FreeSurfer",
        "freesurfer",
        (*(f".{kind}" for kind in _KINDS), ".asc"),
        magic=rb"\xff\xff[\xfd-\xff]|#!ascii",
        radius=100.0,
        single=True,
        package="nibabel",
        data=True,
    ),
    Format("NPZ", "npz", (".npz",), magic=rb"PK\x03\x04.{26,300}?\.npy", both=True, data=True),
    Format(
        "label image",
        "label_image",
        IMAGES,
        magic=rb"\x5c\x01\0\0|\0\0\x01\x5c|\x1c\x02\0\0n|\0\0\x02\x1cn",
        package="nibabel",
        packed=True,
        labels=True,
    ),
)
#: All formats of maps over vertices.
DATA_FORMATS = (
    *(entry for entry in FORMATS if entry.data),
    Format(
        "CIFTI",
        "cifti",
        (CIFTI_SCALARS, ".dlabel.nii", CIFTI_SERIES),
        magic=rb"\x1c\x02\0\0n",
        package="nibabel",
        data=True,
        sides=True,
    ),
    Format("annotation", "annot", (".annot",), data=True),
    Format("NumPy", "arrays", (".npy",), magic=rb"\x93NUMPY", data=True),
    Format("table", "arrays", (".csv", ".tsv", ".txt", ".1d"), data=True),
)
#: Ends of names of files that are read only, and the formats written in their place.
READ_ONLY = {
    ".ver": ".tab",
    ".icq": ".tab",
    ".vtp": ".vtk",
    ".vtu": ".vtk",
    ".mz3": ".ply",
    ".asc": ".gii",
}
READ_ONLY |= dict.fromkeys(IMAGES, ".ply")


#: Formats that are known but not read, by the ends of names: each with the conversion that leads to one that is.
FOREIGN = {
    end: (name, remedy)
    for remedy, names in {
        "convert it by `assimp export {path} {stem}.obj`": {
            ".dae": "COLLADA",
            ".fbx": "FBX",
            ".3ds": "3DS",
            ".3mf": "3MF",
            ".x3d": "X3D",
            ".wrl": "VRML",
            ".blend": "Blender's format",
            ".dxf": "DXF",
        },
        "mesh it by `gmsh {path} -2 -o {stem}.stl`": {
            ".step": "STEP",
            ".stp": "STEP",
            ".iges": "IGES",
            ".igs": "IGES",
        },
        "convert it by `meshio convert {path} {stem}.vtk`": {
            ".msh": "Gmsh's format",
            ".mesh": "Medit's format",
            ".inp": "Abaqus' format",
            ".bdf": "Nastran's format",
            ".xdmf": "XDMF",
            ".med": "MED",
        },
        "convert it by PyVista: read('{path}').extract_surface().triangulate().save('{stem}.ply')": {
            ".vti": "VTK's format of images",
            ".vtr": "VTK's format of grids",
            ".vts": "VTK's format of grids",
            ".pvtp": "VTK's format of files in parts",
            ".pvtu": "VTK's format of files in parts",
        },
        "convert it by SimpleITK: WriteImage(ReadImage('{path}'), '{stem}.nii.gz')": {
            ".nrrd": "NRRD",
            ".mha": "MetaImage",
            ".mhd": "MetaImage",
            ".dcm": "DICOM",
        },
        "convert it by `ConvertSurface -i_bv {path} -o_gii {stem}.surf.gii`": {
            ".srf": "BrainVoyager's format"
        },
        "take it out of its surface by igl_spheremap.io.patch: read_patch('{path}').part(v, f)": {
            ".patch.3d": "a patch of FreeSurfer, without faces",
            ".patch.flat": "a patch of FreeSurfer, without faces",
        },
        "give a mesh, or a grid of positions in an .npz file": {
            ".png": "a picture",
            ".jpg": "a picture",
            ".tif": "a picture",
        },
        "reconstruct its surface first": {
            ".xyz": "a cloud of points",
            ".pcd": "a cloud of points",
            ".las": "a cloud of points",
        },
    }.items()
    for end, name in names.items()
}

#: Regular expressions of how files of them begin, with the end of a name that stands for the format.
FOREIGN_MARKS = {
    _root(b"COLLADA"): ".dae",
    _root(b"X3D"): ".x3d",
    _root(b"Xdmf"): ".xdmf",
    rb"PK\x03\x04.{26}(\[Content_Types\]|_rels/|3D/)": ".3mf",
    rb"#VRML": ".wrl",
    rb"Kaydara FBX": ".fbx",
    rb"BLENDER[-_\d]": ".blend",
    rb"ISO-10303-21;": ".step",
    rb"\$MeshFormat": ".msh",
    rb"MeshVersionFormatted\s+\d": ".mesh",
    rb"NRRD\d{4}": ".nrrd",
    rb"ObjectType\s*=": ".mhd",
    rb"\x89PNG": ".png",
    rb"\xff\xd8\xff": ".jpg",
    rb"II\*\0|MM\0\*": ".tif",
    rb"\xff\xff\xff\xff|#!ascii (version of )?patch": ".patch.3d",
}
GZIP = b"\x1f\x8b"


def format_of(path: PathLike, *, data: bool = False) -> Format:
    """The format of a mesh or of data by the end of its name; other lh.NAME and rh.NAME: FreeSurfer's.

    Examples
    --------
    >>> format_of("bunny.OBJ").name, format_of("sub-01/surf/lh.sphere.v2").name, format_of("lh.pial.surf.gii").name
    ('OBJ', 'FreeSurfer', 'GIFTI')
    """
    what, formats = _known(data)
    name = Path(path).name
    for entry in formats:
        if name.lower().endswith(entry.suffixes):
            return entry
    if name.startswith(HEMISPHERES):
        return next(entry for entry in formats if entry.name == "FreeSurfer")
    known = ", ".join(f"{entry.name} ({', '.join(entry.suffixes)})" for entry in formats)
    raise FileError(f"{path}: unknown {what}; the end of the name decides: {known}")


def _known(data: bool) -> tuple[str, tuple[Format, ...]]:
    """Names of formats, and all formats."""
    if data:
        return "format of data", DATA_FORMATS
    return "format", FORMATS


def head_of(path: Path, size: int = 4096) -> tuple[bytes, bool]:
    """The bytes that name a file's format, and whether gzip packs them."""
    with path.open("rb") as file:
        head = file.read(size)
    packed = head.startswith(GZIP)
    if packed:
        with contextlib.suppress(zlib.error):
            head = zlib.decompressobj(wbits=31).decompress(head, size)
    return head, packed


def format_in(path: PathLike, *, data: bool = False) -> Format:
    """The format of an existing file, by its first bytes, or else by its name."""
    path = Path(path)
    head, packed = head_of(path)
    for mark, end in FOREIGN_MARKS.items():
        if re.match(mark, head, re.DOTALL):
            raise _not_read(path, end)
    for entry in _known(data)[1]:
        if entry.magic and re.match(entry.magic, head, re.DOTALL):
            if packed and not entry.packed:
                raise FileError(f"{path} is packed by gzip; unpack it: gunzip {path}")
            return entry
    for end in FOREIGN:
        if path.name.lower().endswith(end):
            raise _not_read(path, end)
    return format_of(path, data=data)


def _not_read(path: Path, end: str) -> FileError:
    name, remedy = FOREIGN[end]
    stem = str(path).removesuffix(path.suffix)
    return FileError(f"{path} is {name}, which is not read; {remedy.format(path=path, stem=stem)}")


def suffix_of(path: PathLike) -> str:
    """The longest end of a name that stands for a format; empty if none does.

    >>> suffix_of("a/ball.surf.GII.gz"), suffix_of("lh.curv"), suffix_of("labels.nii.gz")
    ('.gii.gz', '', '.nii.gz')
    """
    name = Path(path).name.lower()
    ends = (end for entry in (*FORMATS, *DATA_FORMATS) for end in entry.suffixes)
    return max((end for end in ends if name.endswith(end)), key=len, default="")


def stem_of(path: PathLike) -> str:
    """The name of a file without the end that stands for its format.

    >>> stem_of("a/labels.nii.gz"), stem_of("lh.white.ply"), stem_of("a/lh.curv")
    ('labels', 'lh.white', 'lh')
    """
    path = Path(path)
    if not suffix_of(path):
        return path.stem
    return path.name[: -len(suffix_of(path))]
