"""Joints of another simulator, as their users drive them; encoders of few counts; cogging.

Nothing of ``plant`` is used: a joint with Stribeck friction, that may have a load and cogging, is integrated here, and
the controllers are stepped from a loop of one's own. Drawn by the seed are the joint (inertia over six decades), the
motion, the rate of the loop (100 Hz to 2 kHz), the sensor (a tachometer, or an encoder of 4000 to a million counts
before or behind a gear, differenced, low-passed or tracked by a filter of second order), whether its lag is given, the
position loop, the steps of the drive's torque, a period of delay, whether torque and preview are given, jitter of
5 %, and a given inertia up to 40 % wrong. The bandwidth leaves PI alone its margin: all lags together cost it
half a radian at most.
"""

import itertools
import math
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.friction.model import WITH_OFFSET
from adaptive_ff.simulation.tracking_errors import figures_of, tracking_errors
from adaptive_ff.studies.study import Found
from benchmarks.cases.stepped import controller_class
from benchmarks.suite import Case, seeded
from controllers import PI, DisturbanceObserver, PositionLoop, compiled

DURATION = 40.0  # s
STEP = 2e-4  # s, of the physics at most
TRACKING = 60.0 * math.pi  # rad/s, both poles of the tracking filter
PHASE = 0.5  # rad, that all lags together take from the loop at its bandwidth
MOTIONS = ("multisine", "sine", "trapezoids", "moves", "staircase")
SENSORS = ("tachometer", "encoder", "low-passed encoder", "tracked encoder")
Array = NDArray[np.float64]


class DrawnJoint(NamedTuple):
    """A joint: inertia, friction, constant load and cogging, in SI units; ``poles`` periods of cogging in a turn."""

    inertia: float
    coulomb: float
    stiction: float
    viscous: float
    stribeck_velocity: float
    load: float
    cogging: float
    poles: float


class DrawnLoop(NamedTuple):
    """How it is driven."""

    period: float  # sampling period, s
    bandwidth: float  # that of the velocity loop, Hz
    sensor: str  # one of ``SENSORS``
    resolution: float  # resolution, noise: step of the encoder, rad, and noise of the tachometer, rad/s
    noise: float
    low_pass: float  # time constant of the low-pass, s
    # cascade, tells_lag, tells_torque, tells_plan: whether a position loop is outside, and what the controller is
    # given
    cascade: bool
    tells_lag: bool
    tells_torque: bool
    tells_plan: bool
    levels: int  # steps of the drive's torque; zero for any torque
    delay: int  # computation delay, periods
    jitter: float  # largest change of a period, over the period
    inertia_error: float  # given inertia over the true one

    @property
    def velocity_lag(self) -> float:
        """Lag of the measured velocity, s."""
        filters = {"encoder": 0.5 * self.period, "low-passed encoder": 0.5 * self.period + self.low_pass}
        return {"tracked encoder": 2.0 / TRACKING, **filters}.get(self.sensor, 0.0)


def _advance_joint(joint: DrawnJoint, motion: Array, torque: float, duration: float, steps: int) -> None:
    """Advance position and velocity under a torque (N m) for a time (s); friction holds what it can."""
    step = duration / steps
    for _ in range(steps):
        angle, velocity = motion[0], motion[1]
        falling = (joint.stiction - joint.coulomb) * math.exp(-min(50.0, (velocity / joint.stribeck_velocity) ** 2))
        driving = torque - joint.load - joint.cogging * math.sin(joint.poles * angle) - joint.viscous * velocity
        free, held = velocity + step * driving / joint.inertia, step * (joint.coulomb + falling) / joint.inertia
        motion[1] = 0.0 if abs(free) <= held else free - math.copysign(held, free)
        motion[0] += step * motion[1]


advance_joint = compiled(_advance_joint)


