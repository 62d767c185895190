"""What the adaptive controller promises on the reference joint; never worse than PI on a handful of others."""

import functools

import numpy as np
import pytest
from closed_loops import SCENARIO, build_setup, drive
from exports import adaptive

from adaptive_ff import load_scenario, simulate
from adaptive_ff.adaptive.observe import observed
from adaptive_ff.adaptive.tuning import Tuning

JOINT = SCENARIO.joint


@functools.cache
def settled_error(name, period, seed):
    scenario = SCENARIO.modified(seed=seed, sampling={"period": period})
    return simulate(scenario, name).metrics.rms_error_settled


@pytest.mark.parametrize(("period", "factor"), [(0.01, 3.0), (0.001, 8.0)])
@pytest.mark.parametrize("seed", [2, 3])
def test_it_tracks_far_better_than_pi(seed, period, factor):
    assert settled_error("pi", period, seed) > factor * settled_error("adaptive", period, seed)


@pytest.mark.parametrize("seed", range(5, 13))
def test_no_seed_leads_astray(seed):
    scenario = SCENARIO.modified(seed=seed, duration=30.0)
    errors = {name: simulate(scenario, name).metrics for name in ("pi", "adaptive")}
    assert errors["adaptive"].rms_error_settled < 0.5 * errors["pi"].rms_error_settled
    assert errors["adaptive"].max_error < 2.0 * errors["pi"].max_error


SITUATIONS = {
    "friction drops": {"change": [{"time": 20.0, "friction_scale": 0.5}]},
    "friction triples": {"change": [{"time": 20.0, "friction_scale": 3.0}]},
    "a load of 80 N m": {"change": [{"time": 20.0, "load": 80.0}]},
    "half the inertia": {"feedback": {"inertia": 10.0}},
    "twice the inertia": {"feedback": {"inertia": 40.0}},
    "a wrong Stribeck velocity": {"adaptation": {"stribeck_velocity": 0.2}},
    "a joint of little friction": {"joint": {"coulomb": 2.0, "stiction": 3.0, "viscous": 5.0}},
}


@pytest.mark.parametrize("name", SITUATIONS)
def test_it_is_no_worse_than_pi(name):
    scenario = SCENARIO.modified(seed=3, duration=40.0, **SITUATIONS[name])
    errors = {one: simulate(scenario, one).metrics.rms_error_settled for one in ("pi", "adaptive")}
    assert errors["adaptive"] < errors["pi"] / 0.95


@pytest.mark.parametrize("period", [0.01, 0.001])
def test_the_joint_is_identified(period):
    found = simulate(SCENARIO.modified(seed=2, sampling={"period": period}), "adaptive").final_estimates
    assert found["inertia"] == pytest.approx(JOINT.inertia, rel=0.1)
    assert found["coulomb"] == pytest.approx(JOINT.coulomb, rel=0.1)
    assert found["stiction"] == pytest.approx(JOINT.stiction, rel=0.1)
    assert found["viscous"] == pytest.approx(JOINT.viscous, rel=0.2)


@pytest.mark.parametrize("name", ["gravity_100", "positioning", "standstill"])
def test_scenarios_of_the_package_are_tracked_better_than_by_pi(name):
    scenario = load_scenario(name)
    errors = {one: simulate(scenario, one).metrics.rms_error_settled for one in ("pi", "adaptive")}
    assert errors["adaptive"] < 0.7 * errors["pi"]


def test_every_constant_can_be_set_and_acts():
    deaf = Tuning(explained=1e300)
    controllers = [adaptive(tuning=tuning) for tuning in (Tuning(), deaf)]
    setup = build_setup(SCENARIO.modified(duration=5.0))
    first, second = (drive(one, setup)[0].torque for one in controllers)
    assert not np.array_equal(first, second)
    assert abs(controllers[1].observer_gain) < 1e-12 < controllers[0].observer_gain


@pytest.mark.parametrize("load", [0.0, 5.0])
def test_viscous_friction_that_a_slower_joint_has_less_is_not_observed_as_a_load(load):
    """It turns steadily at 0.9 of its reference of 1 rad/s: 40 N m are fed, 36 N m and the load are needed."""
    model = {"inertia": 20.0, "coulomb": 0.0, "stiction": 0.0, "viscous": 40.0, "friction_lag": 0.02}
    controller = adaptive(model=model)
    state = controller.state._replace(modelled=(40.0,) * len(controller.state.modelled))
    after_a_long_time = observed(controller.parameters, state, 36.0 + load, 0.1, 0.0, 1e3)
    assert after_a_long_time == pytest.approx(controller.parameters.tuning.observed_fraction * load, abs=1e-9)


@pytest.mark.parametrize("share", [0.5, 0.85])
def test_a_share_of_the_friction_is_fed_and_neither_observer_nor_estimates_make_up_for_the_rest(share):
    setup = build_setup(SCENARIO.modified(duration=40.0))
    whole, part = (adaptive(friction_share=one) for one in (1.0, share))
    (first, _), (second, _) = drive(whole, setup), drive(part, setup)
    assert part.estimates["coulomb"] == pytest.approx(whole.estimates["coulomb"], rel=0.15)
    settled = slice(first.torque.size // 2, None)
    fed = np.dot(first.feedforward[settled], second.feedforward[settled]) / np.sum(first.feedforward[settled] ** 2)
    assert fed == pytest.approx(share, abs=0.08)


def test_before_anything_is_learnt_the_observer_moves_a_joint_off():
    run = simulate(SCENARIO.modified(seed=2, duration=2.0, sampling={"period": 0.001}), "adaptive")
    gain = run.monitors["observer_gain"]
    assert np.median(gain[run.time < 0.1]) > 0.9


@pytest.mark.parametrize(
    ("actuator", "most"), [({"rate_limit": 3000.0}, 0.25), ({"lag": 0.03}, 1.0), ({"rate_limit": 1500.0}, 3.0)]
)
def test_a_drive_of_unknown_torque_is_not_observed_and_ends_in_no_oscillation(actuator, most):
    """Observed, what such a drive keeps back was fed once more: errors of a thousand times those of PI."""
    scenario = SCENARIO.modified(actuator={**actuator, "reports_torque": False}, seed=101)
    runs = {name: simulate(scenario, name) for name in ("pi", "adaptive")}
    assert not np.any(runs["adaptive"].monitors["observer_torque"])
    assert runs["adaptive"].metrics.rms_error_settled < most * runs["pi"].metrics.rms_error_settled
