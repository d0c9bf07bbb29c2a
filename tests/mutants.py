"""Damaged versions of files, and the readers' answers.

`python tests/mutants.py 5000` counts it for every reader (PYTHONPATH=. from a clone).
"""

from __future__ import annotations

import argparse
import base64
import gzip
import io
import re
import struct
import sys
import tempfile
import time
import zipfile
import zlib
from collections import Counter
from pathlib import Path

import numpy as np
from other_programs import (
    WRITERS,
    cifti_of_scalars,
    image_of_freesurfer,
    image_of_labels,
    mni,
)

import igl_spheremap as ism
from igl_spheremap.io.files import read_mesh, read_sphere
from igl_spheremap.io.records import Label
from igl_spheremap.io.scalars import read_labels, read_scalars, write_scalars
from igl_spheremap.io.write_mesh import write_mesh
from igl_spheremap.io.written_map import read_map, read_mark
from igl_spheremap.shapes.harmonics.files import read_coefficients

WRITERS = WRITERS | {
    "mni.obj": mni,
    "labels.nii.gz": image_of_labels,
    "aseg.mgh": image_of_freesurfer,
    "a.dscalar.nii": cifti_of_scalars,
}
#: What may leave a reader.
ALLOWED = (ism.MeshError, ism.FileError, ism.MapError)
SPECIAL = [
    struct.pack(f, n) for f in ("<i", ">i", "<q") for n in (0, -1, 1, 2**31 - 1, -(2**31))
] + [
    struct.pack(f, x) for f in ("<f", ">f", "<d") for x in (float("nan"), float("inf"), -0.0, 1e38)
]
WORDS = [
    b"-1",
    b"0",
    b"1e999",
    b"nan",
    b"-inf",
    b"999999999999",
    b"4294967296",
    b"9" * 30,
    b"0x10",
    b"",
    b"x",
    b"1.5",
    b"[]",
    b"{}",
    b"null",
    b"<>",
]


def read_polygons(path):
    """As `igl-spheremap --repair` reads."""
    return read_mesh(path, triangulate=True)


def read_label(path):
    """The surface of a label."""
    return read_mesh(f"{path}:1")


def read_left(path):
    """The data of one side."""
    return read_scalars(path, structure="CortexLeft")


#: The readers, and the names of files that each is tried on.
READERS = {
    read_mesh: (
        "ball.obj",
        "ball.off",
        "ball.ply",
        "text.ply",
        "ball.stl",
        "text.stl",
        "ball.npz",
        "ball.glb",
        "ball.gltf",
        "ball.surf.gii",
        "ball.surf.gii.gz",
        "lh.sphere.conformal",
        "ball.vtk",
        "text.vtk",
        "new.vtk",
        "mixed.ply",
        "ball.tab",
        "mni.obj",
        "lh.white.asc",
        "ball.mz3",
        "packed.mz3",
        "ball.vtp",
        "packed.vtp",
        "grid.vtk",
    ),
    read_label: ("labels.nii.gz", "aseg.mgh"),
    read_polygons: (
        "ball.obj",
        "ball.off",
        "ball.ply",
        "text.ply",
        "ball.vtk",
        "text.vtk",
        "mixed.ply",
    ),
    read_sphere: ("map.npz",),
    read_map: ("map.npz",),
    read_mark: ("map.npz", "map.obj", "map.surf.gii.gz"),
    read_scalars: (
        "data.npz",
        "data.shape.gii",
        "lh.data",
        "lh.data.annot",
        "point.vtk",
        "data.npy",
        "data.csv",
        "data.tsv",
        "data.txt",
        "data.1D",
        "data.ply",
    ),
    read_left: ("a.dscalar.nii",),
    read_labels: ("lh.data.annot", "data.label.gii"),
    read_coefficients: ("ball.coef", "ball.npz.coef.npz"),
}
CASES = [(reader, name) for reader, names in READERS.items() for name in names]


def lines(template, rows):
    """Text with one template for each row."""
    return "".join(template.format(*row) for row in rows.tolist())