def drawn_plan(kind: str, speed: float, period: float, random: np.random.Generator) -> Array:
    """Return a planned velocity (rad/s) of a kind that reaches about a speed (rad/s)."""
    time = period * np.arange(round(DURATION / period))
    if kind == "multisine":
        rates, phases = 2.0 * math.pi * random.uniform(0.05, 1.2, 6), random.uniform(0.0, 2.0 * math.pi, 6)
        sines = np.sin(np.outer(time, rates) + phases).sum(axis=1)
        return speed / np.abs(sines).max() * sines * np.minimum(1.0, time)
    if kind == "sine":
        return speed * np.sin(2.0 * math.pi * random.uniform(0.1, 0.8) * time)
    plan, begin, sign = np.zeros(time.size), round(0.3 / period), 1.0
    if kind == "staircase":
        slope = speed * period / random.uniform(0.1, 0.5)
        goal, until = speed * random.uniform(0.05, 1.0), random.uniform(1.0, 4.0)
        for k in range(1, time.size):
            if time[k] > until:
                sign, until = -sign, until + random.uniform(1.0, 4.0)
                goal = sign * speed * random.uniform(0.02, 1.0)
            plan[k] = plan[k - 1] + min(max(goal - plan[k - 1], -slope), slope)
        return plan
    while begin < time.size:
        fraction = np.linspace(0.0, 1.0, round(random.uniform(0.4, 3.0) / period), endpoint=False)
        top, ramp = speed * random.uniform(0.1, 1.0), random.uniform(0.1, 0.4)
        smooth, straight = 16.0 * np.square(fraction * (1.0 - fraction)), np.minimum(fraction, 1.0 - fraction) / ramp
        stroke = sign * top * (smooth if kind == "moves" else np.minimum(1.0, straight))
        end = min(time.size, begin + fraction.size)
        plan[begin:end] = stroke[: end - begin]
        sign = -sign if random.random() < 0.8 else sign
        begin = end + round(float(random.choice([0.0, 0.1, 0.5])) / period)
    return plan


def draw(seed: int) -> tuple[DrawnJoint, DrawnLoop, Array]:
    """Return the joint, the loop and the planned velocity (rad/s) of a seed."""
    random = np.random.default_rng([seed, 77])
    inertia, speed = 10.0 ** random.uniform(-4.0, 2.0), 10.0 ** random.uniform(-1.3, 1.3)
    coulomb = 6.0 * inertia * speed * 10.0 ** random.uniform(-0.7, 1.0)
    joint = DrawnJoint(
        inertia=inertia,
        coulomb=coulomb,
        stiction=coulomb * random.uniform(1.0, 1.6),
        viscous=coulomb / speed * random.uniform(0.0, 1.0),
        stribeck_velocity=speed * 10.0 ** random.uniform(-2.0, -0.5),
        load=coulomb * float(random.choice([0.0, 0.0, 0.3])),
        cogging=coulomb * float(random.choice([0.0, 0.0, 0.05, 0.2])),
        poles=float(random.choice([6, 36, 100])),
    )
    period, sensor = 1.0 / float(random.choice([100, 200, 250, 500, 1000, 2000])), str(random.choice(SENSORS))
    counts = float(random.choice([4000, 20000, 131072, 2**20])) * float(random.choice([1.0, 50.0]))
    loop = DrawnLoop(
        period=period,
        bandwidth=random.uniform(3.0, 15.0),
        sensor=sensor,
        resolution=2.0 * math.pi / counts,
        noise=speed * 10.0 ** random.uniform(-4.0, -2.0),
        low_pass=random.uniform(0.5, 3.0) * period,
        cascade=sensor != "tachometer" and bool(random.random() < 0.6),
        tells_lag=bool(random.random() < 0.7),
        tells_torque=bool(random.random() < 0.5),
        tells_plan=bool(random.random() < 0.8),
        levels=int(random.choice([0, 2**12, 2**16])),
        delay=int(random.choice([0, 0, 1])),
        jitter=float(random.choice([0.0, 0.0, 0.05])),
        inertia_error=float(random.choice([1.0, 1.0, 0.7, 1.4])),
    )
    lag = (loop.delay + 0.5) * period + loop.velocity_lag
    bandwidth = min(loop.bandwidth, 1.0 / (12.0 * period), PHASE / (2.0 * math.pi * lag))
    plan = drawn_plan(str(random.choice(MOTIONS)), speed, period, random)
    return joint, loop._replace(bandwidth=bandwidth), plan


