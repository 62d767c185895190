"""Identification of simulated joints: what a simulation was given comes back."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from adaptive_ff import Log, identify_log, load_scenario, simulate

LOOP = load_scenario().modified(duration=20.0, sampling={"period": 0.001}, sensor={"velocity_noise": 0.0})


@settings(max_examples=6)
@given(
    st.floats(0.5, 1.5),
    st.floats(0.3, 1.5),
    st.floats(0.3, 1.5),
    st.floats(-20.0, 20.0),
    st.integers(1, 1000),
)
def test_parameters_that_a_joint_was_simulated_with_come_back(inertia, coulomb, viscous, offset, seed):
    joint = {"inertia": 20.0 * inertia, "coulomb": 60.0 * coulomb, "viscous": 80.0 * viscous, "offset": offset}
    scenario = LOOP.modified(seed=seed, joint={**joint, "stiction": joint["coulomb"], "friction_lag": 0.0})
    run = simulate(scenario, "pi")
    found = identify_log(Log("run", run.time, run.torque, velocity=run.measured), torque_delay=0.0005)
    for name, true in joint.items():
        one = found.parameters[name]
        assert one.upper - one.lower < 0.3 * true or name == "offset"
        assert one.value == pytest.approx(true, abs=one.upper - one.lower + 0.01 * abs(true) + 0.1), name
