"""The signal that asks a process to end: what a command has half written is removed before it does."""

import multiprocessing
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

TERMINATED = 128 + signal.SIGTERM
"""Exit status of a command that was asked to end."""


@contextmanager
def ending_in_order() -> Iterator[None]:
    """Let the signal end what runs inside by ``SystemExit``, as Ctrl-C does by ``KeyboardInterrupt``.

    A second one ends the process at once. Where somebody else handles the signal, or ignores it, it is left to them.
    """
    default = signal.SIG_DFL
    if threading.current_thread() is not threading.main_thread() or signal.getsignal(signal.SIGTERM) != default:
        yield
        return
    signal.signal(signal.SIGTERM, _end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, default)


def _end(number: int, frame: FrameType | None) -> None:
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    for worker in multiprocessing.active_children():  # Ctrl-C reaches them, this does not; nobody waits for results
        worker.terminate()
    raise SystemExit(TERMINATED)
