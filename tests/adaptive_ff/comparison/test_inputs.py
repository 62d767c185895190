"""What every controller makes of its inputs, among them any numbers."""

import math
from functools import cache

import numpy as np
import pytest
from closed_loops import BAD, LINE_UP, SAMPLE, SCENARIO, Learnt, build_setup, is_finite, make, sampled
from hypothesis import HealthCheck, Phase, example, given, settings
from hypothesis import strategies as st

from adaptive_ff import JointGroup, load_scenario, simulate
from adaptive_ff.comparison.registry import CONTROLLERS, FIXED
from adaptive_ff.comparison.running import Drive
from adaptive_ff.simulation.loop import NEVER, inputs_at, planned_at
from controllers import PI, Inputs, feedback_state, planned_inputs

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


MOVES = {"kind": "point_to_point", "distance": 0.4, "speed": 0.3, "acceleration": 1.0, "dwell": 1.0}
LATE = {"actuator": {"delay": 0.02}, "feedback": {"bandwidth": 3.0}}
STOPS = SCENARIO.modified(seed=101, duration=20.0, reference=MOVES, **LATE)
"""Moves with rests between them, by a drive that is late by two periods."""

FED = {"adaptive": 0.8, "adaptive_unsupervised": 0.8, "fixed": 0.8, "friction_observer": 0.8, "canudas": 0.95}
FED |= {"feedback_error": 0.95, "disturbance_observer": 1.02}
"""Controllers that feed the plan forward, and their largest error with the plan known over that by extrapolation."""


def blind(setup):
    """The same setup; the plan is known up to the next sample."""
    return setup._replace(lead=NEVER)


@pytest.mark.parametrize("delay", [0.0, 0.01, 0.015])
def test_the_plan_is_that_of_when_the_torque_acts(delay):
    scenario = STOPS.modified(actuator={"delay": delay}, duration=6.0)
    setup = build_setup(scenario)
    times = setup.samples * setup.solver_period + delay
    known = times < 6.0 + 1e-9
    wanted = np.interp(times, scenario.times(), setup.reference)
    acting = np.array([planned_at(setup, place + setup.lead) for place in setup.samples])
    assert acting[known] == pytest.approx(wanted[known], abs=1e-12)
    assert np.all(np.isnan(acting[~known]))
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
    assert Drive(make("adaptive", scenario), setup).setup.lead == setup.lead == 0
    seen = Drive(make("oracle", scenario), setup).setup
    assert seen.lead == round(scenario.actuator.delay / setup.solver_period) > 0
    given, later = inputs_at(seen, 7, 0.0, 0.0, 0.0, math.nan, 0.01), setup.samples[7:9] + seen.lead
    assert [given.acting_reference, given.next_acting_reference] == setup.reference[later].tolist()


def test_of_a_sample_that_comes_late_no_plan_knows():
    scenario = load_scenario("jittered_22ms")
    setup = build_setup(scenario)
    late = int(np.argmax(np.diff(setup.samples)))
    planned = setup.samples[late] + round(scenario.sampling.period / setup.solver_period)
    assert planned < setup.samples[late + 1]
    given = inputs_at(setup, late, 0.0, 0.0, 0.0, math.nan, 0.022)
    assert given.next_reference == given.next_acting_reference == setup.reference[planned]


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
def test_half_of_a_plan_is_not_used(name):
    controller, other = make("fixed", STOPS), make("fixed", STOPS)
    assert controller.step(0.1, 0.1, next_reference=0.12, **{name: 0.2}) == other.step(0.1, 0.1, next_reference=0.12)


PERIOD = 0.01
BRIEF = {
    "deadline": None,
    "suppress_health_check": [HealthCheck.too_slow],
    "phases": [Phase.explicit, Phase.reuse, Phase.generate],  # shrinking a run of seconds takes minutes
}
ANY = st.floats(allow_nan=True, allow_infinity=True)
TURNS = st.lists(ANY, min_size=1, max_size=4)
BURST = st.tuples(st.sampled_from(Inputs._fields), st.integers(0, BAD - 1), st.sampled_from([1, 1, 3, 20, BAD]), TURNS)
"""Bad values of one input: name, first sample, length, values in turn."""

WRONG_PLAN = [
    ("inertia", 69, 200, [3.5473302119657204e16, 2.674475009827795e-303]),
    ("dt", 185, 20, [4.4834821360114245e-222]),
    ("correction", 67, 20, [-2.2250738585e-313, -1.3817937149824649e51]),
    ("next_reference", 64, 200, [-8.055006565480604e-171, 0.0, 6.809320406111372e16, -3.189454993709511e16]),
]
"""Bad values that made short bristles of a lag, for good: the plan is said to come to rest at every other sample."""

