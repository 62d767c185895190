"""A controller of any kind driven over a setup: compiled where it has kernels, else in plain Python."""

import copy
import os
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

from adaptive_ff.comparison.own import own_controller, step_own, write_own_estimates
from adaptive_ff.simulation.experiment import RunSetup, empty_record
from adaptive_ff.simulation.loop import NEVER, run_controller, run_in_memory, run_plain, start_position
from controllers import CalledBack, Controller
from controllers.compiled import compiles
from controllers.interface import feedback_state
from controllers.kernels.types import members, type_of

PART = 20_000  # samples between two reports of progress


class Drive:
    """A controller on its way through a setup, whose plan it knows by the delay it reckons with, and its record."""

    def __init__(self, controller: Any, setup: RunSetup) -> None:
        self.registered = isinstance(controller, Controller)
        self.controller: Any = controller if self.registered else own_controller(controller)
        self._called: CalledBack | None = None
        if not self.registered and compiles():
            writes = partial(write_own_estimates, self.controller) if self.controller.estimate_names else None
            self._called = CalledBack(partial(step_own, self.controller), writes)
        self.names: tuple[str, ...] = self.controller.estimate_names  # of its estimates
        self.watched: tuple[str, ...] = controller.monitor_names if self.registered else ()  # of its monitors
        if self.registered and setup.lead < NEVER:
            delay = feedback_state(controller.parameters).delay * controller.period
            setup = setup._replace(lead=round(delay / setup.solver_period))
        self.setup, self.position = setup, start_position(setup)
        self.record = empty_record(setup, len(self.names), len(self.watched))

    def advance(self, stop: int) -> None:
        """Run to a sample and fill the record."""
        on_the_way = self.setup, self.position, stop, self.record
        if self.registered:
            self.position = run_controller(self.controller, *on_the_way)
        elif self._called is None:
            self.position = run_plain(self.controller, None, *on_the_way)[1]
        else:
            self.position = run_in_memory(self._called.addresses, 0, *on_the_way)[1]
            self._called.check()


def drive_over(
    controller: Any, setup: RunSetup, reports: Callable[[int, int], None] | None = None, parts: int = 1
) -> Drive:
    """Run a controller over a setup; it ends in the state at the end.

    After each part, of which there are ``parts`` at least, ``reports`` is called with the samples done and those of the
    whole run.
    """
    drive, count = Drive(controller, setup), setup.noise.size
    part = min(PART, max(1, count // parts))
    for stop in [*range(part, count, part), count]:
        drive.advance(stop)
        if reports is not None:
            reports(stop, count)
    return drive


def compile_together(controllers: Iterable[Any], setup: RunSetup) -> None:
    """Compile what the runs of controllers over a setup need, on all processors at once: runs of no sample do it."""
    if compiles():
        own = [each for each in controllers if isinstance(each, Controller)]
        # longest processing time first: the more parameters a kernel has, the longer a compiler takes
        own.sort(key=lambda each: members(type_of(each.parameters)), reverse=True)
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            list(pool.map(lambda each: Drive(copy.deepcopy(each), setup).advance(0), own))


def check_progress(progress: Any) -> None:
    """Raise a TypeError for what cannot be called with the fraction done, and is not None."""
    if progress is not None and not callable(progress):
        raise TypeError(f"progress = {progress!r} is not allowed: it must be a function")
