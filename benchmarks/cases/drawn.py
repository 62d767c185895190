"""Joints and machines drawn at random."""

from collections.abc import Callable
from functools import partial

from adaptive_ff import Scenario, load_scenario
from adaptive_ff.studies.drawn_joints import class_of, draw_scenario, fall_over_gain
from benchmarks.cases.drawn_machines import draw_cascade, draw_elastic, draw_machine, draw_resting, draw_saturating
from benchmarks.running import scenario_case
from benchmarks.suite import Case


def joints(count: int, draws: int = 1, first: int = 1) -> list[Case]:
    """Return joints drawn around the built-in one, named by how steeply their friction falls over Kp."""
    return _drawn("joint", _joint, _class, count, draws, first)


def machines(count: int, draws: int = 1, first: int = 1) -> list[Case]:
    """Return machines drawn over decades, named by their kind of friction."""
    return _drawn("machine", draw_machine, _kind, count, draws, first)


def cascades(count: int, draws: int = 1, first: int = 1) -> list[Case]:
    """Return the same machines with a weight and behind a position loop."""
    return _drawn("cascade", draw_cascade, _kind, count, draws, first)


def resting(count: int, draws: int = 1, first: int = 1) -> list[Case]:
    """Return these with rests of seconds between moves."""
    return _drawn("rests", draw_resting, _kind, count, draws, first)


def gears(count: int, draws: int = 1, first: int = 1) -> list[Case]:
    """Return machines with gears that are elastic, and that have play as well, without being given either."""
    return _drawn("gear", draw_elastic, _gear, count, draws, first)


def saturating(count: int, draws: int = 1, first: int = 1) -> list[Case]:
    """Return joints and machines whose drives saturate, of which the controller is given nothing."""
    return _drawn("saturating", draw_saturating, ("joint", "machine"), count, draws, first)


def _joint(seed: int, draw: int) -> Scenario:
    return draw_scenario(load_scenario(), seed, draw)


def _class(scenario: Scenario) -> str:
    return class_of(fall_over_gain(scenario))


def _kind(scenario: Scenario) -> str:
    return scenario.joint.kind


def _gear(scenario: Scenario) -> str:
    return {"elastic": "elastic gear", "backlash": "play"}[scenario.joint.kind]


def _drawn(
    label: str,
    draw: Callable[[int, int], Scenario],
    row: Callable[[Scenario], str] | tuple[str, ...],
    count: int,
    draws: int,
    seed: int,
) -> list[Case]:
    """Return as many draws; a tuple names their rows in turn."""
    return [
        scenario_case(
            row[place % len(row)] if isinstance(row, tuple) else row, label, place, partial(draw, seed, place), draws
        )
        for place in range(count)
    ]
