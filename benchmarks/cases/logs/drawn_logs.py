"""Logs of joints that are known, half of them with physics that ``identify`` has no term for.

A motion is prescribed at a fine rate and the torque that it takes is computed along it, friction states included; then
sensors sample it. The first half has the terms of the identified models: Coulomb and viscous friction, offset, gravity,
in some a lag, a Stribeck curve, viscous friction that bends or differs by direction. The second half has friction laws
of other forms (LuGre, Maxwell slip, a power of the speed, a smooth sign), friction that warms up or depends on position
or load, an elastic gear, coupling torques, a filtered or late torque, coarse encoders, and clocks that jitter. Of
these friction over load is a term of the models as well.

Beside them are joints of another simulator that stick under PI alone: stiction falls with the square of the speed.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from adaptive_ff.logs.log import Log
from benchmarks.cases.other_joints import draw, drive, loop_gains
from controllers import PI

Array = NDArray[np.float64]

FINE = 4000.0  # rate at which motion and friction are computed, Hz

MODELLED = ("plain", "lag", "stribeck", "bend", "directions")
FOREIGN = ("lugre", "maxwell", "power", "smooth", "warming", "position", "load", "elastic", "coupled", "late")
TERMS = (*MODELLED, "load")  # what the identified models have terms for


class Case(NamedTuple):
    """A log with its truth."""

    log: Log
    truth: dict[str, float]  # inertia, and of the static friction along the motion ``coulomb`` and ``viscous``
    kind: str  # which physics, or what the log lacks
    delay: float = 0.0  # time after its stamp at which a torque acts, s


class Motion(NamedTuple):
    """A motion: time, position, velocity, acceleration at the fine rate."""

    time: Array
    position: Array
    velocity: Array
    acceleration: Array


def between(generator: np.random.Generator, low: float, high: float) -> float:
    """Draw a number whose logarithm is uniform."""
    return float(low * (high / low) ** generator.random())


def draw_motion(generator: np.random.Generator, duration: float, speed: float, pace: float) -> Motion:
    """Draw a motion: sines, moves from point to point, or a triangle with rounded corners."""
    time = np.arange(round((duration + 1.0) * FINE)) / FINE - 1.0
    kind = generator.integers(3)
    if kind == 0:
        omegas = 2.0 * np.pi * pace * np.array([between(generator, 0.3, 3.0) for _ in range(generator.integers(3, 8))])
        sizes = generator.uniform(0.3, 1.0, omegas.size) * omegas**-0.5
        phases = generator.uniform(0.0, 2.0 * np.pi, omegas.size)
        velocity = np.sin(np.outer(time, omegas) + phases) @ sizes
    else:
        velocity = np.zeros(time.size)
        place, begin = 0.0, 0
        while begin < time.size:
            target = generator.uniform(-1.0, 1.0) if kind == 1 else (1.0 if place <= 0.0 else -1.0)
            slower = 1.0 if kind == 2 else generator.uniform(0.7, 1.5)
            length = max(8, round(FINE / pace * abs(target - place) * 0.5 * slower))
            stop = min(begin + length, time.size)
            velocity[begin:stop] = (target - place) * FINE / length
            place, begin = target, begin + length
        width = round(FINE * 0.25 * generator.uniform(0.3, 1.0) / pace)
        window = np.hanning(width + 2)[1:-1]
        velocity = signal.fftconvolve(velocity, window / window.sum(), "same")
    velocity *= speed / np.quantile(np.abs(velocity), 0.98)
    position = np.cumsum(velocity) / FINE
    position += generator.uniform(-1.0, 1.0) - position.mean()
    return Motion(time, position, velocity, np.gradient(velocity, 1.0 / FINE))


class Law(NamedTuple):
    """Friction of a joint: its static curve by speed, and its torque along the motion."""

    static: Array
    torque: Array


def _lagged(values: Array, lag: float) -> Array:
    if lag * FINE < 0.2:
        return values
    decay = math.exp(-1.0 / (FINE * lag))
    return np.asarray(signal.lfilter([1.0 - decay], [1.0, -decay], values))


def _over_path(velocity: Array, limit: Array, path: float, steep: float = 1.0) -> Array:
    """Return friction that follows its static curve over a path: Dahl's law, and that of LuGre's bristles."""
    state, result = 0.0, []
    step = (np.abs(velocity) / FINE / path).tolist()
    for along, towards in zip(step, limit.tolist(), strict=True):
        state = towards + (state - towards) * math.exp(-steep * along)
        result.append(state)
    return np.array(result)


def draw_friction(generator: np.random.Generator, kind: str, coulomb: float, viscous: float, motion: Motion) -> Law:
    """Draw a friction law."""
    velocity, top = motion.velocity, float(np.quantile(np.abs(motion.velocity), 0.98))
    speed, sign = np.abs(velocity), np.sign(velocity)
    static = coulomb * sign + viscous * velocity
    if kind == "lag":
        return Law(static, _lagged(static, between(generator, 0.002, 0.05)))
    if kind == "stribeck" or kind == "lugre":
        excess, slow = coulomb * generator.uniform(0.2, 0.6), top * between(generator, 0.02, 0.2)
        static = static + excess * sign * np.exp(-((speed / slow) ** generator.uniform(0.8, 2.0)))
    if kind == "bend":
        bend = top * between(generator, 0.05, 0.3)
        static = static + coulomb * generator.uniform(0.2, 0.8) * np.tanh(velocity / bend)
    if kind == "directions":
        static = static + viscous * generator.uniform(-0.3, 0.3) * speed
    if kind == "lugre":
        limit = static - viscous * velocity
        return Law(static, _over_path(velocity, limit, top * between(generator, 3e-4, 1e-2)) + viscous * velocity)
    if kind == "maxwell":
        paths = [top * between(generator, 3e-4, 3e-2) for _ in range(3)]
        shares = generator.dirichlet(np.ones(3))
        limit, parts = coulomb * sign, zip(shares, paths, strict=True)
        return Law(static, sum(part * _over_path(velocity, limit, path) for part, path in parts) + viscous * velocity)
    if kind == "power":
        static = coulomb * sign + viscous * top * sign * (speed / top) ** generator.uniform(0.4, 1.6)
    if kind == "smooth":
        slow = top * between(generator, 0.005, 0.05)
        static = coulomb * (2.0 / np.pi) * np.arctan(velocity / slow) + viscous * velocity
    if kind == "warming":
        warm = 1.0 + generator.uniform(-0.3, 0.3) * np.exp(-(motion.time + 1.0) / between(generator, 5.0, 100.0))
        return Law(static, static * warm)
    if kind == "position":
        period = between(generator, 0.05, 2.0)
        wave = 1.0 + generator.uniform(0.1, 0.4) * np.sin(2.0 * np.pi * motion.position / period)
        return Law(static, static * wave)
    return Law(static, static)


TACHOMETER = (0.003, 0.1)  # least and largest noise of a measured velocity, over the velocity, both rms


def make_case(seed: int, *, record: int = 0, tachometer: bool = False) -> Case:
    """Draw a joint and record it; other records of the same seed have the joint in common, but not the motion.

    With a tachometer the velocity is recorded, with white noise, and not the position.
    """
    generator = np.random.default_rng([seed, 1])
    kind = str(generator.choice(FOREIGN if seed % 2 else MODELLED))
    rate = float(generator.choice([25.0, 50.0, 100.0, 250.0, 500.0, 1000.0]))
    pace = between(generator, 0.1, min(1.5, rate / 60.0))
    speed = between(generator, 0.3, 5.0)
    typical = speed * 2.0 * np.pi * pace
    inertia = between(generator, 0.01, 20.0)
    coulomb = inertia * typical * between(generator, 0.15, 2.0)
    viscous = coulomb * between(generator, 0.2, 2.0) / speed
    weight = coulomb * between(generator, 0.2, 3.0) if generator.random() < 0.5 else 0.0
    phase, offset = generator.uniform(0.0, 2.0 * np.pi), coulomb * generator.uniform(-0.3, 0.3)
    counts, level, jitter = 2.0 ** generator.integers(12, 21), between(generator, 0.005, 0.1), generator.random()
    moves = np.random.default_rng([seed, 2, record])
    duration = float(moves.uniform(15.0, 60.0))
    motion = draw_motion(moves, duration, speed, pace)
    law = draw_friction(generator, kind, coulomb, viscous, motion)
    pull = weight * np.sin(motion.position + phase)
    torque, position = inertia * motion.acceleration + law.torque + offset + pull, motion.position
    if kind == "load":
        carried = np.abs(pull + inertia * motion.acceleration)
        torque = torque + generator.uniform(0.05, 0.3) * carried * np.sign(motion.velocity)
    if kind == "elastic":
        stiffness = 0.5 * inertia * (2.0 * np.pi * between(generator, 8.0, 40.0) * max(1.0, pace)) ** 2
        position = position + signal.fftconvolve(torque, np.ones(20) / 20, "same") / stiffness
    if kind == "coupled":
        rates = pace * np.array([between(moves, 0.2, 3.0) for _ in range(4)])
        other = np.sin(2.0 * np.pi * np.outer(motion.time, rates) + moves.uniform(0, 6.3, 4)).sum(axis=1)
        torque = torque + generator.uniform(0.05, 0.25) * np.std(torque) * other / np.std(other)
    if kind == "late":
        torque = _lagged(torque, between(generator, 0.001, 0.01))
        torque = np.roll(torque, round(FINE / rate * generator.uniform(-0.5, 1.0)))
    time = np.arange(0.0, duration, 1.0 / rate)
    if jitter > 0.8:
        time = time + moves.uniform(-0.3, 0.3, time.size) / rate
        time = time[(time >= 0.0) & (time < duration)]
    torque, position = (np.interp(time, motion.time, one) for one in (torque, position))
    decay = math.exp(-1.0 / (rate * 0.02))
    white = moves.standard_normal((2, time.size + 500))
    coloured = signal.lfilter([math.sqrt(1.0 - decay**2)], [1.0, -decay], white[0])[500:]
    torque = torque + level * np.std(torque) * math.sqrt(0.5) * (coloured + white[1, 500:])
    step = 2.0 * np.pi / counts
    log = Log(f"log {seed}", time, torque, position=np.round(position / step) * step)
    if tachometer:
        velocity = np.interp(time, motion.time, motion.velocity)
        noise = between(moves, *TACHOMETER) * np.std(velocity) * moves.standard_normal(time.size)
        log = Log(f"log {seed}", time, torque, velocity=velocity + noise)
    return Case(log, truth_of(inertia, law.static, motion.velocity), kind)


def truth_of(inertia: float, static: Array, velocity: Array) -> dict[str, float]:
    """Return the inertia, and the line through the static friction over the speeds of a motion, by least squares."""
    moving = np.abs(velocity) > 0.02 * np.quantile(np.abs(velocity), 0.95)
    line = np.linalg.lstsq(np.column_stack([np.sign(velocity), velocity])[moving], static[moving])[0]
    return {"inertia": inertia, "coulomb": float(line[0]), "viscous": float(line[1])}


NOISES = (0.005, 0.05)  # least and largest noise of the torque of a joint under PI alone, over its Coulomb friction
STREAM = 79  # stream of random numbers of that noise
COARSE = 3.0  # counts in a sample at half of the largest planned speed below which an encoder counts as coarse


def driven_case(seed: int) -> Case:
    """Return the log of a joint of another simulator under PI alone, whose motion is not designed to identify it."""
    joint, loop, plan = draw(seed)
    run = drive(PI(*loop_gains(joint, loop)), joint, loop, plan, seed)
    random = np.random.default_rng([seed, STREAM])
    noise = joint.coulomb * NOISES[0] * (NOISES[1] / NOISES[0]) ** random.random()
    torque = run.torques + noise * random.standard_normal(run.torques.size)
    tachometer = loop.sensor == "tachometer"
    motion = {"velocity": run.measured} if tachometer else {"position": run.readings}
    velocity = run.measured if tachometer else np.gradient(run.readings, run.times)
    falling = (joint.stiction - joint.coulomb) * np.exp(-((velocity / joint.stribeck_velocity) ** 2))
    static = np.sign(velocity) * (joint.coulomb + falling) + joint.viscous * velocity
    counts = 0.5 * float(np.abs(plan).max()) * loop.period / loop.resolution
    kind = "coarse encoder" if counts < COARSE and not tachometer else "cogging" if joint.cogging > 0.0 else "other"
    log = Log(f"joint {seed}", run.times, torque, **motion)
    return Case(log, truth_of(joint.inertia, static, velocity), kind, 0.5 * loop.period)