def write_sound(folder, name):
    """A small sound file of that name; its bytes."""
    path, (v, f) = Path(folder) / name, ism.samples.sphere(12)
    if name in WRITERS:
        return WRITERS[name](v, f)
    if name.startswith("map"):
        ism.write_map(path, ism.spherical_conformal_map(*ism.samples.sphere(42)))
    elif name.endswith(("annot", "label.gii")):
        table = tuple(Label(k, f"part {k}", (k / 5, 0.4, 0.2, 1.0)) for k in range(4))
        write_scalars(path, {"parts": np.arange(len(v)) % 4}, metadata={"labels": table})
    elif "data" in name:
        several = {} if name == "lh.data" else {"width": v[:, 0]}
        write_scalars(path, {"height": v[:, 2]} | several, surface=(v, f))
    elif "coef" in name:
        ism.shapes.write_coefficients(
            path, ism.shapes.spherical_harmonics(ism.sphere_map(v, f, v), degree=2)
        )
    elif name == "text.ply":
        rows = lines("{} {} {}\n", v) + lines("3 {} {} {}\n", f)
        path.write_text(
            f"ply\nformat ascii 1.0\nelement vertex {len(v)}\nproperty float x\nproperty float y\nproperty "
            f"float z\nelement face {len(f)}\nproperty list uchar int vertex_indices\nend_header\n{rows}"
        )
    elif name == "mixed.ply":
        path.write_bytes(
            f"ply\nformat binary_big_endian 1.0\nelement vertex {len(v)}\nproperty list uchar short n\n"
            "property float x\nproperty float y\nproperty float z\nelement face 2\nproperty int k\n"
            "property list uchar int vertex_indices\nend_header\n".encode()
            + b"".join(
                struct.pack(f">B{k % 3}h3f", k % 3, *[7] * (k % 3), *x) for k, x in enumerate(v)
            )
            + struct.pack(">iB3iiB4i", 1, 3, 0, 1, 2, 1, 4, 0, 1, 2, 3)
        )
    elif name in ("text.vtk", "new.vtk"):
        path.write_text(legacy_polygons(v, f, new=name == "new.vtk"))
    elif name.startswith("point"):
        write_mesh(
            path, v, f, metadata={"point_data": {"height": v[:, 2], "vector": v.astype("f4")}}
        )
    elif name == "text.stl":
        path.write_text(
            "solid\n"
            + lines("facet\n" + "vertex {} {} {}\n" * 3 + "endfacet\n", v[f].reshape(-1, 9))
            + "endsolid\n"
        )
    else:
        write_mesh(path, v, f)
    data = path.read_bytes()
    path.unlink()
    return data


def legacy_polygons(v, f, new):
    """A .vtk file as text, in the layout of version 5 or an older one, with what else such a file holds."""
    points = lines("{} {} {}\n", v)
    ends, fives, ones = (
        " ".join(map(str, row)) for row in (range(0, f.size + 1, 3), [5] * len(v), [1] * len(v))
    )
    cells = f"POLYGONS {len(f)} {4 * len(f)}\n" + lines("3 {} {} {}\n", f)
    if new:
        cells = f"POLYGONS {len(f) + 1} {f.size}\nOFFSETS vtktypeint64\n{ends}\nCONNECTIVITY vtktypeint64\n"
        cells += lines("{} {} {}\n", f)
    return (
        f"# vtk DataFile Version {5.1 if new else 4.2}\ntitle\nASCII\nDATASET POLYDATA\nFIELD FieldData 1\n"
        f"s 1 1 int\n7\nPOINTS {len(v)} float\n{points}{cells}METADATA\nINFORMATION 0\n\n"
        f"POINT_DATA {len(v)}\nSCALARS s short 1\nLOOKUP_TABLE default\n{fives}\nVECTORS w double\n{points}"
        f"FIELD FieldData 1\nb 1 {len(v)} int\n{ones}\n"
    )


