"""The memory of the machine, and the limit that the system sets a process."""

from __future__ import annotations

import os

#: Bytes of address space that libraries take when they are loaded and first used: those of any map with one thread of
#: BLAS, and the addition of each solver. With 20 MB less OpenBLAS waits for memory without end, or ends the process
#: (measured with `ulimit -v`, of numpy 2.4, scipy 1.17, cvxopt 1.3 and rslab 1.7).
OF_ANY_MAP = 300e6
OF_SOLVER = {"cvxopt.cholmod": 260e6, "rslab": 300e6, "scipy.sparse.linalg": 80e6}


def fits_memory(n: int) -> bool:
    """Whether an exact factor for this number of unknowns takes at most half of the machine's memory.

    Free memory does not count: the choice must not change from run to run. A factor and its making take up to 3,000
    bytes an unknown, of SuperLU with 240,000 vertices (`python -m benchmarks factors`).
    """
    try:
        machine = float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, ValueError, OSError):
        return True
    return n * 3_000 <= machine / 2


def bytes_left() -> float:
    """Address space that this process may still take; without a limit of the system (`ulimit -v`) infinite."""
    try:
        import resource  # not on Windows

        limit = resource.getrlimit(resource.RLIMIT_AS)[0]
        if limit != resource.RLIM_INFINITY:
            with open("/proc/self/statm", encoding="ascii") as sizes:
                return float(limit - int(sizes.read().split()[0]) * resource.getpagesize())
    except (ImportError, OSError):
        pass
    return float("inf")


def too_little(needed: float) -> MemoryError:
    """The error if the limit leaves libraries too little, for which they would wait or crash."""
    return MemoryError(
        f"the system lets this process take {bytes_left() / 1e6:.0f} MB more, and libraries need "
        f"{needed / 1e6:.0f}; raise the limit, as by ulimit -v"
    )
