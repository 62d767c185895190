"""An hour without excitation at 1 kHz: ``python -m benchmarks.endurance --idle [--hours H]``.

The joint works for a minute, then runs at constant speed, or stands, for an hour, then works for another minute. Shown
are the bounds of the estimator's information matrix, the estimates, and how the last minute is tracked beside the
oracle.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff import load_scenario
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.simulation.experiment import empty_record, lay_plain_course
from adaptive_ff.simulation.loop import run_compiled, start_position
from adaptive_ff.simulation.metrics import rms

PERIOD = 0.001
WORK = 60.0
"""Length of the motion before and after, s."""
SPEED = 0.1
"""Constant speed, rad/s."""
HANDOVER = 2.0
"""Time for the way from the motion to the constant speed and back, s."""


@dataclass(frozen=True)
class Outcome:
    """What an hour without excitation left behind.

    Attributes
    ----------
    eigenvalues : tuple of float
        Smallest and largest eigenvalue of the information matrix after the hour; not numbers without one.
    estimates : dict of float
        Estimates after the hour.
    before, after : float
        Rms error in the last half of the motion before, and in the motion after the hour, rad/s.
    """

    eigenvalues: tuple[float, float]
    estimates: dict[str, float]
    before: float
    after: float


def reference(scenario: Scenario, seconds: float, speed: float) -> NDArray[np.float64]:
    """Return motion, constant speed (rad/s) for a number of seconds, and the same motion again."""
    motion = scenario.modified(duration=WORK, sampling={"period": PERIOD}).reference_velocity()[:-1]
    ramp = np.linspace(0.0, 1.0, round(HANDOVER / PERIOD), endpoint=False)
    smooth = ramp * ramp * (3.0 - 2.0 * ramp)
    to_speed = motion[-1] + (speed - motion[-1]) * smooth
    return np.concatenate(
        [motion, to_speed, np.full(round(seconds / PERIOD), speed), speed * (1.0 - smooth), motion, [0.0]]
    )


def endure(name: str, seconds: float, speed: float) -> Outcome:
    """Run a controller of the built-in scenario through the hour."""
    scenario = load_scenario().modified(sampling={"period": PERIOD})
    path = reference(scenario, seconds, speed)
    samples = path.size - 1
    course = lay_plain_course(
        scenario.joint,
        np.arange(samples + 1, dtype=np.int64),
        path,
        scenario.sensor.draw(samples, np.random.default_rng(scenario.seed)),
        scenario.actuator,
    )
    controller = make_controller(scenario, name)
    record = empty_record(course, len(controller.estimate_names))
    position = start_position(course, 0.0)
    work = round(WORK / PERIOD)
    rest = samples - work
    state, position = run_compiled(controller.parameters, controller.state, course, position, rest, record)
    controller.state = state
    eigenvalues = (float("nan"), float("nan"))
    if hasattr(state, "estimator"):
        values = np.linalg.eigvalsh(state.estimator.recursion.information)
        eigenvalues = (float(values[0]), float(values[-1]))
    estimates = controller.estimates
    run_compiled(controller.parameters, state, course, position, samples, record)
    error = course.reference - record.velocity
    return Outcome(eigenvalues, estimates, rms(error[work // 2 : work]), rms(error[rest:]))


def table(hours: float) -> Table:
    """Return what constant speed and standstill do to the adaptive controller."""
    rows = Table(title=f"{hours:g} h at 1 kHz without excitation", box=SIMPLE)
    headings = ("between", "controller", "information", "estimates after it", "rms before, mrad/s", "after")
    for heading in headings:
        rows.add_column(heading)
    for label, speed in ((f"constant {SPEED:g} rad/s", SPEED), ("standstill", 0.0)):
        for name in ("oracle", "adaptive"):
            outcome = endure(name, 3600.0 * hours, speed)
            bounds = "" if np.isnan(outcome.eigenvalues[0]) else "{:.2g} to {:.2g}".format(*outcome.eigenvalues)
            estimates = ", ".join(f"{value:.4g}" for value in outcome.estimates.values())
            rows.add_row(label, name, bounds, estimates, f"{1e3 * outcome.before:.3g}", f"{1e3 * outcome.after:.3g}")
    return rows
