"""The exit statuses of the command."""

from __future__ import annotations

from enum import IntEnum


class Exit(IntEnum):
    """Exit statuses; those from 64 on are the usual ones of sysexits.h."""

    OK = 0  #: done, and where a map is concerned: certified folding-free
    NO_MESH = 2  #: the input is no closed, oriented, connected genus-0 triangle mesh
    FOLDINGS = 3  #: foldings remain; what was computed is written
    USAGE = 64  #: the command line is wrong
    UNAVAILABLE = 69  #: a scheduler does not answer, or its workers can't be used
    FAILED = 70  #: the computation failed on a sound mesh, or memory ran out
    FILE = 74  #: a file can't be read or written
    INTERRUPTED = 130  #: Ctrl-C; what was done until then is written
    TERMINATED = 143  #: SIGTERM; the same


HELP = """\
exit status:
  0   done; a map is certified folding-free
  2   the input is no closed, oriented, connected genus-0 triangle mesh
  3   foldings remain (the map is written all the same)
  64  the command line is wrong
  69  a scheduler does not answer, or its workers can't be used
  70  the computation failed on a sound mesh, or memory ran out
  74  a file can't be read or written
  130 interrupted by Ctrl-C (what was done until then is written)
  143 ended by SIGTERM (the same)
"""
