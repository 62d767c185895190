"""Closed loops some of whose inputs are replaced by any numbers, in plain Python for as long as that lasts."""

import copy
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np
from closed_loops import SCENARIO, build_setup, make, run_compiled

from adaptive_ff.simulation.experiment import empty_record
from adaptive_ff.simulation.loop import run_plain, start_position
from controllers import ESTIMATES, STEPS, feedback_state, step, without_estimates

FIRST, BAD, AFTER, JUDGED = 4000, 200, 3000, 1000
"""Samples of learning, of bad inputs at most, until tracking is judged, and of what is judged: at 100 Hz."""


class Poisoned(NamedTuple):
    """A controller and what some of its inputs are replaced by.

    Attributes
    ----------
    controller : NamedTuple
        Parameters of the controller.
    replaced : dict
        For the number of a sample, values by name of the input.
    """

    controller: Any
    replaced: dict[int, dict[str, float]]


def step_poisoned(block, state, inputs):
    """Do one sample with what is replaced."""
    replaced = block.replaced.get(feedback_state(state).samples, {})
    return step(block.controller, state, inputs._replace(**replaced))


def is_finite(value):
    """Tell whether all numbers of a state are."""
    if isinstance(value, tuple):
        return all(is_finite(item) for item in value)
    return bool(np.all(np.isfinite(np.asarray(value, dtype=float))))


class Learnt:
    """A controller that has learnt, to be run on with bad inputs again and again."""

    def __init__(self, name, seed=101):
        self.setup = build_setup(SCENARIO.modified(duration=(FIRST + BAD + AFTER + JUDGED) / 100.0, seed=seed))
        self.controller = make(name)
        self.record = empty_record(self.setup, len(self.controller.estimate_names))
        start, block = start_position(self.setup), self.controller.parameters
        self.state, self.position = run_compiled(block, self.controller.state, self.setup, start, FIRST, self.record)
        self.undisturbed, _ = self.go_on({})

    def go_on(self, replaced):
        """Return the rms error 30 s after inputs were replaced, by sample, and whether all is finite."""
        state, position, setup = copy.deepcopy(self.state), self.position, self.setup
        record = empty_record(setup, len(self.controller.estimate_names))
        record.given[:] = self.record.given
        block, end = self.controller.parameters, FIRST + BAD
        poisoned = Poisoned(block, {FIRST + sample: values for sample, values in replaced.items()})
        kernels = patch.dict(STEPS, {Poisoned: step_poisoned}), patch.dict(ESTIMATES, {Poisoned: without_estimates})
        with kernels[0], kernels[1]:  # for this run only: the registries list the controllers that there are
            state, position = run_plain(poisoned, state, setup, position, end, record)
        finite = is_finite(state)
        state, _ = run_compiled(block, state, setup, position, setup.noise.size, record)
        judged = slice(setup.samples[end + AFTER], None)
        error = float(np.sqrt(np.mean((setup.reference - record.velocity)[judged] ** 2)))
        return error, finite and is_finite(state) and bool(np.all(np.isfinite(record.torque)))
