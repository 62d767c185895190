"""Estimates of the adaptive controller beside the truth, and whether they are as uncertain as it says.

And intervals from a designed motion of 10 and 20 s, over those of 60 s of the built-in multisine on the same joint: it
keeps the limits of the drive and is followed by the PI loop of the scenario; the intervals are those of the torque form
with the assumed Stribeck velocity. The multisine keeps to seven Stribeck velocities.
"""

from collections.abc import Callable
from functools import partial

from adaptive_ff import Scenario, load_scenario, simulate
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.scenario.truth import true_model
from adaptive_ff.studies.exciting_motion import default_limits, exciting_motion, interval_widths, with_motion, yardstick
from adaptive_ff.studies.motion import NAMES
from adaptive_ff.studies.study import Found
from benchmarks.cases.drawn import draw_joint
from benchmarks.suite import Case, Rows, pooled, seeded

COMPARED = ("inertia", "coulomb", "stiction", "viscous", "friction_lag")

NORMAL_95 = 1.959964  # half of the interval that holds 95 % of a normal error, in standard deviations


def run_case(row: str, make: Callable[[int], Scenario], seed: int, controllers: list[str]) -> Found:
    """Run controllers that estimate.

    At the end of the run: error of each estimate over its true value, and ``ITS_inside``: 1 where the interval of
    95 % that the controller states holds the truth, else 0.
    """
    scenario = make(seed)
    true, found = true_model(scenario), {}
    for name in controllers:
        controller = make_controller(scenario, name)
        simulate(scenario, controller, uncertain=False)
        found[name], uncertainties = {}, getattr(controller, "uncertainties", None)
        for one in [one for one in COMPARED if uncertainties is not None and getattr(true, one) > 0.0]:
            error = controller.estimates[one] - getattr(true, one)
            found[name][one] = error / getattr(true, one)
            found[name][f"{one}_inside"] = float(abs(error) <= NORMAL_95 * uncertainties[one])
    return {"": {"row": row}, **found}


def built_in(period: float, noise: float, duration: float, seed: int) -> Scenario:
    """Return the built-in joint with a sampling period (s) and noise of the velocity (rad/s) for a time (s)."""
    tables = {"sampling": {"period": period}, "sensor": {"velocity_noise": noise}}
    return load_scenario().modified(seed=seed, duration=duration, **tables)


def loops_of(loops: list[tuple[float, float, float]]) -> Rows:
    """Return rows of the built-in joint by period, noise and duration."""
    made = {f"{round(1.0 / loop[0])} Hz, noise {1e3 * loop[1]:g} mrad/s, {loop[2]:g} s": loop for loop in loops}
    return {name: (name, partial(built_in, *loop)) for name, loop in made.items()}


loops = seeded(run_case, loops_of)


def joints(count: int, first: int = 1) -> list[Case]:
    """Return excited joints, all of one row."""
    make = partial(draw_joint, first)
    return [Case(f"joint/{draw}", draw, partial(run_case, "drawn joints", make, draw)) for draw in range(count)]


PERIOD = 10.0  # length of the motion, s


def run_motion(name: str, seeds: list[int], controllers: list[str]) -> Found:
    """Find a motion; figures by length of the log, in the place of controllers: parameters' intervals over those."""
    scenario = load_scenario(name)
    motion = exciting_motion(scenario, default_limits(scenario), period=PERIOD, workers=None)
    base, found = interval_widths(yardstick(scenario), seeds), {}
    for length in controllers:
        longer = with_motion(scenario, motion.reference.model_dump(), float(length.removesuffix(" s")))
        widths = interval_widths(longer, seeds)
        found[length] = {parameter: widths[parameter] / base[parameter] for parameter in NAMES}
    return {"": {"row": name}, **found}


motions = pooled(run_motion, lambda names: {name: (name,) for name in names})
