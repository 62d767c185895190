"""A joint that sticks at its reversals, for less than a cycle of the band: what it does there is not regressed."""

import numpy as np
import pytest
from dry_joint import dry_joint_log

from adaptive_ff import simulate
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.identify.rows.standing import STOP_CYCLES, at_rest
from adaptive_ff.identify.terms import BASE, LAG, SATURATION, STICTION, jumps_at_reversal
from adaptive_ff.logs.log import Log
from benchmarks.cases.situations import named_scenario

SIGNS = {
    "reverses": ([1.0] * 10 + [-1.0] * 10, False),
    "sticks and reverses": ([1.0] * 6 + [-1.0, 1.0] * 4 + [-1.0] * 6, True),
    "stops and goes on": ([1.0] * 6 + [-1.0, 1.0] * 7, True),
}


STEPS = 2e-3
"""Relative error that the steps of the simulated joint may leave."""


def rests(velocity, cycle, *, sticks):
    return at_rest(np.array(velocity), 1.0, cycle, 10, sticks=sticks)


@pytest.mark.parametrize("name", SIGNS)
def test_a_short_stop_is_told_from_a_reversal_by_the_signs_of_its_velocity(name):
    signs, stands = SIGNS[name]
    slow = 0.5 * np.array(signs)
    assert rests(slow, 100.0, sticks=True).all() == stands
    assert not rests(slow, 100.0, sticks=False).any()
    assert at_rest(slow, 1.0, 100.0, None, sticks=True).all() == (name == "sticks and reverses")
    assert not rests(slow, 1.1 * len(signs) / STOP_CYCLES, sticks=True).any()
    assert rests(slow, 20.0, sticks=False).all()


@pytest.mark.parametrize(("stop", "stands"), [(0, False), (4, False), (16, True)])
@pytest.mark.parametrize("starting", [0.1, 0.3])
def test_a_stop_too_short_for_that_is_told_by_how_long_the_joint_is_slow(stop, stands, starting):
    """Braking and starting at other accelerations, as friction that jumps makes it, is no stop."""
    velocity = np.concatenate([0.1 * np.arange(40.0, 0.0, -1.0), np.zeros(stop), -starting * np.arange(1.0, 41.0)])
    assert rests(velocity, 1000.0, sticks=True).any() == stands
    assert not rests(velocity, 1000.0, sticks=False).any()
    assert not rests(np.abs(velocity), 1000.0, sticks=True).any()
    assert not at_rest(velocity, 1.0, 1000.0, None, sticks=True).any()


@pytest.mark.parametrize("seed", [101, 103])
def test_friction_of_a_fast_loop_is_found_within_its_intervals(seed):
    """Stiction came out at 2.55 and 2.63 N m for 2.5 and Coulomb friction at 2.02 and 2.09 for 2, surely.

    Intervals are narrower than what steps of the simulated joint leave, 0.01 % of the inertia (steps of 1 ms: 0.06 %).
    """
    scenario = named_scenario("data_sheet", seed).modified(duration=60.0, joint={"solver_period": 1e-4})
    run, joint = simulate(scenario, "pi", uncertain=False), scenario.joint
    path = np.concatenate([[0.0], np.cumsum(0.5 * (run.velocity[1:] + run.velocity[:-1]) * joint.solver_period)])
    period, size = scenario.sampling.period, run.torque.size
    position = path[:: round(period / joint.solver_period)][:size]
    position += 1e-6 * np.random.default_rng(seed).standard_normal(size)
    log = Log("fast loop", period * np.arange(size), run.torque, position, None)
    found = identify_log(log, torque_delay=0.5 * period)
    for name in ("inertia", "coulomb", "stiction", "viscous", "stribeck_velocity"):
        estimate = found.parameters[name].estimate
        true = getattr(joint, name)
        assert estimate.lower - STEPS * true < true < estimate.upper + STEPS * true, name


def test_dry_joint_that_sticks_at_its_reversals_is_found_within_its_intervals():
    """Friction was outside its interval in four of the first eight logs, and seemed to lead the motion in four.

    Inertia was in three of 16 while rows beside a stop had what the filter carries into them. Where friction still is,
    in three, it is within 0.4 %.
    """
    held, leads = dict.fromkeys(("inertia", "coulomb", "viscous"), 0), 0
    for seed in range(201, 217):
        log, joint = dry_joint_log(seed)
        found = identify_log(log, torque_delay=0.5 * float(log.time[1]), held_out=0.0)
        for name, true in joint.items():
            estimate = found.parameters[name].estimate
            held[name] += estimate.lower <= true <= estimate.upper
        leads += any("lead the motion" in caution for caution in found.cautions)
    assert min(held["coulomb"], held["viscous"]) >= 12
    assert held["inertia"] >= 15
    assert leads == 0


def test_inertia_of_a_dry_joint_is_right_though_it_sticks_for_moments_only():
    """It was up to 0.4 % too large."""
    errors = []
    for seed in range(301, 309):
        log, joint = dry_joint_log(seed)
        found = identify_log(log, torque_delay=0.5 * float(log.time[1]), held_out=0.0)
        errors.append(abs(found.parameters["inertia"].estimate.value / joint["inertia"] - 1.0))
    assert max(errors) < 0.003


@pytest.mark.parametrize("seed", [204, 205])
def test_what_the_sign_tells_to_stand_stays_out_where_the_rest_seems_to_creep(seed):
    """The stops of this joint are so long that the sign tells all of them; a delay that is not told makes a lag.

    Then all rows came back, and 3 and 5 % of the torque were left.
    """
    log, _ = dry_joint_log(seed, inertia=0.5, noise=0.001)
    found = identify_log(log, held_out=0.0)
    assert not jumps_at_reversal(found.selection.chosen.terms)
    assert found.fit.relative_error < 0.002


@pytest.mark.parametrize(
    ("terms", "jumps"), [((), True), ((STICTION, LAG), True), ((LAG,), False), ((SATURATION,), False)]
)
def test_friction_that_follows_or_rises_does_not_jump_at_a_reversal(terms, jumps):
    assert jumps_at_reversal((*BASE, *terms)) is jumps
