"""What a controller is judged on: references of named situations, and joints and machines drawn at random."""

from collections.abc import Callable, Iterable
from typing import NamedTuple

from adaptive_ff import Scenario, load_scenario
from adaptive_ff.comparison.drawn_joints import class_of, draw_scenario, fall_over_gain
from benchmarks.drawn_machines import draw_cascade, draw_elastic, draw_machine, draw_resting, draw_saturating
from benchmarks.never_worse.situations import named_scenario


class Case(NamedTuple):
    """One reference on which a controller is judged.

    Attributes
    ----------
    name : str
        Situation or class of joints.
    seed : int
        Seed of the reference, or number of the draw of the joint.
    scenario : Scenario
        What is run.
    """

    name: str
    seed: int
    scenario: Scenario


def named_cases(names: Iterable[str], first: int, references: int) -> list[Case]:
    """Return the references of named scenarios, and of ``MAPS``."""
    seeds = range(first, first + references)
    return [Case(name, seed, named_scenario(name, seed)) for name in names for seed in seeds]


def drawn_cases(joints: int, seed: int) -> list[Case]:
    """Return joints drawn around the built-in one, named by how steeply their friction falls."""
    drawn = ((draw, draw_scenario(load_scenario(), seed, draw)) for draw in range(joints))
    return [Case(class_of(fall_over_gain(scenario)), draw, scenario) for draw, scenario in drawn]


def machine_cases(machines: int, seed: int) -> list[Case]:
    """Return machines drawn over decades, named by their kind of friction."""
    return _by_friction("machine", draw_machine, machines, seed)


def cascade_cases(machines: int, seed: int) -> list[Case]:
    """Return the same machines with a weight and behind a position loop."""
    return _by_friction("cascade", draw_cascade, machines, seed)


def resting_cases(machines: int, seed: int) -> list[Case]:
    """Return these with rests of seconds between moves."""
    return _by_friction("rests", draw_resting, machines, seed)


def _by_friction(label: str, draw_one: Callable[[int, int], Scenario], machines: int, seed: int) -> list[Case]:
    drawn = ((draw, draw_one(seed, draw)) for draw in range(machines))
    return [Case(f"{label}, {scenario.joint.kind}", draw, scenario) for draw, scenario in drawn]


def saturating_cases(drives: int, seed: int) -> list[Case]:
    """Return joints and machines whose drives saturate untold."""
    drawn = ((draw, draw_saturating(seed, draw)) for draw in range(drives))
    return [Case(f"{('joint', 'machine')[draw % 2]}, saturates untold", draw, scenario) for draw, scenario in drawn]


def elastic_cases(machines: int, seed: int) -> list[Case]:
    """Return machines with elastic gears, and with such that have play as well."""
    drawn = ((draw, draw_elastic(seed, draw)) for draw in range(machines))
    return [Case(f"machine, {('elastic gear', 'play')[draw % 2]}", draw, scenario) for draw, scenario in drawn]
