"""Threads and processes that work for a command, and end when it does."""

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing.connection import wait

TURN = 1e-5
"""How long a thread may keep the interpreter when another wants it, s: a compiled run should not wait for 5 ms."""


class Threads(ThreadPoolExecutor):
    """Threads, by default one for each processor, for what is compiled for most of the time."""

    def __init__(self, workers: int | None = None) -> None:
        super().__init__(workers or os.cpu_count())
        self._before = sys.getswitchinterval()
        sys.setswitchinterval(TURN)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End when what runs has ended."""
        super().shutdown(wait, cancel_futures=cancel_futures)
        sys.setswitchinterval(self._before)


def pool_of_workers(workers: int | None = None) -> ProcessPoolExecutor:
    """Return a pool of processes, by default one for each processor, that end with this one however it ends.

    A process that is killed cannot tell its workers, which then would work, or wait, for ever.
    """
    return ProcessPoolExecutor(workers or os.cpu_count(), initializer=end_with_parent)


def end_with_parent() -> None:
    """Watch the parent of this process from a thread, and end with it; end at once where asked to by a signal."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # a parent may handle it, and hand that down
    parent = multiprocessing.parent_process()
    if parent is None:
        return

    def watch() -> None:
        wait([parent.sentinel])
        os._exit(1)  # nobody waits for a result

    threading.Thread(target=watch, name="end-with-parent", daemon=True).start()


def part_of_progress(
    progress: Callable[[float], None] | None, begin: int, parts: int, size: int = 1
) -> Callable[[float], None] | None:
    """Return what is called with the fraction done of some of the parts, for what is called with that of all."""
    return None if progress is None else lambda done: progress((begin + size * done) / parts)