class Velocity:
    """The measured velocity of a loop, from the true motion."""

    def __init__(self, loop: DrawnLoop, angle: float, random: np.random.Generator) -> None:
        self._loop, self._random = loop, random
        self.reading = self._tracked = loop.resolution * round(angle / loop.resolution)
        self._velocity, self._keep = 0.0, math.exp(-loop.period / loop.low_pass)

    def step(self, angle: float, velocity: float) -> float:
        """Return the velocity (rad/s) that is measured of an angle (rad) and a velocity."""
        loop, last = self._loop, self.reading
        self.reading = loop.resolution * round(angle / loop.resolution)
        if loop.sensor == "tachometer":
            return velocity + loop.noise * float(self._random.standard_normal())
        difference = (self.reading - last) / loop.period
        if loop.sensor == "encoder":
            return difference
        if loop.sensor == "low-passed encoder":
            self._velocity = difference + self._keep * (self._velocity - difference)
            return self._velocity
        fraction, moved = -math.expm1(-TRACKING * loop.period), loop.period * self._velocity
        missed = self.reading - self._tracked - moved
        self._tracked += moved + fraction * (2.0 - fraction) * missed
        self._velocity += fraction * fraction / loop.period * missed
        return self._velocity


class Driven(NamedTuple):
    """What a loop does, sample by sample."""

    errors: Array  # shape (n,): error of the position (rad) in a cascade, else of the velocity (rad/s)
    times: Array  # shape (n,): times of the samples, s
    readings: Array  # readings, measured: shape (n,): the encoder's position, rad, and the measured velocity, rad/s
    measured: Array
    torques: Array  # shape (n,): torque that acts from each sample to the next, N m


def drive(
    controller: Any, joint: DrawnJoint, loop: DrawnLoop, plan: Array, seed: int, *, tells_position: bool = False
) -> Driven:
    """Drive a joint along a planned velocity (rad/s); ``seed`` is that of its sensor, its clock and where it begins."""
    random, period = np.random.default_rng([seed, 78]), loop.period
    start = random.uniform(-math.pi, math.pi)
    path = start + np.concatenate([[0.0], np.cumsum(0.5 * period * (plan[1:] + plan[:-1]))])
    motion, sensor = np.array([start, 0.0]), Velocity(loop, start, random)
    outer = PositionLoop(PositionLoop.design(period=period, bandwidth=loop.bandwidth).gain)
    speed = float(np.abs(plan).max())
    largest = 3.0 * (joint.stiction + joint.load + joint.cogging + speed * (joint.viscous + 60.0 * joint.inertia))
    step, acted, coming, time = 2.0 * largest / max(loop.levels, 1), 0.0, 0.0, 0.0
    run = Driven(*(np.empty(plan.size - 1) for _ in Driven._fields))
    for k in range(plan.size - 1):
        run.errors[k] = path[k] - motion[0] if loop.cascade else plan[k] - motion[1]
        measured, given = sensor.step(float(motion[0]), float(motion[1])), {}
        run.times[k], run.readings[k], run.measured[k] = time, sensor.reading, measured
        if loop.cascade:
            given["correction"] = outer.step(float(path[k]), sensor.reading)
        if tells_position:
            given["position"] = sensor.reading
        if loop.tells_plan:
            given["next_reference"] = float(plan[k + 1])
        if loop.tells_torque and k > 0:
            given["realised_torque"] = acted
        torque = controller.step(float(plan[k]), measured, **given)
        if loop.levels > 0:
            torque = min(max(step * round(torque / step), -largest), largest)
        acted, coming = (coming, torque) if loop.delay > 0 else (torque, torque)
        lasts = period * (1.0 + loop.jitter * random.uniform(-1.0, 1.0))
        run.torques[k], time = acted, time + lasts
        advance_joint(joint, motion, acted, lasts, max(2, math.ceil(period / STEP)))
    return run


def loop_gains(joint: DrawnJoint, loop: DrawnLoop) -> tuple[float, float, float]:
    """Return both gains of the PI loop, for the given inertia, and its sampling period (s)."""
    given = loop.inertia_error * joint.inertia
    design = PI.design(inertia=given, period=loop.period, bandwidth=loop.bandwidth)
    return design.proportional, design.integral, loop.period


def made(name: str, joint: DrawnJoint, loop: DrawnLoop, **options: Any) -> Any:
    """Make a controller for a joint and its loop; the options are those of an adaptive one."""
    gains, inertia = loop_gains(joint, loop), loop.inertia_error * joint.inertia
    if name == "pi":
        return PI(*gains)
    if name == "disturbance_observer":
        return DisturbanceObserver(*gains, inertia=inertia, bandwidth=min(loop.bandwidth, OBSERVER), delay=loop.delay)
    lag, assumed = loop.velocity_lag if loop.tells_lag else 0.0, 2.0 * joint.stribeck_velocity
    known = {"inertia": inertia, "stribeck_velocity": assumed, "velocity_lag": lag, "delay": float(loop.delay)}
    return controller_class(name)(*gains, **known, **options)


