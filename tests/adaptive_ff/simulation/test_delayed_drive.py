"""Drives with a computation delay: every controller knows how long it is."""

import numpy as np
import pytest
from closed_loops import SCENARIO, build_setup, drive, error_of

from adaptive_ff.adaptive.controller import AdaptiveController
from adaptive_ff.baselines.model_based import ModelBased
from adaptive_ff.baselines.paper import PaperController
from adaptive_ff.friction.model import ESTIMATED, PER_DIRECTION
from adaptive_ff.scenario.truth import true_model
from adaptive_ff.simulation.loop import NEVER
from controllers import PI, pi_gains
from plant import Joint

GAINS, PERIOD = pi_gains(20.0, 5.0), SCENARIO.sampling.period
ASSUMED = {"inertia": 20.0, "stribeck_velocity": 0.05}
LONG = SCENARIO.modified(seed=103, duration=40.0)
UNEQUAL = {"coulomb": 75.0, "stiction": 95.0, "viscous": 60.0, "offset": -20.0}
UNEQUAL |= {"coulomb_backward": 45.0, "stiction_backward": 80.0, "viscous_backward": 110.0}


def adaptive(delay, parameters=ESTIMATED):
    return AdaptiveController(*GAINS, PERIOD, **ASSUMED, parameters=parameters, delay=delay)


def oracle(delay, scenario=SCENARIO):
    return ModelBased(*GAINS, PERIOD, true_model(scenario), delay=delay)


def error(controller, delay, scenario=LONG):
    """Settled error behind a drive with a computation delay, in periods; the reference of then is not known."""
    setup, late = build_setup(scenario), round(delay * PERIOD / scenario.joint.solver_period)
    setup = setup._replace(delay=late, lead=NEVER)
    return error_of(setup, drive(controller, setup)[0], 15.0)


def test_adaptive_controller_finds_unequal_directions_behind_a_delay():
    """One reference alone says little: the ratio to the oracle is 0.8 to 1.6, by when the joint reverses."""
    ratios, lags, offsets = [], [], []
    for seed in range(103, 111):
        scenario, controller = LONG.modified(seed=seed, joint=UNEQUAL), adaptive(1.0, PER_DIRECTION)
        ratios.append(error(controller, 1.0, scenario) / error(oracle(1.0, scenario), 1.0, scenario))
        lags.append(controller.estimates["friction_lag"])
        offsets.append(controller.estimates["offset"])
    assert np.exp(np.mean(np.log(ratios))) < 1.15
    assert np.mean(offsets) == pytest.approx(true_model(scenario).offset, abs=2.0)
    assert np.mean(lags) == pytest.approx(0.02, abs=0.005)


MAKERS = {
    "PI": lambda delay: PI(*GAINS, PERIOD, delay=delay),
    "ModelBased": oracle,
    "PaperController": lambda delay: PaperController(*GAINS, PERIOD, **ASSUMED, delay=delay),
    "AdaptiveController": adaptive,
}
controllers = pytest.mark.parametrize("make", MAKERS.values(), ids=MAKERS)


@pytest.fixture(scope="module")
def setup():
    return build_setup(SCENARIO.modified(seed=104, duration=5.0))


def own_loop(controller, setup, delay, *, known=None):
    """Run ``step`` around a joint behind a drive whose torque acts a delay, in periods, after its sample.

    ``known`` are loads, a sample each, given as ``feedforward``; each acts while the torque of its sample does.
    Return the velocities at the samples and the torques.
    """
    whole, rest = int(delay), delay - int(delay)
    joint, realised, velocities, torques = Joint(SCENARIO.joint, float(setup.reference[0])), None, [], []
    loads = np.zeros(setup.noise.size) if known is None else known
    for k, (first, last) in enumerate(zip(setup.samples[:-1], setup.samples[1:], strict=True)):
        velocities.append(joint.state.velocity)
        given = {"next_reference": setup.reference[last], "realised_torque": realised, "feedforward": loads[k]}
        torques.append(controller.step(setup.reference[first], joint.state.velocity + setup.noise[k], **given))
        parts = ((k - whole - 1, rest), (k - whole, 1.0 - rest))
        acting = [(torques[i], loads[i], part) if i >= 0 else (0.0, 0.0, part) for i, part in parts]
        for torque, load, part in acting:
            if part > 0.0:
                joint.step(torque - load, part * PERIOD)
        realised = sum(torque * part for torque, _, part in acting)
    return np.array(velocities), np.array(torques)


@controllers
@pytest.mark.parametrize("delay", [0.0, 1.0, 1.5])
def test_load_that_is_told_for_when_the_drive_acts_changes_no_motion(make, delay, setup):
    load = 30.0 * np.sin(0.05 * np.arange(setup.noise.size))
    free, free_torques = own_loop(make(delay), setup, delay)
    loaded, torques = own_loop(make(delay), setup, delay, known=load)
    assert loaded == pytest.approx(free, abs=1e-6)
    assert torques - load == pytest.approx(free_torques, abs=1e-2)


@controllers
def test_compiled_equals_plain_and_a_saved_state_goes_on(make, setup):
    _, expected = own_loop(make(1.5).run_uncompiled(), setup, 1.5)
    controller = make(1.5)
    _, found = own_loop(controller, setup, 1.5)
    assert found == pytest.approx(expected, rel=1e-12)
    other = make(1.5)
    other.state_from_json(controller.state_to_json())
    assert other.step(0.1, 0.09, realised_torque=50.0) == controller.step(0.1, 0.09, realised_torque=50.0)
