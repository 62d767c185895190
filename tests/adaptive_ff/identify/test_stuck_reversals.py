"""A joint that sticks at its reversals, for less than a cycle of the band: what it does there is not regressed."""

import numpy as np
import pytest

from adaptive_ff import simulate
from adaptive_ff.identify.filtering import STOP_CYCLES, _at_rest
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.logs.log import Log
from benchmarks.never_worse import named_scenario

SIGNS = {
    "reverses": ([1.0] * 10 + [-1.0] * 10, False),
    "sticks and reverses": ([1.0] * 6 + [-1.0, 1.0] * 4 + [-1.0] * 6, True),
    "stops and goes on": ([1.0] * 6 + [-1.0, 1.0] * 7, False),
}


@pytest.mark.parametrize("name", SIGNS)
def test_a_short_stop_is_told_from_a_reversal_by_the_signs_of_its_velocity(name):
    signs, stands = SIGNS[name]
    slow = np.ones(len(signs), dtype=np.bool_)
    assert _at_rest(np.array(signs), slow, 100.0, sticks=True).all() == stands
    assert not _at_rest(np.array(signs), slow, 100.0, sticks=False).any()
    assert not _at_rest(np.array(signs), slow, 1.1 * len(signs) / STOP_CYCLES, sticks=True).any()
    assert _at_rest(np.array(signs), slow, 20.0, sticks=False).all()


@pytest.mark.parametrize("seed", [101, 103])
def test_friction_of_a_fast_loop_is_found_within_its_intervals(seed):
    """Stiction came out at 2.55 and 2.63 N m for 2.5 and Coulomb friction at 2.02 and 2.09 for 2, surely."""
    scenario = named_scenario("data_sheet", seed).modified(duration=60.0)
    run, joint = simulate(scenario, "pi", uncertain=False), scenario.joint
    path = np.concatenate([[0.0], np.cumsum(0.5 * (run.velocity[1:] + run.velocity[:-1]) * joint.solver_period)])
    period, size = scenario.sampling.period, run.torque.size
    position = path[:: round(period / joint.solver_period)][:size]
    position += 1e-6 * np.random.default_rng(seed).standard_normal(size)
    log = Log("fast loop", period * np.arange(size), run.torque, position, None)
    found = identify_log(log, torque_delay=0.5 * period)
    for name in ("inertia", "coulomb", "stiction", "viscous", "stribeck_velocity"):
        estimate = found.parameters[name].estimate
        assert estimate.lower < getattr(joint, name) < estimate.upper, name
