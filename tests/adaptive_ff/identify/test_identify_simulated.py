"""Identification of simulated joints: what a simulation was given comes back."""

import numpy as np
import pytest

from adaptive_ff import Log, identify_log, load_scenario, simulate

LOOP = load_scenario().modified(duration=20.0, sampling={"period": 0.001}, sensor={"velocity_noise": 0.0})


@pytest.mark.parametrize("seed", range(6))
def test_parameters_that_a_joint_was_simulated_with_come_back(seed):
    scale = np.random.default_rng(seed).uniform(0.5, 1.5, 4)
    joint = dict(zip(("inertia", "coulomb", "viscous", "offset"), scale * (20.0, 50.0, 80.0, 10.0), strict=True))
    scenario = LOOP.modified(seed=seed, joint={**joint, "stiction": joint["coulomb"], "friction_lag": 0.0})
    run = simulate(scenario, "pi")
    found = identify_log(Log("run", run.time, run.torque, velocity=run.measured), torque_delay=0.0005)
    for name, true in joint.items():
        assert found.parameters[name].value == pytest.approx(true, rel=0.03), (seed, name)
