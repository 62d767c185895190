"""Closed loops for tests: a setup laid by hand, and controllers run on it, some of whose inputs are any numbers."""

import copy
import math
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np
import pytest
from stepped_joint import CompiledJoint, leaves

from adaptive_ff import load_scenario
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.simulation.experiment import build_plain_setup, empty_record
from adaptive_ff.simulation.experiment import build_setup as build_setup
from adaptive_ff.simulation.loop import run_in_memory, run_plain, start_position
from controllers import ESTIMATES, STEPS, Native, compiles, feedback_state, planned_inputs, step, without_estimates
from plant import Actuator


def sampled(values, sample):
    """Parameters of a test: those in the sample in every run, the others nightly."""
    return [pytest.param(value, marks=() if value in sample else pytest.mark.nightly) for value in values]


SCENARIO = load_scenario()

SAMPLE = ("pi", "oracle", "adaptive", "adaptive_paper", "canudas", "disturbance_observer", "repetitive")
"""One of each way to work: feedback, model, both identifiers, bristle observer, disturbance observer, memory."""

ALONE = ("canudas_measured", "coulomb_nominal", "extended_state", "feedback_error", "fixed", "friction_observer")
ALONE += ("kalman_disturbance", "lee_tomizuka", "lugre_gradient", "lugre_observer", "maxwell_adaptive")
ALONE += ("observed_nominal", "pi_inertia", "radial_basis", "super_twisting")

NAMES = (*SAMPLE, *ALONE)
"""Controllers that the checklist runs over: feedforwards that differ in numbers only are checked once."""

LEARNING = ("adaptive", "adaptive_paper", "canudas", "canudas_measured", "feedback_error", "lugre_gradient")
"""Those that identify, which can be switched off."""

identifying = pytest.mark.parametrize("name", sampled(LEARNING, SAMPLE))

LINE_UP = sampled(NAMES, SAMPLE)
"""Controllers as parameters of a test: the sample in every run, the others nightly."""


def make(name, scenario=SCENARIO):
    """Make a controller of the line-up."""
    return CONTROLLERS[name](scenario)


def setup_along(reference, *, joint=SCENARIO.joint, substeps=1, noise=0.0, seed=0, limit=400.0):
    """Run set-up of a joint along a reference on the solver's grid, sampled every so many solver steps."""
    samples = (len(reference) - 1) // substeps
    return build_plain_setup(
        joint,
        np.arange(samples + 1, dtype=np.int64) * substeps,
        np.asarray(reference, dtype=float)[: samples * substeps + 1],
        noise * np.random.default_rng(seed).standard_normal(samples),
        Actuator(torque_limit=limit),
    )


def run_compiled(parameters, state, setup, position, stop, record):
    """Run the loop as ``run_plain`` does, compiled."""
    if not compiles():
        return run_plain(parameters, state, setup, position, stop, record)
    native = Native(parameters, state)
    _, position = run_in_memory(native.addresses, 0, setup, position, stop, record)
    return native.state, position


def drive(controller, setup, *, position=None, run=run_compiled):
    """Run a controller over a setup; return the record and the position at the end."""
    record = empty_record(setup, len(controller.estimate_names))
    start = start_position(setup) if position is None else position._replace(sample=0, acting=-1)
    controller.state, end = run(controller.parameters, controller.state, setup, start, setup.noise.size, record)
    return record, end


def own_loop(controller, setup, *, limit=SCENARIO.actuator.torque_limit, load=0.0, lost=None, watch=None):
    """Run a user's own loop: ``step`` around a joint. Return the torques that the drive gave.

    The joint carries a known load, given as ``feedforward``; measurements in ``lost`` (by sample) are replaced;
    ``watch`` is called with the number of each sample before it.
    """
    joint, realised, torques = CompiledJoint(SCENARIO.joint, float(setup.reference[0])), None, []
    for k, first in enumerate(setup.samples[:-1]):
        measured = joint.state.velocity + setup.noise[k]
        if watch is not None:
            watch(k)
        given = {"next_reference": setup.reference[setup.samples[k + 1]], "realised_torque": realised}
        torque = controller.step(setup.reference[first], (lost or {}).get(k, measured), feedforward=load, **given)
        assert math.isfinite(torque)
        realised = min(max(torque, -limit), limit)
        torques.append(realised)
        joint.step(realised - load, (setup.samples[k + 1] - first) * setup.solver_period)
    return np.array(torques)


def error_of(setup, record, seconds):
    """Root of the mean square error over the last seconds."""
    last = round(seconds / setup.solver_period)
    return float(np.sqrt(np.mean((setup.reference - record.velocity)[-last:] ** 2)))


def plan_inputs(reference, next_reference, acting=math.nan, next_acting=math.nan):
    """Inputs with a plan now and at the next sample, and for when the torque acts, rad/s, and nothing else."""
    inputs = planned_inputs(reference, math.nan, next_reference, math.nan, 0.01)
    return inputs._replace(acting_reference=acting, next_acting_reference=next_acting)


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
    return all(np.all(np.isfinite(leaf)) for leaf in leaves(value))


class Learnt:
    """A controller that has learnt, to be run on with bad inputs again and again."""

    def __init__(self, name):
        self.setup = build_setup(SCENARIO.modified(duration=(FIRST + BAD + AFTER + JUDGED) / 100.0, seed=101))
        self.controller = make(name)
        self.record = empty_record(self.setup, len(self.controller.estimate_names))
        start, block = start_position(self.setup), self.controller.parameters
        self.state, self.position = run_compiled(block, self.controller.state, self.setup, start, FIRST, self.record)
        self.undisturbed, _ = self.go_on({})

    def go_on(self, replaced):
        """Return the rms error 30 s after inputs were replaced, by sample, and whether all is finite."""
        state, position, setup, block = copy.deepcopy(self.state), self.position, self.setup, self.controller.parameters
        record = empty_record(setup, len(self.controller.estimate_names))
        record.given[:] = self.record.given
        first, last = FIRST + min(replaced, default=0), FIRST + max(replaced, default=0) + 1
        state, position = run_compiled(block, state, setup, position, first, record)
        poisoned = Poisoned(block, {FIRST + sample: values for sample, values in replaced.items()})
        kernels = patch.dict(STEPS, {Poisoned: step_poisoned}), patch.dict(ESTIMATES, {Poisoned: without_estimates})
        with kernels[0], kernels[1]:  # for this run only: the registries list the controllers that there are
            state, position = run_plain(poisoned, state, setup, position, last, record)
        finite = is_finite(state)
        state, _ = run_compiled(block, state, setup, position, setup.noise.size, record)
        judged = slice(setup.samples[FIRST + BAD + AFTER], None)
        error = float(np.sqrt(np.mean((setup.reference - record.velocity)[judged] ** 2)))
        return error, finite and is_finite(state) and bool(np.all(np.isfinite(record.torque)))