def figures_on(
    row: str, joint: DrawnJoint, loop: DrawnLoop, plan: Array, seed: int, controllers: list[str], **options: Any
) -> Found:
    """Run controllers on a joint of a row; with options of the adaptive ones they are given the position."""
    errors = {}
    for name in dict.fromkeys(["pi", *controllers]):
        run = drive(made(name, joint, loop, **options), joint, loop, plan, seed, tells_position=bool(options))
        errors[name] = tracking_errors(np.square(run.errors), loop.period)
    return {"": {"row": row}, **figures_of(errors)}


def run_joint(seed: int, controllers: list[str]) -> Found:
    """Drive the joint of a seed; its row says what the controller is not given, or how fine its encoder is."""
    joint, loop, plan = draw(seed)
    return figures_on(row_of(loop, plan), joint, loop, plan, seed, controllers)


def row_of(loop: DrawnLoop, plan: Array) -> str:
    """Return the row of a loop by what its controller is not given."""
    if loop.sensor != "tachometer" and loop.resolution > loop.period * float(np.abs(plan).max()):
        return "less than a count in a period"
    if loop.velocity_lag > 0.0 and not loop.tells_lag:
        return "lag of the velocity unspecified"
    if not loop.tells_plan:
        return "coming reference unspecified"
    return "all specified" if loop.tells_torque else "torque of the drive unspecified"


joints = seeded(run_joint, {"joint": ()})

COUNTS = (0.1, 0.3, 1.0, 3.0, 10.0)  # encoder counts in a sampling period at the largest speed

ENCODERS = {"encoder": "differenced", "low-passed encoder": "low-passed"}


def run_coarse(sensor: str, counts: float, seed: int, controllers: list[str]) -> Found:
    """Drive the joint of a seed with an encoder of few counts."""
    joint, loop, plan = draw(seed)
    coarse = loop._replace(sensor=sensor, resolution=float(np.abs(plan).max()) * loop.period / counts)
    return figures_on(f"{counts:g} counts, {ENCODERS[sensor]}", joint, coarse, plan, seed, controllers)


COARSE = {f"{sensor}, {counts:g}": (sensor, counts) for sensor in ENCODERS for counts in COUNTS}
coarse_encoders = seeded(run_coarse, COARSE)

FRACTIONS = (0.0, 0.1, 0.3, 0.6)  # amplitude of the cogging of drawn joints, over their Coulomb friction

FEWEST_COUNTS, COARSEST = 20.0, 0.02
"""Counts in a period of cogging, and a count in a sampling period over the largest speed, that are taken."""

OBSERVER = 10.0  # largest bandwidth of the disturbance observer of drawn joints, Hz; else it is that of the loop


def run_cogged(seed: int, fraction: float, given: bool, controllers: list[str]) -> Found:
    """Drive the joint of a seed with cogging, whose period the controller is given or not."""
    joint, loop, plan = draw(seed)
    cogged = joint._replace(cogging=fraction * joint.coulomb)
    options = {"parameters": WITH_OFFSET, "ripple_periods": [2.0 * math.pi / joint.poles] if given else []}
    row = f"{fraction:g} of Fc, period {'given' if given else 'unspecified'}"
    return figures_on(row, cogged, loop, plan, seed, controllers, **options)


def cogging(count: int, first: int = 1) -> list[Case]:
    """Return those of the same joints whose encoder resolves cogging, with some of it."""
    seeds = [seed for seed in range(first, first + 2 * count) if _resolves(seed)][:count]
    return [
        Case(f"{fraction:g}, {given}/{seed}", seed, partial(run_cogged, seed, fraction, given))
        for fraction, given, seed in itertools.product(FRACTIONS, (False, True), seeds)
    ]


def _resolves(seed: int) -> bool:
    joint, loop, plan = draw(seed)
    fastest = float(np.abs(plan).max())
    coarse = loop.sensor == "encoder" and loop.resolution > COARSEST * fastest * loop.period
    return not coarse and 2.0 * math.pi / (joint.poles * loop.resolution) >= FEWEST_COUNTS