COMING = [
    ("acting_reference", 177, 3, [-3.239994046607081e118, -6400299447278157.0, 0.0]),
    ("next_acting_reference", 53, 200, [0.0, 1277.6899704385896, -0.4388204927874766]),
]
"""A plan for when torques act, half of it wrong: it threw the joint, and the friction lag was lost for minutes."""

HALF_TOLD = [("realised_torque", 150, 50, [0.0, math.nan, math.nan])]
"""A drive that reports wrongly, and now and then only: the doubt about it stayed for good, with less friction fed."""

POISONS = [("velocity", 1e306), ("realised_torque", 1e160), ("next_reference", 1e155), ("reference", 1e160)]
POISONS += [("dt", 1e306), ("dt", 5e-324), ("feedforward", 1e160), ("realised_torque", 1e12), ("reference", 1e12)]
"""What was found to poison a state for good, alone."""


def replaced(bursts):
    """Values by sample and name of the input."""
    values = {}
    for name, first, length, turns in bursts:
        for sample in range(first, min(first + length, BAD)):
            values.setdefault(sample, {})[name] = turns[sample % len(turns)]
    return values


@cache
def learnt(name):
    return Learnt(name)


@pytest.mark.parametrize("name", LINE_UP)
@settings(max_examples=10, **BRIEF)
@given(rows=st.lists(st.tuples(*[ANY] * len(Inputs._fields)), min_size=1, max_size=30))
@example(rows=[tuple(value if field == name else 0.01 for field in Inputs._fields) for name, value in POISONS])
def test_torque_and_state_stay_finite_on_any_doubles(name, rows):
    """In open loop, where nothing limits what sums up: the kernel in plain Python, good samples before and after."""
    controller = make(name).run_uncompiled()
    good = planned_inputs(0.1, 0.09, 0.1, 80.0, PERIOD)
    for inputs in [good] * 3 + [Inputs(*row) for row in rows] + [good] * 3:
        output = controller.step_plain(inputs)
        assert math.isfinite(output.torque)
        assert is_finite(controller.state)
    assert feedback_state(controller.state).guard.lost == 0.0


TAUGHT = pytest.mark.xfail(reason="a plan that leaps to what a machine can just have teaches for more than 30 s")


@pytest.mark.parametrize("name", ["pi", pytest.param("adaptive", marks=TAUGHT)])
@settings(max_examples=4, **BRIEF)
@given(bursts=st.lists(BURST, min_size=1, max_size=5))
@example(bursts=[("reference", 79, 200, [1e-9]), ("next_reference", 79, 1, [1e-9])])
@example(bursts=WRONG_PLAN)
@example(bursts=HALF_TOLD)
@example(bursts=COMING)
@example(bursts=[("next_reference", 102, 3, [9.6e-283]), ("realised_torque", 169, 1, [1.2e294])])
@example(bursts=[("dt", 110, 20, [-1.0, -1.0, 1.8, -1.0])])
@example(bursts=[("feedforward", 87, 200, [0.0, 3600.0, math.nan, math.nan])])
def test_thirty_seconds_after_bad_inputs_it_tracks_as_undisturbed(name, bursts):
    """Examples: what a joint does while its plan stands still for 2 s, or is not known ahead, looks like bristles.

    The last but one has periods of 1.8 s, over which the torque of a moment is none; no friction was trusted after it.
    The last one has a torque that is held while it is not known, and throws the joint when it ends: what brings it back
    was taken for friction that it lacks.
    """
    case = learnt(name)
    error, finite = case.go_on(replaced(bursts))
    assert finite
    assert error <= 1.3 * case.undisturbed


@pytest.mark.parametrize(("field", "value"), POISONS)
def test_one_absurd_value_is_forgotten(field, value):
    case = learnt("adaptive")
    error, finite = case.go_on({100: {field: value}})
    assert finite
    assert error <= 1.02 * case.undisturbed


def test_absurd_inputs_are_counted_and_a_long_loss_is_told():
    controller = make("adaptive")
    controller.step(0.2, 0.1)
    assert (controller.rejected, controller.faults, controller.fault) == (0, 0, False)
    controller.step(0.1, 1e306, realised_torque=1e160)
    assert (controller.rejected, controller.faults, controller.fault) == (1, 1, False)
    torques = [controller.step(0.1, math.nan) for _ in range(310)]
    assert controller.fault is True
    assert torques[100] != 0.0
    assert torques[-1] == 0.0
    controller.step(0.1, 0.1)
    assert controller.fault is False
