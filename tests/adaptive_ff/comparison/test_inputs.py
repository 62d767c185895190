"""Plan, correction and the delay of a drive reach every controller in the same way, however it is stepped."""

import math

import numpy as np
import pytest
from closed_loops import SAMPLE, SCENARIO, build_setup, make, sampled

from adaptive_ff import JointGroup, load_scenario, simulate
from adaptive_ff.comparison.registry import CONTROLLERS, FIXED
from adaptive_ff.comparison.running import Drive
from controllers import PI, feedback_state

NAMES = [name for name in CONTROLLERS if name not in FIXED]
SAMPLES = 150
CORRECTED = ("lugre_observer", "maxwell_adaptive", "radial_basis")
"""Their law corrects what is fed by the tracking error, of which the correction is a part; with no switch for it."""


def switched_off(name):
    controller = CONTROLLERS[name](SCENARIO).run_uncompiled()
    if hasattr(controller, "enabled"):
        controller.enabled = False  # what is learnt may differ; how it is fed may not
    return controller


def torques(controller, correction):
    """Torques along a motion with reversals, for given corrections and realised torques."""
    period, found = controller.period, []
    for k in range(SAMPLES):
        now, following = (0.3 * math.sin(6.0 * period * sample) for sample in (k, k + 1))
        velocity = now - 0.01 * math.cos(9.0 * period * k)
        given = {"realised_torque": 50.0 * math.sin(0.1 * k) if k else None, "correction": correction[k]}
        found.append(controller.step(now, velocity, next_reference=following, **given))
    return np.array(found)


@pytest.mark.parametrize("name", sampled([name for name in NAMES if name not in CORRECTED], SAMPLE))
def test_correction_is_seen_by_the_feedback_alone(name):
    """The torque differs by exactly what the PI loop makes of the correction.

    What ``adaptive`` learns and observes of a joint that does not answer to it differs as well: there to a sixth.
    """
    correction = 0.05 * np.random.default_rng(101).standard_normal(SAMPLES)
    controller = switched_off(name)
    loop = feedback_state(controller.parameters)
    feedback = (loop.proportional, loop.integral)  # where an observer integrates, there is none
    assert feedback[0] == SCENARIO.feedback.gains[0]
    found = torques(controller, correction) - torques(switched_off(name), np.zeros(SAMPLES))
    pair = [PI(*feedback, controller.period, delay=SCENARIO.delay).run_uncompiled() for _ in range(2)]
    expected = torques(pair[0], correction) - torques(pair[1], np.zeros(SAMPLES))
    assert np.ptp(expected) > 50.0
    tolerance = np.ptp(expected) / 6.0 if name == "adaptive" else 1e-9
    assert found == pytest.approx(expected, abs=tolerance)


STOPS = SCENARIO.modified(
    seed=101,
    duration=20.0,
    actuator={"delay": 0.02},
    feedback={"bandwidth": 3.0},
    reference={"kind": "point_to_point", "distance": 0.4, "speed": 0.3, "acceleration": 1.0, "dwell": 1.0},
)
"""Moves with rests between them, by a drive that is late by two periods."""

FED = {"adaptive": 0.8, "adaptive_unsupervised": 0.8, "fixed": 0.8, "friction_observer": 0.8, "canudas": 0.95}
FED |= {"feedback_error": 0.95, "disturbance_observer": 1.02}
"""Controllers that feed the plan forward, and their largest error with the plan known over that by extrapolation."""


def blind(setup):
    """The same setup; the plan is known up to the next sample."""
    return setup._replace(acting=np.full_like(setup.acting, math.nan))


@pytest.mark.parametrize("delay", [0.0, 0.01, 0.015])
def test_the_plan_is_that_of_when_the_torque_acts(delay):
    scenario = STOPS.modified(actuator={"delay": delay}, duration=6.0)
    setup = build_setup(scenario)
    times = setup.samples * setup.solver_period + delay
    known = times < 6.0 + 1e-9
    wanted = np.interp(times, scenario.times(), setup.reference)
    assert setup.acting[known] == pytest.approx(wanted[known], abs=1e-12)
    assert np.all(np.isnan(setup.acting[~known]))
    assert np.count_nonzero(~known) == math.ceil(delay / 0.01)


@pytest.mark.parametrize(("name", "most"), FED.items())
def test_with_it_a_controller_tracks_better_than_by_extrapolation(name, most):
    setup = build_setup(STOPS)
    with_plan, without = (simulate(STOPS, name, setup=one).metrics for one in (setup, blind(setup)))
    assert with_plan.rms_error_settled < most * without.rms_error_settled


def test_each_controller_is_given_the_plan_for_the_delay_that_it_reckons_with():
    """All but the oracle reckon with the one that the scenario tells, here none."""
    scenario = load_scenario("delay_unknown")
    setup = build_setup(scenario)
    assert Drive(make("adaptive", scenario), setup).setup is setup
    assert setup.lead == 0
    seen = Drive(make("oracle", scenario), setup).setup
    assert seen.lead == round(scenario.actuator.delay / setup.solver_period) > 0
    later = setup.samples + seen.lead
    inside = later < setup.reference.size
    assert np.array_equal(seen.acting[inside], setup.reference[later[inside]])


def test_a_group_hands_it_to_each_joint():
    alone, *both = (make("adaptive", STOPS) for _ in range(3))
    grouped = JointGroup(dict(zip(("one", "two"), both, strict=True)))
    for k in range(50):
        plan = [0.1 * math.sin(0.1 * (k + ahead)) for ahead in (0, 1, 2, 3)]
        ahead = {"acting_reference": [plan[2], math.nan], "next_acting_reference": [plan[3], math.nan]}
        found = grouped.step([plan[0]] * 2, [plan[0]] * 2, next_reference=[plan[1]] * 2, **ahead)
        known = {"next_reference": plan[1], "acting_reference": plan[2], "next_acting_reference": plan[3]}
        assert found[0] == alone.step(plan[0], plan[0], **known)
    assert found[1] != found[0]


@pytest.mark.parametrize("name", ["acting_reference", "next_acting_reference"])
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_plan_that_is_no_number_is_refused_and_half_of_one_not_used(name, value):
    controller, other = make("fixed", STOPS), make("fixed", STOPS)
    plan = {"acting_reference": 0.2, "next_acting_reference": 0.21}
    with pytest.raises(ValueError, match=f"^{name} = {value} is not allowed"):
        controller.step(0.1, 0.1, next_reference=0.12, **{**plan, name: value})
    assert controller.step(0.1, 0.1, next_reference=0.12, **{name: 0.2}) == other.step(0.1, 0.1, next_reference=0.12)
