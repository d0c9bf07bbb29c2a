"""Calls for other processes, which import nothing that takes time."""

import os
import time

KILL = 9  # signal.SIGKILL, a name that Windows lacks


def process():
    """The number of this process; prints of libraries do no harm."""
    print("noise", flush=True)
    os.write(1, b"noise")
    return os.getpid()


def refuse():
    """Fail with an error that can be sent back."""
    raise ValueError("no")


def die():
    """End as for lack of memory."""
    os.kill(os.getpid(), KILL)


def leave():
    """End by oneself, as with a broken installation."""
    os._exit(3)


def wait():
    """Take longer than anybody waits."""
    time.sleep(60)


def pages_taken():
    """Pages that the system clears for 40 MB, which are freed again."""
    import resource  # not on Windows

    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    bytearray(40_000_000)
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before
