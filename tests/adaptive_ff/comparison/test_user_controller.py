"""A user's own controller: any object with a method ``step``."""

import math

import numpy as np
import pytest
from closed_loops import SCENARIO

from adaptive_ff import InputError, compare, simulate
from controllers import PI

SHORT = SCENARIO.modified(duration=4.0, controllers=["pi", "oracle"])


class Proportional:
    """The least that a controller can be."""

    def __init__(self, gain):
        self.gain = gain
        self.told = []

    def step(self, reference, velocity, *, next_reference, realised_torque, feedforward, dt):
        self.told.append((next_reference, realised_torque, feedforward, dt))
        return self.gain * (reference - velocity) + feedforward


class Faulty(Proportional):
    """Returns something wrong at the fiftieth sample."""

    def __init__(self, output):
        super().__init__(100.0)
        self.output = output

    def step(self, reference, velocity, *, next_reference, realised_torque, feedforward, dt):
        told = {"next_reference": next_reference, "realised_torque": realised_torque, "feedforward": feedforward}
        torque = super().step(reference, velocity, **told, dt=dt)
        return self.output if len(self.told) == 50 else torque


def test_own_proportional_loop_is_the_pi_loop_without_integral():
    gain = SHORT.feedback.gains[0]
    own = simulate(SHORT, Proportional(gain))
    expected = simulate(SHORT, PI(gain, 0.0, SHORT.sampling.period))
    assert np.ptp(expected.torque) > 100.0
    assert own.torque == pytest.approx(expected.torque, rel=1e-12, abs=1e-12)
    assert own.velocity == pytest.approx(expected.velocity, rel=1e-12, abs=1e-15)
    assert vars(own.metrics) == pytest.approx(vars(expected.metrics), rel=1e-10)
    assert own.name == "Proportional"
    assert own.estimates == {}
    assert not np.any(own.feedforward)


def test_own_controller_is_told_the_preview_the_realised_torque_and_the_time_step():
    scenario = SHORT.modified(actuator={"torque_limit": 30.0})
    controller = Proportional(1000.0)
    run = simulate(scenario, controller)
    following, realised, feedforward, steps = (list(column) for column in zip(*controller.told, strict=True))
    assert np.array_equal(following, run.reference[scenario.substeps :: scenario.substeps])
    assert realised[0] is None
    assert np.array_equal(realised[1:], run.torque[:-1])
    assert np.max(np.abs(run.torque)) == 30.0  # the torque of the drive, not what was asked
    assert set(feedforward) == {0.0}
    assert steps == pytest.approx([scenario.sampling.period] * scenario.samples, rel=1e-12)


class Recording(Proportional):
    """Takes everything, and remembers the positions."""

    def step(self, reference, velocity, *, position, feedforward, dt, **others):
        self.told.append((position, others))
        return self.gain * (reference - velocity) + feedforward


def test_own_controller_is_given_only_what_its_step_accepts():
    class Least(Proportional):
        def step(self, reference, velocity):
            return self.gain * (reference - velocity)

    gain = SHORT.feedback.gains[0]
    assert np.array_equal(simulate(SHORT, Least(gain)).torque, simulate(SHORT, Proportional(gain)).torque)
    recording = Recording(gain)
    simulate(SHORT, recording)
    others = recording.told[7][1]
    assert (others["correction"], others["inertia"]) == (0.0, None)
    assert set(others) == {"next_reference", "correction", "realised_torque", "inertia"}


def test_position_is_the_true_one_rounded_or_the_reading_of_the_encoder():
    resolution = 2e-4
    encoder = {"encoder_resolution": resolution, "velocity_noise": 0.0}
    for sensor, step in ({}, 1e-5), (encoder, resolution):
        scenario = SHORT.modified(sensor=sensor)
        controller = Recording(1000.0)
        run = simulate(scenario, controller)
        found = np.array([position for position, _ in controller.told])
        assert np.ptp(found) > 0.1
        assert found / step == pytest.approx(np.round(found / step), abs=1e-6)
        travelled = np.append(0.0, np.cumsum(run.velocity[:-1]) * scenario.joint.solver_period)
        assert found == pytest.approx(travelled[scenario.sample_steps[:-1]], abs=step + 1e-3)


def test_own_controller_stands_beside_the_others_in_a_comparison():
    gain = SHORT.feedback.gains[0]
    seen = []

    def make(scenario):
        seen.append(scenario)
        return Proportional(scenario.feedback.gains[0])

    comparison = compare(SHORT, own={"mine": make})
    assert list(comparison.runs) == ["pi", "oracle", "mine"]
    assert seen == [SHORT]
    alone = simulate(SHORT, Proportional(gain))
    assert np.array_equal(comparison.runs["mine"].torque, alone.torque)
    result = comparison.to_dict()
    assert result["controllers"]["mine"] == vars(alone.metrics)
    ratio = result["controllers"]["pi"]["rms_error_settled"] / alone.metrics.rms_error_settled
    assert result["improvement"]["mine"] == pytest.approx(ratio, rel=1e-12)


def test_controller_of_the_package_that_is_given_as_object_runs_like_the_named_one():
    controller = PI(*SHORT.feedback.gains, SHORT.sampling.period)
    run = simulate(SHORT, controller, name="mine")
    assert run.name == "mine"
    assert np.array_equal(run.torque, simulate(SHORT, "pi").torque)
    assert controller.state.samples == SHORT.samples  # it ends in the state at the end of the run


@pytest.mark.parametrize("output", [math.nan, math.inf, -math.inf])
def test_torque_that_is_not_finite_is_refused(output):
    with pytest.raises(ValueError, match=rf"Faulty.*torque of {output}; it must be finite"):
        simulate(SHORT, Faulty(output))
    with pytest.raises(ValueError, match="Faulty"):
        compare(SHORT, own={"mine": lambda _: Faulty(output)})


def test_error_within_an_own_controller_is_not_swallowed():
    class Broken:
        def step(self, *_, **__):
            raise LookupError("no such table")

    with pytest.raises(LookupError, match="no such table"):
        simulate(SHORT, Broken())


def test_unknown_name_is_refused_with_those_there_are():
    with pytest.raises(InputError, match=r"'mien' is not known; there are pi, .*mine"):
        compare(SHORT.modified(controllers=["mien"]), own={"mine": lambda _: Proportional(1.0)})
