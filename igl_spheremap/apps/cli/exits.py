"""The exit statuses of the command."""

from __future__ import annotations

from enum import IntEnum


class Exit(IntEnum):
    """Exit statuses with their meanings; those from 64 on are the usual ones of sysexits.h."""

    meaning: str

    def __new__(cls, status: int, meaning: str = "") -> Exit:
        one = int.__new__(cls, status)
        one._value_, one.meaning = status, meaning
        return one

    OK = 0, "done; a map is certified folding-free"
    NO_MESH = 2, "the input is no closed, oriented, connected genus-0 triangle mesh"
    UNCERTIFIED = 3, "not certified: foldings remain, or vertices are off the sphere (a map is written all the same)"
    USAGE = 64, "the command line is wrong"
    UNAVAILABLE = 69, "a scheduler does not answer, or its workers can't be used"
    FAILED = 70, "the computation failed on a sound mesh, or memory ran out"
    FILE = 74, "a file can't be read or written"
    INTERRUPTED = 130, "interrupted by Ctrl-C (what was done until then is written)"
    TERMINATED = 143, "ended by SIGTERM (the same)"


HELP = "exit status:\n" + "".join(f"  {status:<3} {status.meaning}\n" for status in Exit)
