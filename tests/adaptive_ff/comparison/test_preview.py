"""A drive that is late: the plan of when a torque acts reaches every controller, in every way that one is stepped."""

import math

import numpy as np
import pytest
from closed_loops import build_setup, make

from adaptive_ff import JointGroup, load_scenario, simulate
from adaptive_ff.comparison.running import Drive
from adaptive_ff.scenario.library import SCENARIOS

STOPS = load_scenario().modified(
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
    scenario = load_scenario(SCENARIOS / "delay_unknown.toml")
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
