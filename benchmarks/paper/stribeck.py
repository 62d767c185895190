"""Section V-C, Fig. 8: the Stribeck curve pre-estimated from quasi-static drives, and what its intervals are worth."""

import warnings
from collections.abc import Sequence

import numpy as np

from adaptive_ff.friction.model import UNITS
from adaptive_ff.learning.stribeck import Array, StribeckFit, fit_stribeck
from adaptive_ff.learning.support_points import SupportPoints, support_points
from adaptive_ff.simulation.experiment import build_plain_setup, empty_record
from adaptive_ff.simulation.loop import run_controller, start_position
from adaptive_ff.simulation.metrics import rms
from benchmarks.cases.reports import Row
from benchmarks.paper.experiment import SYMBOLS, Experiment, notes
from benchmarks.paper.figures import figure_08
from benchmarks.paper.records import SCENARIO, SEED, TRUE
from controllers import PI
from plant import sliding_friction

PERIOD = SCENARIO.sampling.period  # s
EVERY = round(PERIOD / SCENARIO.joint.solver_period)  # solver steps in it
SPEEDS = np.geomspace(0.005, 0.35, 30)  # rad/s, in each direction
VELOCITIES = np.concatenate([-SPEEDS[::-1], SPEEDS])
READINGS = 100  # of each drive
SPACING = 5  # samples from one reading to the next: closer ones are not independent, the loop ties them together
SETTLING = 200  # samples before the first
SPREAD = 0.03  # standard deviation of a reading, relative
COMMON = 0.03  # the same of an error that all readings of a drive fraction
SEEDS = range(1, 501)
FEWER_SEEDS = range(1, 101)
LARGEST_ERROR = 10.0  # %
COVERAGE = (92.0, 98.0)  # %
NAMES = {name: SYMBOLS[name] for name in ("coulomb", "stiction", "viscous")}
NAMES |= {"stribeck_velocity": "Vs", "stribeck_shape": "delta"}  # symbols of the fitted parameters


def run() -> Experiment:
    """Demonstrate the drives on the reference joint, and study the fit on many seeds."""
    points = simulate_drives(VELOCITIES, SEED)
    fit = fit_stribeck(points.velocity, points.torque, points.standard_error)
    fits = [fit_stribeck(*draw_points(seed)) for seed in SEEDS]
    with warnings.catch_warnings():
        # some of these points do not identify the curve; a row counts them
        warnings.simplefilter("ignore", UserWarning)
        rough = [fit_stribeck(*draw_points(seed, common=COMMON)) for seed in FEWER_SEEDS]
    name = f"{len(FEWER_SEEDS)} seeds, {100.0 * COMMON:g} % common to the readings of a drive"
    vague = 100.0 * float(np.mean([not one.determined for one in rough]))
    rows = [
        *drive_rows(points, fit),
        *study_rows(f"{len(SEEDS)} seeds", fits, targets=True),
        *study_rows(name, rough, targets=False),
        Row(f"{name}: said not to be determined, %", vague),
    ]
    drawn = {"figure_08": figure_08(points, fit, fits)}
    return Experiment("Fig. 8, section V-C: Stribeck curve", rows, notes("stribeck"), drawn)


def simulate_drives(velocities: Array, seed: int) -> SupportPoints:
    """Drive the reference joint at constant speeds (rad/s) with its PI loop, and average the readings."""
    count = SETTLING + READINGS * SPACING
    generator = np.random.default_rng([seed, 0])
    speeds, torques = np.empty((velocities.size, READINGS)), np.empty((velocities.size, READINGS))
    for place, velocity in enumerate(velocities):
        samples, plan = EVERY * np.arange(count + 1, dtype=np.int64), np.full(EVERY * count + 1, velocity)
        setup = build_plain_setup(SCENARIO.joint, samples, plan, SCENARIO.sensor.draw(count, generator))
        controller, record = PI(*SCENARIO.feedback.gains, PERIOD), empty_record(setup, 0)
        start = start_position(setup, 0.0)
        run_controller(controller, setup, start, count, record)
        speeds[place] = record.measured[SETTLING::SPACING]
        torques[place] = record.torque[SETTLING::SPACING]
    return support_points(speeds, torques)


def draw_points(seed: int, *, common: float = 0.0) -> tuple[Array, Array, Array]:
    """Draw velocities (rad/s), mean torques and their standard errors (N m) of drives with random readings.

    ``seed``: seed; ``common``: standard deviation of an error that all readings of a drive fraction, relative to the
    torque.
    """
    generator = np.random.default_rng([seed, 1])
    friction = true_friction(VELOCITIES)[:, np.newaxis]
    shared = common * generator.standard_normal((VELOCITIES.size, 1))
    readings = friction * (1.0 + shared + SPREAD * generator.standard_normal((VELOCITIES.size, READINGS)))
    points = support_points(np.broadcast_to(VELOCITIES[:, np.newaxis], readings.shape), readings)
    return points.velocity, points.torque, points.standard_error


def true_friction(velocities: Array) -> Array:
    """Return the friction torque (N m) of the reference joint that slides at velocities in rad/s."""
    friction = SCENARIO.joint.friction
    return np.array([np.sign(velocity) * sliding_friction(friction, abs(velocity)) for velocity in velocities])


def drive_rows(points: SupportPoints, fit: StribeckFit) -> list[Row]:
    """Return the points of the demonstration and the curve through them."""
    spread = float(np.median(100.0 * points.spread / np.abs(points.torque)))
    rows = [
        Row(f"drives: {VELOCITIES.size} speeds, spread of the readings, % of the torque, median", spread),
        Row("drives: error of the mean torque, N m rms", rms(points.torque - true_friction(points.velocity))),
        Row("drives: scatter about the fit, in standard errors", fit.scatter),
    ]
    for name, symbol in NAMES.items():
        found, unit = fit.estimates[name], f", {UNITS[name]}" if name in UNITS else ""
        text = f"{found.value:.4g} ({found.lower:.4g} to {found.upper:.4g})"
        rows.append(Row(f"drives: {symbol}{unit}, with 95 % interval (true {getattr(TRUE, name):g})", text))
    return rows


def study_rows(name: str, fits: Sequence[StribeckFit], *, targets: bool) -> list[Row]:
    """Return median errors of Vs and delta, and how often the intervals hold the truth."""
    errors, held = [], []
    for parameter, symbol in NAMES.items():
        true, found = getattr(TRUE, parameter), [fit.estimates[parameter] for fit in fits]
        error = 100.0 * float(np.median([abs(one.value / true - 1.0) for one in found]))
        holding = 100.0 * float(np.mean([one.lower <= true <= one.upper for one in found]))
        what = f"{name}: median error of {symbol}, %", f"{name}: 95 % intervals that hold {symbol}, %"
        bends = parameter.startswith("stribeck")
        small, covers = ("< 10", error < LARGEST_ERROR), ("92 to 98", COVERAGE[0] <= holding <= COVERAGE[1])
        errors += [Row(what[0], error, *(small if targets else ()))] if bends else []
        held.append(Row(what[1], holding, *(covers if targets and bends else ())))
    return errors + held
