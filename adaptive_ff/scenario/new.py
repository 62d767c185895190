"""A first scenario of one's own joint from the numbers of a data sheet, with what is assumed beside each number."""

import math
from contextlib import suppress
from typing import Any, NamedTuple

from pydantic import ValidationError

from adaptive_ff.errors import InputError, check_positive
from adaptive_ff.scenario.file import toml_text
from adaptive_ff.scenario.loop import TREMBLING, loop_at, tried_bandwidths
from adaptive_ff.scenario.reference import SHORTEST, Multisine
from adaptive_ff.scenario.relations import LONGEST
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.scenario.tables import AUTO
from plant import JointModel, whole_multiple

COULOMB_FRACTION = 0.1  # Coulomb friction over the rated torque, of a geared axis
STICTION_FACTOR = 1.25  # stiction over Coulomb friction
VISCOUS_FRACTION = 0.05  # viscous friction at the rated speed over the rated torque
STRIBECK_FRACTION = 0.02  # Stribeck velocity over the rated speed
NOISE_FRACTION = 2e-4  # noise of the measured velocity over the rated speed
LOOP_FRACTION = 0.5  # largest bandwidth of the PI loop over the one that a maximum sensitivity of 1.7 allows
CUTOFFS = (50.0, 100.0, 200.0, 25.0, 12.0, 400.0)  # corners behind an encoder that are tried where none is given, Hz
CUTOFF_FRACTION = 0.4  # the largest of them, over the sampling frequency
LONGEST_SOLVER_PERIOD = 0.001  # longest solver period, s
SHORTEST_PERIOD = SHORTEST / LONGEST
"""Shortest sampling period, s: a scenario without a duration takes ``SHORTEST`` s, in at most ``LONGEST`` steps."""

LONGEST_PERIOD = 0.5 / max(Multisine().frequencies)
"""Sampling period, s, below which the built-in reference is below half the sampling frequency."""

UNITS = {
    "rotary": {"inertia": "kg m^2", "torque": "N m", "speed": "rad/s", "viscous": "N m s/rad"},
    "linear": {"inertia": "kg", "torque": "N", "speed": "m/s", "viscous": "N s/m"},
}


class Encoder(NamedTuple):
    """An encoder in the place of a sensor of velocity."""

    counts: float  # counts in a turn, edges included; of a linear axis's own scale in a metre
    # corner of the low-pass of the velocity, Hz; by default the one that suits noise and friction
    cutoff: float | None = None
    at_motor: bool = False  # whether it is on the motor, before the gear

    def resolution(self, gear_ratio: float | None, linear: bool) -> float:
        """Return its step at the joint, rad or m; the ratio is in turns, of a linear axis in rad of the motor a m."""
        turn = 1.0 if linear and not self.at_motor else 2.0 * math.pi
        return turn / (self.counts * (gear_ratio if self.at_motor and gear_ratio is not None else 1.0))


def new_scenario_text(
    inertia: float,
    torque: float,
    speed: float,
    *,
    period: float = 0.001,
    linear: bool = False,
    encoder: Encoder | None = None,
    gear_ratio: float | None = None,
    delay: float = 0.0,
) -> str:
    """Return the text of a smallest complete scenario file; every assumed number has a comment that says so.

    The bandwidth is the one at which noise of the sensor and Coulomb friction that turns with the reference leave the
    least error in the PI loop alone, of those whose margins with delay and velocity filter are sound, and at which the
    command does not tremble. Given are inertia, torque and speed at the joint, its sampling period and the delay of the
    drive (s); the gear ratio is that of the motor, on a linear axis rad of the motor in a metre.
    """
    given = {"inertia": inertia, "torque": torque, "speed": speed, "period": period}
    optional = {"gear_ratio": gear_ratio, **({} if encoder is None else {"encoder": encoder.counts})}
    optional["velocity_cutoff"] = None if encoder is None else encoder.cutoff
    check_positive(**given, **{name: one for name, one in optional.items() if one is not None})
    if encoder is not None and encoder.counts < 1.0:
        raise InputError(f"encoder = {encoder.counts:g} is not allowed: it must be one count or more")
    if not 0.0 <= delay < math.inf:
        raise InputError(f"delay = {delay:g} s is not allowed: it must be zero or more and finite")
    if encoder is not None and encoder.at_motor and gear_ratio is None:
        raise InputError("gear_ratio is missing; it must be given for an encoder on the motor")
    if not SHORTEST_PERIOD <= period < LONGEST_PERIOD:
        raise InputError(
            f"period = {period:g} s is not allowed: it must be from {SHORTEST_PERIOD:g} s to less than "
            f"{LONGEST_PERIOD:g} s"
        )
    axis = "linear" if linear else "rotary"
    coulomb, viscous = COULOMB_FRACTION * torque, VISCOUS_FRACTION * torque / speed
    curve = {
        "inertia": _rounded(inertia),
        "coulomb": _rounded(coulomb),
        "stiction": _rounded(STICTION_FACTOR * coulomb),
        "viscous": _rounded(viscous),
        "stribeck_velocity": _rounded(STRIBECK_FRACTION * speed),
    }
    joint = {**({"axis": axis} if linear else {}), **curve, **({"gear_ratio": gear_ratio} if gear_ratio else {})}
    sensor = {"velocity_noise": _rounded(NOISE_FRACTION * speed)}
    if encoder is not None:
        sensor = {"encoder_resolution": float(f"{encoder.resolution(gear_ratio, linear):.7g}")}
    solver = _solver_period(curve, period, delay)
    content = {
        "joint": {**joint, "solver_period": solver},
        "sampling": {"period": period},
        "sensor": sensor,
        **({} if encoder is None else {"velocity": {"method": "low_pass", "cutoff": encoder.cutoff}}),
        "actuator": {"torque_limit": _rounded(torque), **({"delay": delay} if delay > 0.0 else {})},
        "feedback": {"inertia": curve["inertia"], "bandwidth": AUTO},
        "adaptation": {"stribeck_velocity": curve["stribeck_velocity"]},
        "fixed": {name: curve[name] for name in ("inertia", "coulomb", "viscous")},
    }
    head = [
        "A joint from data-sheet numbers; what is assumed says so. Better numbers give",
        "a log of the joint: adaptive-ff identify LOG. The reference is a multisine.",
    ]
    return toml_text(_with_a_loop(content), _comments(UNITS[axis], encoder), head)


