"""A controller of any kind driven over a setup: compiled where it has kernels, else in plain Python."""

import copy
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

from adaptive_ff.comparison.own import own_controller, step_own, write_own_estimates
from adaptive_ff.simulation.experiment import Record, RunSetup, empty_record, with_preview
from adaptive_ff.simulation.loop import Position, run_controller, run_in_memory, run_plain, start_position
from controllers import CalledBack, Controller
from controllers.compiled import compiles
from controllers.interface import feedback_state

PART = 20_000
"""Samples between two reports of progress."""


class Drive:
    """A controller on its way through a setup, in the state of the last sample; names of its estimates and monitors."""

    def __init__(self, controller: Any) -> None:
        self.registered = isinstance(controller, Controller)
        self.controller: Any = controller if self.registered else own_controller(controller)
        self._called: CalledBack | None = None
        if not self.registered and compiles():
            writes = partial(write_own_estimates, self.controller) if self.controller.estimate_names else None
            self._called = CalledBack(partial(step_own, self.controller), writes)
        self.names: tuple[str, ...] = self.controller.estimate_names
        self.watched: tuple[str, ...] = controller.monitor_names if self.registered else ()

    def empty_record(self, setup: RunSetup) -> Record:
        """Return the series of a run over a setup, to be filled in."""
        return empty_record(setup, len(self.names), len(self.watched))

    def previewed(self, setup: RunSetup) -> RunSetup:
        """Return a setup with the plan for when torques act by the delay that the controller reckons with."""
        if not self.registered:
            return setup
        return with_preview(setup, feedback_state(self.controller.parameters).delay * self.controller.period)

    def advance(self, setup: RunSetup, position: Position, stop: int, record: Record) -> Position:
        """Run from a position to a sample and fill the record; return the position there."""
        if self.registered:
            return run_controller(self.controller, setup, position, stop, record)
        if self._called is None:
            return run_plain(self.controller, None, setup, position, stop, record)[1]
        position = run_in_memory(self._called.addresses, 0, setup, position, stop, record)[1]
        self._called.check()
        return position


def drive_over(
    controller: Any, setup: RunSetup, reports: Callable[[int, int], None] | None = None, parts: int = 1
) -> tuple[Record, Drive]:
    """Run a controller over a setup; return the series and what drove it; it ends in the state at the end.

    After each part, of which there are ``parts`` at least, ``reports`` is called with the samples done and those of the
    whole run.
    """
    drive = Drive(controller)
    setup = drive.previewed(setup)
    record, position = drive.empty_record(setup), start_position(setup)
    count = setup.noise.size
    part = min(PART, max(1, count // parts))
    for stop in [*range(part, count, part), count]:
        position = drive.advance(setup, position, stop, record)
        if reports is not None:
            reports(stop, count)
    return record, drive


def compile_together(controllers: Iterable[Any], setup: RunSetup) -> None:
    """Compile what the runs of controllers over a setup need, on all processors at once: runs of no sample do it."""

    def begin(controller: Any) -> None:
        drive = Drive(copy.deepcopy(controller))
        built = drive.previewed(setup)
        drive.advance(built, start_position(built), 0, drive.empty_record(built))

    if compiles():
        own = [each for each in controllers if isinstance(each, Controller)]
        with ThreadPoolExecutor(max(1, len(own))) as pool:  # most wait for a compiler, or for another one's kernels
            list(pool.map(begin, own))


def check_progress(progress: Any) -> None:
    """Raise a TypeError for what cannot be called with the fraction done, and is not None."""
    if progress is not None and not callable(progress):
        raise TypeError(f"progress = {progress!r} is not allowed: it must be a function")
