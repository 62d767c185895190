"""On a small fixed sample the adaptive controller is never worse than its own PI loop."""

import pytest
from closed_loops import sampled

from adaptive_ff import load_scenario
from adaptive_ff.scenario.loop import fall_over_gain
from adaptive_ff.studies.sweep import draw_scenario
from adaptive_ff.studies.tracking import track_scenario
from benchmarks.cases.drawn import draw_cascade, draw_elastic, draw_machine, draw_resting
from benchmarks.cases.situations import named_scenario

SEED, DRAWS = 101, 5


def judge(scenario, draws=DRAWS):
    """Return the ratios to PI: ``settled``, ``window``, ``start``, ``after``."""
    return track_scenario(scenario, ["adaptive"], draws=draws)["adaptive"]


def is_never_worse(scenario, draws=DRAWS):
    judged = judge(scenario, draws)
    return judged["settled"] >= 1.0 and judged["window"] <= 1.2


@pytest.mark.parametrize("draw", sampled(range(3), (0, 1)))
def test_on_drawn_joints(draw):
    assert is_never_worse(draw_scenario(load_scenario(), SEED, draw))


@pytest.mark.nightly
@pytest.mark.parametrize("draw", [3, 314, 842])
def test_settled_on_joints_that_hunt(draw):
    """With the identified inertia in the observer, far below the true one, two settled at 0.79 and 0.78."""
    scenario = draw_scenario(load_scenario(), SEED, draw)
    assert fall_over_gain(scenario) > 5.0
    assert judge(scenario)["settled"] >= 0.95


@pytest.mark.parametrize("draw", sampled(range(8), (0, 1)))
@pytest.mark.parametrize("machine", [draw_machine, draw_cascade])
def test_on_machines_of_other_sizes_and_with_a_weight_behind_a_position_loop(machine, draw):
    assert is_never_worse(machine(SEED, draw))


@pytest.mark.parametrize("draw", sampled(range(8), (0, 1)))
@pytest.mark.parametrize("machine", [draw_resting, draw_elastic])
def test_with_rests_of_seconds_or_a_gear_that_nobody_tells_of_it_settles_as_pi_does_or_better(machine, draw):
    assert judge(machine(SEED, draw), draws=1)["settled"] >= 0.95


def test_inertia_of_a_weight_on_bristles_is_not_found_ten_times_too_large():
    assert is_never_worse(draw_cascade(SEED, 137), draws=1)  # settled at 0.82, first 5 s 2.8 times those of PI


def test_where_the_inertia_is_told_twice_too_large():
    told = load_scenario().modified(seed=SEED + 2, duration=20.0, joint={"inertia": 10.0})
    assert is_never_worse(told, draws=1)  # the first 5 s were 3.8 times those of PI: the observer hunted


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("seed", "draw", "settled", "window", "was"),
    [
        (SEED, 279, 1.0, 2.0, "settled at 0.68 by an offset that motion one way had not shown"),
        (201, 450, 1.0, 1.2, "a window at 2.8 by the same"),
        (SEED, 494, 1.5, 1.5, "a window at 3.8 by friction on top of an integral that grew while the joint stuck"),
        (SEED, 513, 1.5, 1.2, "a window at 3.3 by the same"),
        (SEED, 563, 2.0, 1.2, "a window at 4.1 by friction turned where the plan of a late drive only stops"),
    ],
)
def test_on_machines_that_were_worse(seed, draw, settled, window, was):
    judged = judge(draw_machine(seed, draw))  # over five draws of the noise, as it is asked for
    assert judged["settled"] >= settled, was
    assert judged["window"] <= window, was


@pytest.mark.parametrize(
    "name",
    sampled(
        ["payload_half", "gravity_40", "slow_025", "steep_5", "friction_drops", "map_short_hats", "map_no_need_load"],
        ("payload_half", "friction_drops"),
    ),
)
def test_in_situations_outside_its_model_and_with_maps(name):
    assert is_never_worse(named_scenario(name, SEED))