def _with_a_loop(content: dict[str, Any]) -> dict[str, Any]:
    """Return a content with the bandwidth, and where it has none the corner of the low-pass, of the least error."""
    cutoffs: list[float | None] = [None]
    if "velocity" in content:
        given, most = content["velocity"]["cutoff"], CUTOFF_FRACTION / content["sampling"]["period"]
        cutoffs = [given] if given is not None else [one for one in CUTOFFS if one <= most] or [most]
    best, least = content, (True, math.inf)
    for cutoff in cutoffs:
        made = content if cutoff is None else {**content, "velocity": {**content["velocity"], "cutoff": cutoff}}
        scenario = Scenario.model_validate({**made, "duration": content["sampling"]["period"]})
        try:
            tried = tried_bandwidths(scenario, LOOP_FRACTION)
        except ValueError as wrong:
            raise InputError(f"no loop suits this period, delay and velocity filter: {wrong}") from wrong
        for bandwidth in reversed(tried):
            loop = loop_at(scenario, bandwidth)
            trembles = loop.noise_torque > TREMBLING * content["actuator"]["torque_limit"]
            error = math.hypot(loop.noise_velocity, loop.friction_velocity)
            cost = (trembles, loop.noise_torque if trembles else error)
            if cost < least:
                feedback = {**content["feedback"], "bandwidth": _rounded(bandwidth)}
                best, least = {**made, "feedback": feedback}, cost
            elif loop.friction_velocity > loop.noise_velocity:  # from here on slower is worse
                break
    return best


def _comments(units: dict[str, str], encoder: Encoder | None) -> dict[str, str]:
    """Return what is said beside the numbers, with their units."""
    return {
        "joint.inertia": f"{units['inertia']}, motor and load at the joint",
        "joint.coulomb": f"{units['torque']}, assumed: {100.0 * COULOMB_FRACTION:g} % of the rated one",
        "joint.stiction": f"{units['torque']}, assumed: {STICTION_FACTOR:g} times Coulomb friction",
        "joint.viscous": f"{units['viscous']}, assumed: {100.0 * VISCOUS_FRACTION:g} % of the rated one",
        "joint.stribeck_velocity": f"{units['speed']}, assumed: {100.0 * STRIBECK_FRACTION:g} % of the rated one",
        "joint.gear_ratio": "of the motor to the joint",
        "joint.solver_period": "s, of the simulation",
        "sampling.period": "s",
        "sensor.velocity_noise": f"{units['speed']}, standard deviation, assumed",
        "sensor.encoder_resolution": "at the joint, of the given counts",
        "velocity.method": "of differences of readings, assumed",
        "velocity.cutoff": f"Hz, {'as given' if encoder and encoder.cutoff else 'chosen with the bandwidth'}",
        "actuator.delay": "s, from a sample to the torque",
        "actuator.torque_limit": f"{units['torque']}, the rated one",
        "feedback.inertia": "as the designer assumes it",
        "feedback.bandwidth": "Hz, of the least error, noise and friction",
        "adaptation.stribeck_velocity": "assumed; a factor of two wrong is fine",
        "fixed": "what the controller 'fixed' feeds forward",
    }


def _solver_period(curve: dict[str, float], period: float, delay: float) -> float:
    """Return the longest part of sampling period and delay for which the simulated joint has a unique step."""
    shortest = max(period / 1000.0, SHORTEST_PERIOD)
    for parts in range(1, 1001):
        solver = float(f"{period / parts:.12g}")
        whole = delay == 0.0 or whole_multiple(delay, solver) is not None
        if whole and shortest * (1.0 - 1e-9) <= solver <= LONGEST_SOLVER_PERIOD:
            with suppress(ValidationError):
                return JointModel(**curve, solver_period=solver).solver_period
    if delay > 0.0 and whole_multiple(delay, period / 1000.0) is None:
        raise InputError(f"delay = {delay:g} s is not allowed: it must be a whole number of thousandths of the period")
    raise InputError(
        f"inertia = {curve['inertia']:g} is too small beside the rated torque for a simulation in steps of "
        f"{shortest:g} s; give the inertia of motor and load at the joint"
    )


def _rounded(value: float) -> float:
    """Return a value with the digits that an assumption deserves."""
    return float(f"{value:.4g}")
