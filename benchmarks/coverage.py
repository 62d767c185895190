"""How honest the intervals of ``identify`` are: ``python -m benchmarks.coverage [--logs N] [--position-hats 9]``.

Logs are made of joints that are known: multisine motion, friction with a lag of 0 to 50 ms, coloured noise of the
torque, a quantised position, gravity in half of them, viscous friction that saturates in a third (in four shapes, of
which the identified models have three), 10 to 60 s. For
inertia, Coulomb friction and viscous coefficient it is counted how often the stated 95 % interval holds the truth, how
wide it is, and how many logs are refused or flagged as confounded. Log N is the same in every run. Friction does not
depend on position in any: where a map is asked for, it is counted how often one is chosen.
"""

from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer
from numpy.typing import NDArray
from rich.box import SIMPLE
from rich.table import Table
from scipy import signal

from adaptive_ff import InputError
from adaptive_ff.files import write_json
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.identify.reported import VAGUE, Reported
from adaptive_ff.identify.terms import BASE, GRAVITY, LAG, SATURATIONS, Terms
from adaptive_ff.logs.log import Log
from benchmarks.wide import wide_console

Array = NDArray[np.float64]

FIRST_SEED = 10_001
"""Seed of the first log; none of them was used to choose a constant, which was done on seeds 101 to 400."""

FINE = 5000.0
"""Rate at which friction is filtered by its lag, Hz, at least."""

NAMES = ("inertia", "coulomb", "viscous")

SLOW = ("stiction", "stribeck_velocity")
"""Parameters that are judged where the model has them and the truth is known."""

LONG = 30.0
"""Duration from which on the width of an interval is judged, s."""

CORRELATED = 0.02
"""Time constant of half of the noise, s."""

FEWEST_REVERSALS, SMALLEST_SHARE = 10, 0.1
"""A log has enough motion with so many reversals, and from this torque of inertia on, over the whole torque (rms)."""


class Joint(NamedTuple):
    """A joint with its motion, at a fine rate.

    Attributes
    ----------
    rate, fine : float
        Rates of the log and of the series, Hz.
    duration : float
        Length of the log, s; the motion begins a second before.
    time, position, velocity, acceleration : ndarray, shape (n,)
        Motion, s, rad, rad/s, rad/s^2.
    inertia, coulomb, viscous, lag : float
        Inertia, Coulomb friction, viscous coefficient and lag of the friction; kg m^2, N m, N m s/rad, s.
    gravity, phase, offset : float
        Gravity, N m, where it is zero, rad, and the offset, N m.
    saturation, bend : float
        Friction that saturates, N m, and the speed of its bend, rad/s.
    shape : int
        Its shape, see ``saturating``.
    """

    rate: float
    fine: float
    duration: float
    time: Array
    position: Array
    velocity: Array
    acceleration: Array
    inertia: float
    coulomb: float
    viscous: float
    lag: float
    gravity: float
    phase: float
    offset: float
    saturation: float
    bend: float
    shape: int

    @property
    def kept(self) -> slice:
        """The fine samples that the log has."""
        return slice(round(self.fine), None, round(self.fine / self.rate))

    def lagged(self, static: Array, lag: float) -> Array:
        """Return friction that follows the static one with a lag, s, at the samples of the log."""
        return _lagged(static, lag, 1.0 / self.fine)[self.kept]

    def static_friction(self) -> Array:
        """Return the friction without its lag, N m."""
        bent = saturating(self.shape, self.velocity / self.bend)
        return self.coulomb * np.sign(self.velocity) + self.viscous * self.velocity + self.saturation * bent

    def torque(self) -> Array:
        """Return the torque at the samples of the log, free of noise, N m."""
        kept = self.kept
        friction = self.lagged(self.static_friction(), self.lag)
        gravity = self.gravity * np.sin(self.position[kept] + self.phase)
        return self.inertia * self.acceleration[kept] + friction + self.offset + gravity


class Case(NamedTuple):
    """A log with its truth.

    Attributes
    ----------
    log : Log
        The log.
    truth : dict of float
        True parameters; ``coulomb`` is friction at creeping speed, ``viscous`` the slope at high speed.
    duration : float
        Length, s.
    enough : bool
        Whether there is enough motion.
    models : tuple of tuple of str
        Terms that the joint has; several where its saturation has a shape that is none of those identified.
    noise : float
        Standard deviation of the noise of the torque, N m.
    """

    log: Log
    truth: dict[str, float]
    duration: float
    enough: bool
    models: tuple[Terms, ...]
    noise: float


def _between(generator: np.random.Generator, low: float, high: float) -> float:
    """Draw a number whose logarithm is uniform."""
    return float(low * (high / low) ** generator.random())