def mutant(data, rng):
    """One damaged version: what a container packs is damaged inside, in half of the cases."""
    if rng.random() < 0.5:
        return damage(data, rng)
    if data.startswith(b"PK"):
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = {name: archive.read(name) for name in archive.namelist()}
        name = list(members)[rng.integers(len(members))]
        members[name] = damage(members[name], rng)
        packed = io.BytesIO()
        with zipfile.ZipFile(
            packed, "w", int(rng.choice([zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED]))
        ) as archive:
            for name, content in members.items():
                archive.writestr(name, content)
        return packed.getvalue()
    if data.startswith(b"\x1f\x8b"):
        return gzip.compress(mutant(gzip.decompress(data), rng))
    if data.startswith(b"glTF"):
        size = int.from_bytes(data[12:16], "little")
        tree = damage(data[20 : 20 + size], rng)
        rest = data[20 + size :]
        return (
            struct.pack("<4sIIII", b"glTF", 2, 20 + len(tree) + len(rest), len(tree), 0x4E4F534A)
            + tree
            + rest
        )
    blocks = list(re.finditer(rb"<Data>([^<]+)</Data>", data))
    if blocks:
        block = blocks[rng.integers(len(blocks))]
        inner = damage(zlib.decompress(base64.b64decode(block[1])), rng)
        return (
            data[: block.start(1)] + base64.b64encode(zlib.compress(inner)) + data[block.end(1) :]
        )
    return damage(data, rng)


def damage(data, rng):
    """One to three faults: bits, cuts, repeats, special numbers in binary, and words in text."""
    for _ in range(rng.integers(1, 4)):
        at, size = int(rng.integers(len(data) + 1)), int(rng.integers(1, 40))
        kind = rng.integers(7)
        if kind == 0 and at < len(data):
            data = data[:at] + bytes([data[at] ^ (1 << int(rng.integers(8)))]) + data[at + 1 :]
        elif kind == 1:
            data = data[:at]
        elif kind == 2:
            data = data[:at] + data[at + size :]
        elif kind == 3:
            data = data[:at] + data[at : at + size] * 2 + data[at + size :]
        elif kind == 4:
            data = (
                data[:at] + rng.integers(0, 256, size, dtype=np.uint8).tobytes() + data[at + size :]
            )
        elif kind == 5:
            word = SPECIAL[rng.integers(len(SPECIAL))]
            data = data[:at] + word + data[at + len(word) :]
        else:
            tokens = [m.span() for m in re.finditer(rb"[\w.+-]+", data[:20000])]
            if tokens:
                a, b = tokens[rng.integers(len(tokens))]
                data = data[:a] + WORDS[rng.integers(len(WORDS))] + data[b:]
    return data


def judge(reader, path):
    """A reader's answer to a file: "read", "refused", or the traceback's last line."""
    try:
        reader(path)
    except ALLOWED as error:
        return "refused" if "\n" not in str(error) else f"more than one line: {error!r}"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return "read"


def main():
    import resource  # Windows has neither this nor signal.alarm
    import signal

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int, nargs="?", default=5000, help="mutants of each file")
    parser.add_argument("--only", default="", help="part of the names of files")
    args = parser.parse_args()
    resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))
    faults = 0
    for k, (reader, name) in enumerate(CASES):
        with tempfile.TemporaryDirectory() as folder:
            if args.only not in name:
                continue
            rng, sound = np.random.default_rng(k), write_sound(folder, name)
            verdicts, slowest, path = Counter(), 0.0, Path(folder) / name
            for i in range(args.count):
                path.write_bytes(mutant(sound, rng))
                signal.alarm(60)  # a hang ends the program
                began = time.process_time()
                verdict = judge(reader, path)
                slowest = max(slowest, time.process_time() - began)
                signal.alarm(0)
                if verdict not in ("read", "refused"):
                    Path(f"mutant-{k}-{i}-{name}").write_bytes(path.read_bytes())
                verdicts[verdict] += 1
            wrong = {text: n for text, n in verdicts.items() if text not in ("read", "refused")}
            faults += sum(wrong.values())
            peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10
            print(
                f"{reader.__name__:18} {name:20} read {verdicts['read']:5} refused {verdicts['refused']:5} slowest "
                f"{slowest:.3f} s, peak of the process {peak} MB {wrong or ''}",
                flush=True,
            )
    print(f"{faults} faults")
    sys.exit(bool(faults))


if __name__ == "__main__":
    main()
