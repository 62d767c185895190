"""A controller of any kind driven over a setup of which few samples are kept: memory for series does not grow."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from adaptive_ff.comparison.running import Drive, ends_of_parts, report
from adaptive_ff.simulation.experiment import NO_POSITION_LOOP, Record, RunSetup, empty_record
from adaptive_ff.simulation.loop import start_position
from adaptive_ff.simulation.metrics import RunMetrics, first_motion
from adaptive_ff.simulation.parts import after_part, kept_samples, part_of
from controllers.arrays import NDArray


class Thinned(NamedTuple):
    """A run of which few samples are kept.

    Attributes
    ----------
    samples : ndarray of int64, shape (kept,)
        Which.
    record : Record
        All series at these samples.
    metrics : RunMetrics
        Figures of merit of the whole run.
    """

    samples: NDArray[np.int64]
    record: Record
    metrics: RunMetrics


def drive_thinned(
    controller: Any,
    setup: RunSetup,
    thin: int,
    last_change: float,
    progress: Callable[[float], None] | None = None,
    *,
    note: Callable[[int], None] | None = None,
    parts: int = 1,
) -> tuple[Thinned, tuple[str, ...], tuple[str, ...]]:
    """Run a controller as :func:`adaptive_ff.comparison.running.drive_over` does, and keep few of its samples.

    Parameters
    ----------
    thin : int
        One of so many samples is kept, and the last.
    last_change : float
        Time of the last change of the joint, s; zero without one.
    controller, setup, progress, note, parts
        As for :func:`adaptive_ff.comparison.running.drive_over`.

    Returns
    -------
    thinned : Thinned
        The kept samples, and the figures of merit of the whole run.
    names, watched : tuple of str
        Names of the estimates and of the monitors in it.
    """
    drive = Drive(controller)
    setup = drive.previewed(setup)
    position, count, given = start_position(setup), setup.noise.size, np.zeros(0)
    metrics = RunMetrics(setup.reference.size, setup.solver_period, first_motion(setup.reference), last_change)
    kept: list[Record] = []
    for stop in ends_of_parts(count, parts):
        start = position.sample
        window, position, first = part_of(setup, position, stop)
        record = empty_record(window, len(drive.names), len(drive.watched))
        record.given[: start - first] = given[given.size - (start - first) :]
        position = drive.advance(window, position, stop - first, record)
        position, given = after_part(position, first), record.given
        with np.errstate(over="ignore", invalid="ignore"):
            _count(metrics, window, record, start - first, stop == count)
        samples = kept_samples(start, stop, count, thin)
        if samples.size:
            kept.append(_at_samples(record, window, samples - first))
        report(stop, count, progress, note)
    series = Record(*(np.concatenate(parts) for parts in zip(*kept, strict=True)))
    return Thinned(kept_samples(0, count, count, thin), series, metrics), drive.names, drive.watched


def _count(metrics: RunMetrics, setup: RunSetup, record: Record, start: int, ends: bool) -> None:
    """Add what a part of a run holds from a sample on; the end of a part is the begin of the next one."""
    begin = int(setup.samples[start])
    stop = None if ends else -1
    error = setup.reference[begin:stop] - record.velocity[begin:stop]
    metrics.add(setup.begin + begin, error, record.torque[start:])
    if setup.outer != NO_POSITION_LOOP:
        metrics.add_position(setup.begin + begin, setup.planned[begin:stop] - record.position[begin:stop])


def _at_samples(record: Record, setup: RunSetup, samples: NDArray[np.int64]) -> Record:
    """Return the series at some samples, those of the solver's grid too; the position as its error."""
    steps = setup.samples[samples]
    others = {name: getattr(record, name)[samples] for name in Record._fields[2:]}
    return Record(record.velocity[steps], setup.planned[steps] - record.position[steps], **others)
