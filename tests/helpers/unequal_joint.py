"""A joint whose friction differs by direction, with a load, stepped by the plant's own step."""

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

    @property
    def plant(self):
        """The joint as the plant knows it."""
        forward, backward = zip(*self[:3], strict=True)
        return JointModel(
            inertia=INERTIA,
            friction_lag=LAG,
            stribeck_velocity=STRIBECK_VELOCITY,
            offset=self.load,
            **dict(zip(("coulomb", "stiction", "viscous"), forward, strict=True)),
            **dict(zip(("coulomb_backward", "stiction_backward", "viscous_backward"), backward, strict=True)),
        )


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


def applied(torques, whole, rest):
    """Torque of the first part of a period, the share ``rest`` of it, and of what follows, from those asked for."""
    queue = [0.0] * (whole + 2) + torques
    late = queue[-1 - whole]
    return (queue[-2 - whole] if rest else late), late


def unequal_loop(controller, setup, joint=EQUAL, *, delay=0.0, limit=400.0, tell=True, known=None):
    """Run a controller's ``step`` around an unequal joint behind a drive with computation delay, in periods.

    ``known`` are further loads, a sample each, given as ``feedforward``; each acts while the torque of its sample does.
    Return the error on the solver's grid, and the torques that were asked for.
    """
    whole, rest = int(delay), delay - int(delay)
    plant, realised, asked = UnequalJoint(joint, float(setup.reference[0])), None, []
    loads = np.zeros(setup.noise.size) if known is None else known
    velocity, held = [np.array([setup.reference[0]])], []
    for k, (first, last) in enumerate(zip(setup.samples[:-1], setup.samples[1:], strict=True)):
        torque = controller.step(
            setup.reference[first],
            plant.state.velocity + setup.noise[k],
            next_reference=setup.reference[last],
            realised_torque=realised if tell else None,
            feedforward=loads[k],
        )
        asked.append(torque)
        held.append(min(max(torque, -limit), limit))
        (early, late), (early_load, late_load) = (applied(list(s), whole, rest) for s in (held, loads[: k + 1]))
        waiting = round(rest * (last - first))
        velocity += [plant.step(early - early_load, waiting), plant.step(late - late_load, last - first - waiting)]
        realised = (waiting * early + (last - first - waiting) * late) / (last - first)
    return np.concatenate(velocity) - setup.reference[: setup.samples[-1] + 1], np.array(asked)


def rms(error, seconds):
    """Root of the mean square over the last seconds, mrad/s."""
    return 1e3 * float(np.sqrt(np.mean(error[-round(seconds / SOLVER) :] ** 2)))
