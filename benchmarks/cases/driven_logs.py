"""Logs as a laboratory would record them of joints that stick under PI alone, of another simulator.

Friction has a stiction that falls with the square of the speed; motion is not designed to identify anything. The truth
of Coulomb and viscous friction is the line that fits the static friction of the motion best.
"""

from typing import NamedTuple

import numpy as np

from adaptive_ff.logs.log import Log
from benchmarks.cases.other_joints import draw, drive, loop_gains
from controllers import PI

NOISES = (0.005, 0.05)  # least and largest noise of the recorded torque, over the Coulomb friction
STREAM = 79  # stream of random numbers of that noise
COARSE = 3.0  # counts in a sample at half of the largest planned speed below which an encoder counts as coarse


class Driven(NamedTuple):
    """A log with its truth, the time (s) after its stamp at which a torque acts, and what the log lacks."""

    log: Log
    truth: dict[str, float]
    delay: float
    kind: str


def driven_case(seed: int) -> Driven:
    """Return the log of a seed."""
    joint, loop, plan = draw(seed)
    run = drive(PI(*loop_gains(joint, loop)), joint, loop, plan, seed)
    random = np.random.default_rng([seed, STREAM])
    noise = joint.coulomb * NOISES[0] * (NOISES[1] / NOISES[0]) ** random.random()
    torque = run.torques + noise * random.standard_normal(run.torques.size)
    tachometer = loop.sensor == "tachometer"
    motion = {"velocity": run.measured} if tachometer else {"position": run.readings}
    log = Log(f"joint {seed}", run.times, torque, **motion)
    velocity = np.gradient(run.readings, run.times) if not tachometer else run.measured
    speed = np.abs(velocity)
    falling = (joint.stiction - joint.coulomb) * np.exp(-((speed / joint.stribeck_velocity) ** 2))
    static = np.sign(velocity) * (joint.coulomb + falling) + joint.viscous * velocity
    slides = speed > 0.02 * np.quantile(speed, 0.95)
    line = np.linalg.lstsq(np.column_stack([np.sign(velocity), velocity])[slides], static[slides])[0]
    truth = {"inertia": joint.inertia, "coulomb": float(line[0]), "viscous": float(line[1])}
    counts = 0.5 * float(np.abs(plan).max()) * loop.period / loop.resolution
    kind = "coarse encoder" if counts < COARSE and not tachometer else "cogging" if joint.cogging > 0.0 else "other"
    return Driven(log, truth, 0.5 * loop.period, kind)
