"""Cascades that move from point to point and then hold: how near to the path, how calm at rest.

Every joint moves between drawn points for a minute, comes to rest after each move, and then holds its position. The
position loop has the default gain, a sixth of the bandwidth of the velocity loop, 10 Hz; an encoder of 6 urad measures
the position, and the velocity is made of it. Over the last 10 s, when the reference has been at rest for 2 s, the rms
of the velocity and of the torque's steps are compared with what is allowed: 1.2 times PI's or, where PI is quieter than
that, one encoder count in a sampling period and 0.1 N m.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff import Run, Scenario, load_scenario, simulate
from adaptive_ff.simulation.tracking_errors import TrackingErrors, figures_of, first_motion_time, tracking_errors
from adaptive_ff.studies.study import Found
from benchmarks.suite import Rows, seeded

Array = NDArray[np.float64]

RESOLUTION = 6e-6  # rad
MOVING, SETTLING, HOLDING = 60.0, 2.0, 10.0  # s
RATES = (100, 500, 1000)  # Hz
HEAVY = {"inertia": 20.0, "coulomb": 60.0, "stiction": 90.0, "viscous": 80.0}
LIGHT = {"inertia": 2.0, "coulomb": 10.0, "stiction": 12.0, "viscous": 5.0}
STIFFNESSES = (1e3, 1e4, 2e4, 1e5)  # N m/rad
QUIET_TORQUE = 0.1  # N m


def held_joints() -> Rows:
    """Return all joints, as the table ``[joint]``, at all rates (Hz)."""
    rows = {}
    for rate in RATES:
        for inertia, friction in (("20", HEAVY), ("2", LIGHT)):
            base = {**friction, "stribeck_velocity": 0.05, "solver_period": 5e-4}
            kinds: dict[str, dict[str, Any]] = {
                "coulomb": {"stiction": friction["coulomb"], "friction_lag": 0.0},
                "lagged": {"friction_lag": 0.02},
                **{f"LuGre {stiffness:.0e}": {"kind": "lugre", "stiffness": stiffness} for stiffness in STIFFNESSES},
            }
            for kind, own in kinds.items():
                name = f"{kind}, {inertia} kg m^2, {rate} Hz"
                rows[name] = (name, {"kind": "stribeck", **base, **own}, rate)
    return rows


def drawn_moves(
    generator: np.random.Generator, speeds: tuple[float, float], swing: float, acceleration: float, until: float
) -> dict[str, Any]:
    """Draw the table ``[reference]`` of moves between points within a swing (rad) up to a time (s)."""
    speed, elapsed, positions = float(generator.uniform(*speeds)), 0.0, [0.0]
    jerk, dwell = 20.0 * acceleration, 0.5
    while elapsed < until:
        positions.append(round(float(generator.uniform(-swing, swing)), 3))
        elapsed += abs(positions[-1] - positions[-2]) / speed + speed / acceleration + acceleration / jerk + dwell
    limits = {"speed": speed, "acceleration": acceleration, "jerk": jerk, "dwell": dwell}
    return {"kind": "point_to_point", "positions": positions[1:], **limits, "repeats": 1}


def scenario_of(joint: dict[str, Any], rate: int, seed: int) -> Scenario:
    """Return the cascade of a joint."""
    inertia = joint["inertia"]
    return load_scenario().modified(
        seed=seed,
        duration=MOVING + SETTLING + HOLDING,
        joint=joint,
        sampling={"period": 1.0 / rate},
        sensor={"velocity_noise": 0.0, "encoder_resolution": RESOLUTION},
        actuator={"torque_limit": 20.0 * inertia},
        reference=drawn_moves(np.random.default_rng([seed, 77]), (0.1, 0.4), 0.5, 1.0, MOVING - 5.0),
        position={},
        feedback={"inertia": inertia, "bandwidth": 10.0},
        controllers=["pi", "adaptive"],
    )


def run_case(row: str, joint: dict[str, Any], rate: int, seed: int, controllers: list[str]) -> Found:
    """Move and hold a joint."""
    scenario = scenario_of(joint, rate, seed)
    runs = {name: simulate(scenario, name, uncertain=False) for name in dict.fromkeys(["pi", *controllers])}
    errors = {name: moving_errors(run) for name, run in runs.items()}
    end, times = float(runs["pi"].solver_time[-1]), (runs["pi"].solver_time, runs["pi"].time)
    moved, sampled = (time >= end - HOLDING for time in times)
    rest = {name: at_rest(run.velocity[moved], run.torque[sampled]) for name, run in runs.items()}
    return {"": {"row": row}, **rest_figures(errors, rest, rate)}


def moving_errors(run: Run) -> TrackingErrors:
    """Return the position errors up to the end of the last move."""
    assert run.position_error is not None
    period = run.scenario.joint.solver_period
    last = int(np.flatnonzero(run.reference)[-1])
    begin = first_motion_time(run.reference, period)
    return tracking_errors(np.square(run.position_error[:last]), period, begin=begin)


def at_rest(velocity: Array, torque: Array) -> tuple[float, float]:
    """Return the rms of a velocity (rad/s) and of the steps of a torque (N m)."""
    return float(np.sqrt(np.mean(velocity**2))), float(np.sqrt(np.mean(np.diff(torque) ** 2)))


def rest_figures(
    errors: dict[str, TrackingErrors], rest: dict[str, tuple[float, float]], rate: int
) -> dict[str, dict[str, float]]:
    """Return tracking ratios, and ``rest_velocity`` and ``rest_torque``: at rest over what PI's allow."""
    velocity, steps = max(1.2 * rest["pi"][0], RESOLUTION * rate), max(1.2 * rest["pi"][1], QUIET_TORQUE)
    tracked = figures_of(errors)
    held = {name: {"rest_velocity": own[0] / velocity, "rest_torque": own[1] / steps} for name, own in rest.items()}
    return {name: tracked[name] | one for name, one in held.items()}


cascades = seeded(run_case, held_joints())
