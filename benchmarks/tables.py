"""Make the tables of the pages anew: what a benchmark prints is kept in benchmarks/results, and stands in the pages.

    python -m benchmarks tables [NAME ...] [--corpus FOLDER] [--parts FOLDER] [--before CHECKOUT]

Without names all are made. The folders are the corpus (docs/corpus.md) and that of `python -m benchmarks gather`;
CHECKOUT is one of another version, for the tables of tried.md that compare with it. A page holds a table between
<!-- table NAME --> and <!-- end -->.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from .common import DOCS, ROOT, parser
from .pages import fill

RESULTS = Path(__file__).with_name("results")
#: Which benchmark prints a table; a file of the corpus stands as corpus:NAME.
TABLES = {
    "repair_maps": "repairs maps sample:dino sample:octopus sample:spring corpus:dino_isoblend_6013 corpus:lucy_cr_50k "
    "corpus:paper_brain_15002 corpus:paper_dilo_9731 corpus:brain_15002_qslim_slivers "
    "corpus:bunny_noise40 corpus:choi_moai corpus:comb corpus:octopus_low corpus:part_cgal "
    "corpus:putamen_cit168_right corpus:sword_oded corpus:syn_tetrahedron corpus:syn_thin_plate "
    "corpus:syn_dumbbell_neck corpus:syn_hairy_sphere corpus:syn_needle_1_1_100 corpus:vhacd_drum",
    "repair_rings": "repairs rings",
    "repair_gauges": "repairs gauges sample:spring corpus:sword_oded corpus:syn_needle_1_1_100 "
    "corpus:syn_dumbbell_neck corpus:comb corpus:paper_dilo_9731 corpus:octopus_low worm:40",
    "repair_bodies": "random_meshes bodies --count 600",
    "repair_programs": "repairs foldings CORPUS/public CORPUS/hard",
    "repair_embedding": "repairs embedding",
    "repair_polish": "repairs polish corpus:choi_maxplanck corpus:paper_bimba_15002 corpus:choi_hippocampus "
    "corpus:fsaverage5_pial_left corpus:paper_brain_15002 corpus:koala corpus:spot_oded "
    "corpus:penguin corpus:armadillo_oded corpus:paper_dilo_9731 corpus:dino_isoblend_6013 "
    "corpus:lucy_cr_50k corpus:bunny_noise40 corpus:choi_moai corpus:sword_oded",
    "repair_test": "versions BEFORE PARTS/test --csv RESULTS/repair_test.csv",
    "versions": "versions BEFORE sample:spheroid sample:pear sample:dumbbell corpus:choi_hippocampus corpus:penguin "
    "--of maps balance disks --turns 5",
    "disks_exact": "disks exact",
    "disks_cortex": "disks programs --only cortex",
    "disks_programs": "disks programs --largest 2200 --corpus CORPUS",
    "disks_sliding": "disks sliding --largest 2200 --corpus CORPUS",
    "disks_long": "disks long --sizes 1000 4000 16000 100000",
    "balance_maps": "balanced_maps maps CORPUS --bodies 32",
    "balance_programs": "balanced_maps programs corpus:choi_maxplanck corpus:paper_brain_15002 "
    "corpus:choi_hippocampus corpus:armadillo_oded",
    "balance_lengths": "balanced_maps lengths",
    "match_pairs": "correspondences --meshes CORPUS/public CORPUS/hard CORPUS/pairs --only pairs --pairs 12",
    "match_warps": "correspondences --meshes CORPUS/public CORPUS/hard CORPUS/pairs --only warps",
    "match_landmarks": "correspondences --meshes CORPUS/public CORPUS/hard CORPUS/pairs --only landmarks",
    "match_overlays": "correspondences --meshes CORPUS/public CORPUS/hard CORPUS/pairs --only overlays",
    "match_sizes": "correspondences --meshes CORPUS/public CORPUS/hard CORPUS/pairs --only sizes",
    "cortices": "cortices . --only",
    "open_holes": "open_surfaces --holes sample:dino sample:bunny sample:brain sample:spheroid sample:pear "
    "corpus:choi_hippocampus corpus:choi_maxplanck corpus:fsaverage5_pial_left "
    "corpus:paper_bimba_15002 corpus:paper_putamen_10002 corpus:penguin corpus:spot_oded "
    "corpus:armadillo_oded corpus:koala",
    "harmonics_bodies": "harmonics --cells CORPUS/cells/180427_Doc5_deconv_t00.obj",
    "others": "others",
    "others_first": "others --first 3",
    "others_once": "others --once",
    "judge_spheres": "judge --kind sphere",
    "judge_disks": "judge --kind disk",
    "judge_maps": "judge --kind map",
    "judge_published": "judge --published PARTS/published",
    "groups_planted": "groups",
    "groups_weights": "groups --weights 4 --members 10",
    "groups_sizes": "groups --sizes 10 100 1000 --vertices 300 --to ico:2",
    "permutations_null": "permutations",
    "permutations_planted": "permutations --planted 300",
    "groups_deformed": "groups --deformed 2 --vertices 1500",
    "groups_films": "groups --films 50 --to ico:3",
    "groups_meshes": "groups --sizes 100 --vertices 10000",
    "factors": "factors sample:brain:n_vertices=15000 corpus:lucy_cr_50k sample:brain:n_vertices=60000 "
    "sample:brain:n_vertices=240000",
    "landmarks": "landmarks",
    "scaling": "scaling map sample:octopus:n_vertices=7500,arm_length=8 map sample:spring:n_vertices=7500 "
    ".5 sample:octopus:n_vertices=7500 1 sample:octopus:n_vertices=7500",
    "phases": "phases",
    "open_handles": "open_surfaces --handles 1:200 5:200 20:200",
    "open_folder": "open_surfaces --folder CORPUS/open",
    "readings": "readings readings --csv RESULTS/readings.csv --meshes CORPUS",
    "readings_surfaces": "readings surfaces --csv RESULTS/readings.csv --meshes CORPUS",
    "claims_boosts": "claims boosts --meshes CORPUS",
    "claims_eigenfunctions": "claims eigenfunctions --meshes CORPUS",
    "claims_planes": "claims planes --meshes CORPUS",
    "claims_projections": "claims projections --meshes CORPUS",
    "paper_bodies": "paper --csv RESULTS/paper_bodies.csv",
    "claims_rounding": "claims rounding --meshes CORPUS",
    "claims_speeds": "claims speeds --meshes CORPUS",
}


def main(argv: list[str]) -> None:
    """Make the tables that were asked for, and write them into the pages."""
    arguments = parser(__doc__)
    arguments.add_argument("names", nargs="*", metavar="NAME", help=", ".join(TABLES))
    for folder in ("corpus", "parts", "before"):
        arguments.add_argument(f"--{folder}", type=Path, default=Path(folder))
    options = arguments.parse_args(argv)
    for name in options.names or TABLES:
        words = [
            located(word, options.corpus, options.parts, options.before)
            for word in TABLES[name].split()
        ]
        print(name, file=sys.stderr, flush=True)
        done = subprocess.run(
            [sys.executable, "-m", "benchmarks", *words],
            cwd=ROOT,
            stdout=subprocess.PIPE,
            text=True,
        )
        if done.returncode:
            raise SystemExit(f"{name}: the benchmark ended with status {done.returncode}")
        keep(name, done.stdout)


def located(word: str, corpus: Path, parts: Path, before: Path) -> str:
    """A word of a command with the folders of this machine."""
    if word.startswith("corpus:"):
        return str(next(corpus.resolve().glob(f"*/{word.removeprefix('corpus:')}.*")))
    for name, folder in (
        ("CORPUS", corpus),
        ("PARTS", parts),
        ("BEFORE", before),
        ("RESULTS", RESULTS),
    ):
        if word.partition("/")[0] == name:
            word = word.replace(name, str(folder.resolve()))
    return word


def keep(name: str, printed: str) -> None:
    """Keep the table in what was printed, with its command, and write it into the pages."""
    table = "\n".join(line for line in printed.splitlines() if line.startswith("|"))
    (RESULTS / f"{name}.md").write_text(
        f"`python -m benchmarks {TABLES[name]}`\n\n{table}\n", encoding="utf-8"
    )
    tables = {path.stem: path.read_text("utf-8") for path in RESULTS.glob("*.md")}
    for page in (
        ROOT / "README.md",
        ROOT / "paper" / "paper.md",
        *DOCS.rglob("*.md"),
        RESULTS.with_name("tried.md"),
    ):
        text = page.read_text("utf-8")
        if (filled := fill(text, tables)) != text:
            page.write_text(filled, encoding="utf-8")
