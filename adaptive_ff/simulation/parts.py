"""A run in parts, each with a record of its own, so that the memory for its series does not grow with its length."""

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.simulation.experiment import RunSetup
from adaptive_ff.simulation.loop import Position


def part_of(setup: RunSetup, position: Position, stop: int) -> tuple[RunSetup, Position, int]:
    """Return the setup from where a run has come to up to a sample, as a setup of its own with views of the series.

    It begins where the command was given that still acts, or one sample early: the time since the last sample counts.
    With it come the position in it, and the sample of the whole setup with which it begins.
    """
    first = max(0, min(position.acting, position.sample - 1))
    begin, end = int(setup.samples[first]), int(setup.samples[stop])
    part = setup._replace(
        samples=setup.samples[first : stop + 1] - begin,
        reference=setup.reference[begin : end + 1],
        noise=setup.noise[first:stop],
        held=setup.held[first:stop],
        planned=setup.planned[begin : end + 1],
        plan=setup.plan._replace(starts=setup.plan.starts - begin),
        begin=begin,
        acting=setup.acting[first : stop + 1],
    )
    return part, _shifted(position, -first), first


def after_part(position: Position, first: int) -> Position:
    """Return the position in the whole setup for one in a part that begins with a sample."""
    return _shifted(position, first)


def _shifted(position: Position, samples: int) -> Position:
    acting = position.acting + samples if position.acting >= 0 else -1
    return position._replace(sample=position.sample + samples, acting=acting)


def kept_samples(start: int, stop: int, count: int, thin: int) -> NDArray[np.int64]:
    """Return which samples from start to stop are kept: every so many of all, and the last of them all."""
    kept = np.arange(-(-start // thin) * thin, stop, thin)
    return np.append(kept, count - 1) if stop == count and (count - 1) % thin else kept
