"""A joint whose friction differs by direction, with a load, stepped by the plant's own step."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from adaptive_ff import TorqueModel
from plant import JointModel, initial_state, step_joint

INERTIA, LAG, STRIBECK_VELOCITY, SOLVER = 20.0, 0.02, 0.05, 0.001


class Unequal(NamedTuple):
    """Friction for positive and for negative velocity, and the torque of a constant load."""

    coulomb: tuple[float, float] = (75.0, 45.0)
    stiction: tuple[float, float] = (95.0, 80.0)
    viscous: tuple[float, float] = (60.0, 110.0)
    load: float = -20.0

    @property
    def model(self):
        """The joint as a model that may be fed forward."""
        return TorqueModel.from_directions(INERTIA, *self[:3], LAG, STRIBECK_VELOCITY, 1.0, self.load)


EQUAL = Unequal((60.0, 60.0), (90.0, 90.0), (80.0, 80.0), 0.0)


class UnequalJoint:
    """Steps a joint; each solver step takes the friction of the direction that the joint is about to move in."""

    def __init__(self, joint, velocity):
        friction = zip(joint.coulomb, joint.stiction, joint.viscous, strict=True)
        self._directions = [
            JointModel(
                inertia=INERTIA,
                coulomb=coulomb,
                stiction=stiction,
                viscous=viscous,
                friction_lag=LAG,
                stribeck_velocity=STRIBECK_VELOCITY,
            ).parameters
            for coulomb, stiction, viscous in friction
        ]
        self._load = joint.load
        self.state = initial_state(self._directions[0], velocity)

    def step(self, torque, steps):
        """Apply a torque (N m) for some solver steps; return the velocities."""
        velocities = np.empty(steps)
        for i in range(steps):
            drive = torque - self._load
            free = self.state.velocity + SOLVER / INERTIA * (drive - LAG * self.state.friction_torque / (LAG + SOLVER))
            self.state = step_joint(self._directions[0 if free > 0.0 else 1], self.state, drive, SOLVER)
            velocities[i] = self.state.velocity
        return velocities


def delayed_torques(commands: Iterable[float], whole: int, rest: float) -> tuple[float, float]:
    """Torques of the first part ``rest`` of a period and of what follows it, from commands, the newest last."""
    queue = [0.0] * (whole + 2) + list(commands)
    return (queue[-2 - whole], queue[-1 - whole]) if rest else (queue[-1 - whole], queue[-1 - whole])


def unequal_loop(controller, course, joint=EQUAL, *, delay=0.0, limit=400.0, tell=True):
    """Run a controller's ``step`` around an unequal joint behind a drive with computation delay, in periods.

    Return the error on the solver's grid, and the torques that acted over each period.
    """
    whole, rest = int(delay), delay - int(delay)
    plant, realised, commands = UnequalJoint(joint, float(course.reference[0])), None, []
    velocity, means = [np.array([course.reference[0]])], []
    for k, (first, last) in enumerate(zip(course.samples[:-1], course.samples[1:], strict=True)):
        torque = controller.step(
            course.reference[first],
            plant.state.velocity + course.noise[k],
            next_reference=course.reference[last],
            realised_torque=realised if tell else None,
        )
        commands.append(min(max(torque, -limit), limit))
        early, late = delayed_torques(commands[-3 - whole :], whole, rest)
        waiting = round(rest * (last - first))
        velocity += [plant.step(early, waiting), plant.step(late, last - first - waiting)]
        realised = (waiting * early + (last - first - waiting) * late) / (last - first)
        means.append(realised)
    return np.concatenate(velocity) - course.reference[: course.samples[-1] + 1], np.array(means)


def rms(error, seconds):
    """Root of the mean square over the last seconds, mrad/s."""
    return 1e3 * float(np.sqrt(np.mean(error[-round(seconds / SOLVER) :] ** 2)))