def draw_joint(generator: np.random.Generator) -> Joint:
    """Draw a joint and its motion."""
    rate = float(generator.choice([100.0, 250.0, 500.0, 1000.0]))
    duration = float(generator.uniform(10.0, 60.0))
    fine = rate * int(np.ceil(FINE / rate))
    time = np.arange(round((duration + 1.0) * fine)) / fine - 1.0
    position, velocity, acceleration = _motion(generator, time)
    inertial = float(np.sqrt(np.mean(acceleration**2)))
    inertia = _between(generator, 0.01, 20.0)
    coulomb = inertia * inertial * _between(generator, 0.1, 3.0)
    viscous = coulomb * _between(generator, 0.2, 2.0) / float(np.max(np.abs(velocity)))
    lag = float(generator.uniform(0.0, 0.05))
    gravity = coulomb * _between(generator, 0.2, 3.0) if generator.random() < 0.5 else 0.0
    saturation = coulomb * generator.uniform(0.2, 0.8) if generator.random() < 1.0 / 3.0 else 0.0
    bend = float(generator.uniform(0.1, 0.4) * np.max(np.abs(velocity)))
    phase, offset = generator.uniform(0.0, 2.0 * np.pi), coulomb * generator.uniform(-0.2, 0.2)
    motion = (time, position, velocity, acceleration)
    known = (inertia, coulomb, viscous, lag, gravity, phase, offset, saturation, bend)
    return Joint(rate, fine, duration, *motion, *known, int(generator.integers(4)))


def saturating(shape: int, relative: Array) -> Array:
    """Return friction that saturates, over its size, at a speed over that of its bend."""
    if shape == 0:
        return np.asarray(np.tanh(relative))
    if shape == 1:
        return np.asarray(-np.sign(relative) * np.expm1(-np.abs(relative)))
    if shape == 2:
        return np.asarray(relative / (1.0 + np.abs(relative)))
    return np.asarray(np.arctan(0.5 * np.pi * relative) / (0.5 * np.pi))  # none that is identified


def make_case(seed: int) -> Case:
    """Draw a joint, its motion and its sensors; the torque is exact but for what the sensors do."""
    generator = np.random.default_rng(seed)
    joint = draw_joint(generator)
    kept = joint.kept
    time, position, torque = joint.time[kept], joint.position[kept], joint.torque()
    whole = float(np.std(torque))
    share = joint.inertia * float(np.std(joint.acceleration[kept])) / whole
    counts = 2.0 ** generator.integers(12, 21)
    position = np.round(position * counts / (2.0 * np.pi)) * (2.0 * np.pi / counts)
    unit = _noise(generator, time.size, 1.0 / joint.rate)
    level = _between(generator, 0.01, 0.1)
    reversals = int(np.count_nonzero(np.diff(np.sign(joint.velocity[kept])) != 0.0))
    truth = {"inertia": joint.inertia, "coulomb": joint.coulomb, "viscous": joint.viscous, "friction_lag": joint.lag}
    enough = reversals >= FEWEST_REVERSALS and share >= SMALLEST_SHARE
    models = _models(gravity=joint.gravity > 0.0, shape=joint.shape if joint.saturation > 0.0 else None)
    log = Log(f"log {seed}", time, torque + unit * whole * level, position=position)
    return Case(log, truth, joint.duration, enough, models, whole * level)


def _models(*, gravity: bool, shape: int | None) -> tuple[Terms, ...]:
    """Return the terms of a joint; ``shape`` is that of its saturation, None without one."""
    terms = (*BASE, "offset", *(GRAVITY if gravity else ()), LAG)
    if shape is None:
        return (terms,)
    return tuple((*terms, one) for one in (SATURATIONS[shape : shape + 1] or SATURATIONS))


def _motion(generator: np.random.Generator, time: Array) -> tuple[Array, Array, Array]:
    """Return position, velocity and acceleration of a sum of three to seven sines of 0.05 to 2 Hz."""
    omegas = 2.0 * np.pi * np.array([_between(generator, 0.05, 2.0) for _ in range(generator.integers(3, 8))])
    phases = generator.uniform(0.0, 2.0 * np.pi, omegas.size)
    sizes = generator.uniform(0.3, 1.0, omegas.size) * (omegas / (2.0 * np.pi)) ** -0.5
    sizes *= _between(generator, 0.3, 3.0) / np.sum(sizes)
    angle = np.outer(omegas, time) + phases[:, np.newaxis]
    return -(sizes / omegas) @ np.cos(angle), sizes @ np.sin(angle), (sizes * omegas) @ np.cos(angle)


def _lagged(static: Array, lag: float, step: float) -> Array:
    """Return friction that follows the static one with a lag: the exact step for a value held over a fine step."""
    if lag < 0.1 * step:
        return static
    decay = np.exp(-step / lag)
    followed: Array = signal.lfilter([1.0 - decay], [1.0, -decay], static)
    return followed


def _noise(generator: np.random.Generator, size: int, period: float) -> Array:
    """Return noise of unit deviation, half white and half with a time constant of 20 ms."""
    decay = np.exp(-period / CORRELATED)
    coloured = signal.lfilter([np.sqrt(1.0 - decay**2)], [1.0, -decay], generator.standard_normal(size + 500))[500:]
    noise: Array = np.sqrt(0.5) * (coloured + generator.standard_normal(size))
    return noise


