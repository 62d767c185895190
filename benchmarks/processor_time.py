"""Processor time of whole processes: how long the command line takes before it has done anything."""

import statistics
import subprocess
import sys
from collections.abc import Sequence

try:
    import resource
except ImportError:  # not on Windows
    resource = None  # type: ignore[assignment]

HELP = (sys.executable, "-m", "adaptive_ff", "--help")
NUMPY = (sys.executable, "-c", "import numpy")

REPEATS = 9


def processor_time(command: Sequence[str]) -> float:
    """Return the processor time, user and system together, that a process takes, s.

    Raises
    ------
    subprocess.CalledProcessError
        The command fails.
    """
    before = child_time()
    subprocess.run(command, check=True, capture_output=True)
    return child_time() - before


def child_time() -> float:
    """Return the processor time of all processes that this one started and that have ended, s; zero on Windows."""
    if resource is None:
        return 0.0
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def help_beside_numpy(repeats: int = REPEATS) -> tuple[float, float] | None:
    """Return the median processor times of ``adaptive-ff --help`` and of importing numpy, s; None on Windows.

    The two run in turn, after a run of each that does not count: it compiles what Python keeps as bytecode.
    """
    if resource is None:
        return None
    pairs = [(processor_time(HELP), processor_time(NUMPY)) for _ in range(repeats + 1)][1:]
    return statistics.median(ours for ours, _ in pairs), statistics.median(theirs for _, theirs in pairs)
