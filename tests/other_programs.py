"""Small files as other programs write them: surfaces `v, f`, and images of labels."""

from __future__ import annotations

import gzip
import struct
import zlib

import numpy as np


def text_of(rows):
    return "".join(" ".join(map(repr, row)) + "\n" for row in np.asarray(rows).tolist())


def mni(v, f):
    """As CIVET writes surfaces."""
    ends = " ".join(map(str, range(3, 3 * len(f) + 1, 3)))
    return (
        f"P 0.3 0.3 0.4 10 1 {len(v)}\n{text_of(v)}\n{text_of(v)}\n{len(f)}\n0 1 1 1 1\n\n{ends}\n\n"
        f"{text_of(f)}"
    ).encode()


def ascii_surface(v, f):
    """As mris_convert writes .asc."""
    rows = (np.column_stack((each, 0 * each[:, 0])) for each in (v, f))
    return f"#!ascii version of lh.white\n{len(v)} {len(f)}\n{''.join(map(text_of, rows))}".encode()


def mz3(v, f):
    """As Surf Ice writes surfaces, with four bytes to skip."""
    head = struct.pack("<2sHIII", b"MZ", 3, len(f), len(v), 4)
    return head + b"skip" + f.astype("<i4").tobytes() + v.astype("<f4").tobytes()


def packed_mz3(v, f):
    return gzip.compress(mz3(v, f))


def xml(v, f):
    """As a person writes a .vtp."""
    ends = " ".join(map(str, range(3, 3 * len(f) + 1, 3)))
    return f"""<?xml version="1.0"?>
<!-- a ball -->
<VTKFile type="PolyData"><PolyData><Piece NumberOfPoints="{len(v)}" NumberOfPolys="{len(f)}">
<PointData><DataArray type="Float64" Name="z">{text_of(v[:, 2:])}</DataArray>
<DataArray type="String" Name="text">1 2</DataArray></PointData>
<Points><DataArray type="Float64" NumberOfComponents="3">{text_of(v)}</DataArray></Points>
<Polys><DataArray type="Int32" Name="connectivity">{text_of(f)}</DataArray>
<DataArray type="Int32" Name="offsets">{ends}</DataArray></Polys></Piece></PolyData></VTKFile>""".encode()


def packed_xml(v, f):
    """As VTK writes a .vtp: arrays behind the tree, raw, packed by zlib in blocks of 256 bytes."""
    arrays = {
        "z": v[:, 2].astype("<f8"),
        "points": v.astype("<f8"),
        "connectivity": f.astype("<i8"),
        "offsets": np.arange(3, 3 * len(f) + 1, 3, dtype="<i8"),
    }
    places, data = {}, b""
    for name, array in arrays.items():
        content = array.tobytes()
        blocks = [content[k : k + 256] for k in range(0, len(content), 256)]
        packed = [zlib.compress(block) for block in blocks]
        head = [len(blocks), 256, len(blocks[-1]) % 256, *map(len, packed)]
        places[name] = len(data)
        data += struct.pack(f"<{len(head)}I", *head) + b"".join(packed)
    kinds = {"points": "Float64", "z": "Float64"}
    tags = {
        name: f'<DataArray type="{kinds.get(name, "Int64")}" Name="{name}" format="appended" '
        f'NumberOfComponents="{3 if name == "points" else 1}" offset="{place}"/>'
        for name, place in places.items()
    }
    return (
        f"""<?xml version="1.0"?>
<VTKFile type="PolyData" byte_order="LittleEndian" header_type="UInt32" compressor="vtkZLibDataCompressor">
<PolyData><Piece NumberOfPoints="{len(v)}" NumberOfPolys="{len(f)}"><PointData>{tags["z"]}</PointData>
<Points>{tags["points"]}</Points><Polys>{tags["connectivity"]}{tags["offsets"]}</Polys></Piece></PolyData>
<AppendedData encoding="raw">_""".encode()
        + data
        + b"</AppendedData></VTKFile>"
    )


def grid(v, f):
    """As meshio writes a .vtk."""
    cells = text_of(np.column_stack((np.full(len(f), 3), f)))
    types = "5\n" * len(f)
    return (
        f"# vtk DataFile Version 4.2\nmade\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {len(v)} double\n"
        f"{text_of(v)}CELLS {len(f)} {4 * len(f)}\n{cells}CELL_TYPES {len(f)}\n{types}"
    ).encode()


def label_image(kind="Nifti1Image", dtype=np.uint8):
    """A ball, a ring, and two boxes, one at the border, of labels 1, 3 and 17, in voxels of 2 x 1.5 x 1."""
    nibabel = __import__("nibabel")
    x, y, z = np.indices((24, 20, 16))
    image = np.zeros(x.shape, dtype)
    image[(x - 6) ** 2 + (y - 9) ** 2 + (z - 8) ** 2 < 16] = 1
    image[(np.hypot(x - 16, y - 11) - 5) ** 2 + (z - 8) ** 2 < 4] = 3
    image[:3, :3, :3] = image[20:22, :2, 5:8] = 17
    affine = np.array([[-2.0, 0, 0, 40], [0, 0, 1, -9], [0, 1.5, 0, -7], [0, 0, 0, 1]])
    return image, affine, getattr(nibabel, kind)(image, affine)


def cifti(n, wall, kind="scalar", structures=("LEFT", "RIGHT")):
    """Two maps over hemispheres of n vertices without a medial wall, and over a voxel, as HCP's pipelines write them.

    Labels are one map. Each number is the vertex, that of the right side and 1,000.
    """
    cifti2 = __import__("nibabel.cifti2").cifti2
    kept = np.setdiff1d(np.arange(n), wall)
    rows = cifti2.BrainModelAxis.from_mask(
        np.ones((1, 1, 1), bool), affine=np.eye(4), name="CIFTI_STRUCTURE_THALAMUS_LEFT"
    )
    for side in structures:
        name = f"CIFTI_STRUCTURE_CORTEX_{side}"
        rows = rows + cifti2.BrainModelAxis.from_surface(kept, n, name)
    places = [kept + 1000.0 * (side == "RIGHT") for side in structures]
    data = np.concatenate([[-1.0], *places])[None]
    table = {0: ("???", (0.0, 0.0, 0.0, 0.0)), 1: ("odd", (1.0, 0.0, 0.0, 1.0))}
    axes = {
        "scalar": (cifti2.ScalarAxis(["place", "twice"]), np.concatenate([data, 2 * data])),
        "series": (cifti2.SeriesAxis(0, 1, 2), np.concatenate([data, 2 * data])),
        "label": (cifti2.LabelAxis(["parity"], [table]), np.abs(data) % 2),
    }
    axis, values = axes[kind]
    return cifti2.Cifti2Image(values.astype(np.float32), header=(axis, rows))


def cifti_of_scalars(v, f):
    return cifti(12, [3, 5]).to_bytes()


def image_of_labels(v, f):
    return gzip.compress(label_image()[2].to_bytes())


def image_of_freesurfer(v, f):
    return label_image("MGHImage", np.int32)[2].to_bytes()


WRITERS = {
    "ball.obj": mni,
    "lh.white.asc": ascii_surface,
    "ball.mz3": mz3,
    "packed.mz3": packed_mz3,
    "ball.vtp": xml,
    "packed.vtp": packed_xml,
    "grid.vtk": grid,
}