def examine(case: Case, **asked: Any) -> dict[str, Any]:
    """Identify a log, with a map where it is asked for, and compare the intervals with the truth."""
    result: dict[str, Any] = {"log": case.log.name, "duration": case.duration, "enough": case.enough, "refused": None}
    try:
        found = identify_log(case.log, held_out=0.0, **asked)
    except InputError as error:
        return {**result, "refused": str(error)}
    result["terms"] = list(found.selection.chosen.terms)
    result["map"] = found.position_map is not None
    result["bandwidth"] = found.bandwidth
    result["held"] = any("after its stamp" in caution for caution in found.cautions)
    for name in (*NAMES, *SLOW):
        if name in NAMES or (name in case.truth and name in found.parameters and found.parameters[name].used):
            result[name] = _beside_truth(found.parameters[name], case.truth[name])
    return result


def _beside_truth(reported: Reported, true: float) -> dict[str, Any]:
    """Return what is said of a parameter, beside its true value."""
    value, _, lower, upper = reported.estimate
    return {
        "true": true,
        "value": value,
        "covers": bool(lower <= true <= upper),
        "half_width": 0.5 * (upper - lower) / true,
        "error": value / true - 1.0,
        "vague": 0.5 * (upper - lower) / abs(value),
        "apart": reported.identifiable,
        "flagged": bool(reported.confounded) or not reported.identifiable,
    }


def main(
    logs: Annotated[int, typer.Option(min=1, help="Number of logs.")] = 500,
    first: Annotated[int, typer.Option(min=0, help="Seed of the first log.")] = FIRST_SEED,
    position_period: Annotated[
        list[float] | None, typer.Option(help="Period that a map is asked for with, rad.")
    ] = None,
    position_hats: Annotated[int, typer.Option(help="Hats that a map is asked for with.")] = 0,
    json: Annotated[Path | None, typer.Option(help="Write all results there.")] = None,
) -> None:
    """Print coverage and width of the stated intervals."""
    asked = {"position_periods": tuple(position_period or ()), "position_hats": position_hats}
    results = [examine(make_case(seed), **asked) for seed in range(first, first + logs)]
    console = wide_console()
    console.print(coverage_table(results))
    console.print(flag_sentence(results))
    held = sum(result["refused"] is None and result["held"] for result in results)
    console.print(f"A torque is said to be held in {held} of {logs} logs; it is in none.")
    if any(asked.values()):
        maps = sum(result["refused"] is None and result["map"] for result in results)
        console.print(f"A map is chosen in {maps} of {logs} logs, none of which has one.")
    if json is not None:
        write_json(json, {"logs": results})


def coverage_table(results: list[dict[str, Any]]) -> Table:
    """Return coverage, width and flags, one parameter a row."""
    answered = [result for result in results if result["refused"] is None]
    judged = [result for result in answered if result["duration"] >= LONG and result["enough"]]
    table = Table(
        title=f"Stated 95 % intervals, {len(results)} logs, {len(results) - len(answered)} refused; width on "
        f"{len(judged)} logs of {LONG:g} s or more with enough motion",
        box=SIMPLE,
    )
    headings = ("parameter", "holds the truth", "where not flagged", "median half width", "median error", "flagged")
    for heading in headings:
        table.add_column(heading, justify="left" if heading == "parameter" else "right")
    for name in NAMES:
        whole = [result[name] for result in answered]
        clear = [one for one in whole if not one["flagged"]]
        width = float(np.median([result[name]["half_width"] for result in judged])) if judged else np.nan
        error = float(np.median([abs(one["error"]) for one in whole])) if whole else np.nan
        table.add_row(
            name,
            _percent([one["covers"] for one in whole]),
            _percent([one["covers"] for one in clear]),
            f"{100.0 * width:.1f} %",
            f"{100.0 * error:.1f} %",
            _percent([one["flagged"] for one in whole]),
        )
    either = [any(result[name]["flagged"] for name in NAMES) for result in answered]
    refused = [True] * (len(results) - len(answered))
    table.add_row("any, or refused", "", "", "", "", _percent([*either, *refused]))
    return table


def flag_sentence(results: list[dict[str, Any]]) -> str:
    """Return how vague what is flagged is, and how many logs have something vague without a flag."""
    answered = [[result[name] for name in NAMES] for result in results if result["refused"] is None]
    shares = {}
    for least in (VAGUE, 2.0 * VAGUE):
        flags = [any(one["flagged"] and one["vague"] >= least for one in whole) for whole in answered]
        shares[least] = f"{_percent(flags)} from {100.0 * least:g} % of the value on"
    zero = _percent([any(not one["apart"] for one in whole) for whole in answered])
    vague = _percent([any(one["vague"] >= VAGUE for one in whole) for whole in answered])
    honest = _percent([one["covers"] for whole in answered for one in whole if one["flagged"]])
    return (
        f"Flagged by half width: {', '.join(shares.values())}; {zero} with zero inside. As vague, flagged or not: "
        f"{vague}. Flagged intervals hold the truth in {honest}."
    )


def _percent(flags: list[bool]) -> str:
    return f"{100.0 * np.mean(flags):.1f} %" if flags else ""


if __name__ == "__main__":
    typer.run(main)
