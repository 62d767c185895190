"""A controller of any kind driven over a course: compiled where it has kernels, else in plain Python."""

from collections.abc import Callable
from typing import Any

from adaptive_ff.comparison.own import own_controller
from adaptive_ff.simulation.experiment import Course, Record, empty_record
from adaptive_ff.simulation.loop import run_in_memory, run_plain, start_position
from controllers import Controller
from controllers.compiled import compiles

PART = 20_000
"""Samples between two reports of progress."""


def drive_over(
    controller: Any,
    course: Course,
    progress: Callable[[float], None] | None = None,
    *,
    note: Callable[[int], None] | None = None,
    parts: int = 1,
) -> tuple[Record, tuple[str, ...], tuple[str, ...]]:
    """Run a controller over a course.

    Parameters
    ----------
    controller : Controller or any object with a method ``step``
        It ends in the state at the end of the run.
    course : Course
        Joint, drive, reference and noise.
    progress : callable, optional
        Is called with the share done, from 0 to 1.
    note : callable, optional
        Is called with the number of the last sample after each part, when the controller is in the state of then.
    parts : int, optional
        Least number of parts of the run.

    Returns
    -------
    record : Record
        The series.
    names, watched : tuple of str
        Names of the estimates and of the monitors in it.
    """
    registered = isinstance(controller, Controller)
    compiled = registered and compiles()
    block, state = running_state(controller, registered, compiled)
    names = (controller if registered else block).estimate_names
    watched = controller.monitor_names if registered else ()
    record = empty_record(course, len(names), len(watched))
    run = run_in_memory if compiled else run_plain
    position, count = start_position(course), course.noise.size
    part = min(PART, max(1, count // parts))
    while position.sample < count:
        stop = min(position.sample + part, count)
        state, position = run(block, state, course, position, stop, record)
        if registered and not compiled:
            controller.state = state
        if note is not None:
            note(stop - 1)
        if progress is not None:
            progress(stop / count)
    return record, names, watched


def running_state(controller: Any, registered: bool, compiled: bool) -> tuple[Any, Any]:
    """Return what the loop takes for parameters and state: compiled, the state stays with the controller."""
    if not registered:
        return own_controller(controller), None
    return (controller.native, 0) if compiled else (controller.parameters, controller.state)
