"""Columns are learnt and fed: by ripple, position, and one that is made up."""

import math

import numpy as np
import pytest
from closed_loops import SCENARIO

from adaptive_ff import WITH_OFFSET, AdaptiveController, simulate
from adaptive_ff.report.diagnosis import map_sentences
from tests.helpers.driven_joint import drive, known_position, make, reference_joint, rms

END = 40.0


def late(run):
    return rms(run.error[run.time > 0.5 * END])


def test_a_column_that_is_made_up_is_learnt_and_fed():
    """A torque that grows with the square of a known temperature."""

    def temperature(time):
        return 1.0 + 0.5 * math.sin(0.7 * time)

    load = {"load": lambda time, position: -40.0 * temperature(time) ** 2}
    informed, blind = make(regressors=1), make()
    seeing = drive(informed, reference_joint(), 0.0, END, regressors=lambda t, q: [temperature(t) ** 2], **load)
    alone = drive(blind, reference_joint(), 0.0, END, **load)
    assert late(seeing) < 1.02 * late(alone)
    assert abs(informed.estimates["regressor_1"]) == pytest.approx(40.0, rel=0.25)


def test_a_ripple_of_a_known_period_is_learnt_and_fed():
    def ripple(time, position):
        return 30.0 * math.sin(2.0 * math.pi * position / 0.2)

    informed, blind = make(ripple_periods=[0.2]), make()
    seeing, alone = (
        drive(one, reference_joint(), 0.0, END, load=ripple, position=known_position) for one in (informed, blind)
    )
    assert late(seeing) < 0.8 * late(alone)
    assert informed.estimates["ripple_sin_1"] == pytest.approx(30.0, abs=5.0)


@pytest.mark.parametrize("asked", [{"position_periods": [1.0]}, {"position_hats": 21, "position_range": [0.0, 2.0]}])
def test_friction_over_position_is_learnt_fed_and_told(asked):
    scenario = SCENARIO.modified(
        seed=3,
        duration=120.0,
        variation={"position_amplitude": 0.4, "position_period": 1.0},
        sampling={"period": 0.002},
    )
    limit = {"torque_limit": 400.0}
    base = {"inertia": 20.0, "stribeck_velocity": 0.05, "parameters": WITH_OFFSET, **limit}
    informed = AdaptiveController(*scenario.feedback.gains, 0.002, **base, **asked)
    blind = AdaptiveController(*scenario.feedback.gains, 0.002, **base)
    errors = [simulate(scenario, one).metrics.rms_error_settled for one in (informed, blind)]
    assert errors[0] < 0.9 * errors[1]
    if "position_periods" in asked:
        learnt = informed.learnt_map
        truth = 1.0 + 0.4 * np.sin(2.0 * math.pi * learnt.position)
        assert np.max(np.abs(learnt.factor - truth)) < 0.15
        (said,) = map_sentences(learnt)
        assert "repeats every 1 rad" in said
