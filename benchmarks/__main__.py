"""``python -m benchmarks NAME [OPTIONS]`` from the root of the repository; ``--list`` lists the names.

With ``--package CHECKOUT`` before the name another checkout's igl_spheremap is measured.
"""

import ast
import os
import sys
from importlib import import_module
from pathlib import Path

HERE = Path(__file__).parent
#: What is not a benchmark: shared code, and a program for another Python.
SHARED = {
    "__init__",
    "__main__",
    "common",
    "cortex_data",
    "judge_meshes",
    "judge_programs",
    "judge_published",
    "mutate",
    "pages",
    "unwrap3d_flow",
}
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "IGL_NUM_THREADS")


def names():
    """The benchmarks, in the order of the alphabet."""
    return sorted(path.stem for path in HERE.glob("*.py") if path.stem not in SHARED)


def main(words):
    """Run one benchmark in one thread."""
    os.environ |= dict.fromkeys(THREADS, "1")
    sys.path.insert(0, str(HERE.parent / "tests"))  # its random bodies and triangulations
    if words[:1] == ["--package"]:
        sys.path.insert(0, words[1])
        import_module("igl_spheremap")
        words = words[2:]
    if words[:1] == ["--list"]:
        for name in names():
            print(
                f"{name:24} {ast.get_docstring(ast.parse((HERE / f'{name}.py').read_text())).splitlines()[0]}"
            )
    elif not words or words[0] not in names():
        sys.exit(f"{__doc__}\nThe names are {', '.join(names())}.")
    else:
        import_module(f"benchmarks.{words[0]}").main(words[1:])


if __name__ == "__main__":
    main(sys.argv[1:])
