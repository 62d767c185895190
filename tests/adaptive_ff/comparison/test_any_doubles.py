"""Whatever numbers a controller is given, torque and state stay finite, and it recovers."""

import math
from functools import cache

import pytest
from closed_loops import BAD, LINE_UP, Learnt, is_finite, make
from hypothesis import HealthCheck, Phase, example, given, settings
from hypothesis import strategies as st

from controllers import Inputs, feedback_state, planned_inputs

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

POISONS = [
    ("velocity", 1e306),
    ("realised_torque", 1e160),
    ("next_reference", 1e155),
    ("reference", 1e160),
    ("dt", 1e306),
    ("dt", 5e-324),
    ("feedforward", 1e160),
    ("realised_torque", 1e12),
    ("reference", 1e12),
]
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
