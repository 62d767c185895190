"""Joints stepped by their kernel alone: with torques, or along a path that is forced upon them."""

import numpy as np

from controllers import compiled, dispatched
from plant import STEP_JOINT, Joint

step_joint = dispatched(STEP_JOINT)
"""One solver period of any joint, compiled or not."""


def follow(joint, state, torques, period, motion):
    """Write the state after each step into a row of its own; row 0 is the start."""
    motion[0] = state
    for k in range(torques.size):
        state = step_joint(joint, state, torques[k], period)
        motion[k + 1] = state


FOLLOW = compiled(follow)


def turn(joint, state, torque, period, steps):
    """State of a joint after some steps with one torque."""
    for _ in range(steps):
        state = step_joint(joint, state, torque, period)
    return state


TURN = compiled(turn)


class CompiledJoint(Joint):
    """A joint in one's own loop whose steps are compiled: the same bits in less time; gravity is left out."""

    def step(self, torque, duration):
        steps, period = round(duration / self.model.solver_period), self.model.solver_period
        if steps == 1:  # a call costs more than a step
            return super().step(torque, duration)
        self.state = TURN(self._parameters, self.state, float(torque), period, steps)
        return self.state.velocity


def run(joint, state, torques, period, way=FOLLOW):
    """State of a joint after each step with torques; row 0 is the start."""
    motion = np.empty((torques.size + 1, len(state)))
    way(joint, state, np.ascontiguousarray(torques, dtype=float), period, motion)
    return motion


def ends(joint, start, torque, duration, periods):
    """State at the end of a duration for each solver period, with a torque of the middles of the steps."""
    middles = [period * (np.arange(round(duration / period)) + 0.5) for period in periods]
    return np.array([run(joint, start, torque(at), h)[-1] for at, h in zip(middles, periods, strict=True)])


def along_paths(step, rest):
    """Return a function that finds friction along a path, of a joint which is too heavy to be moved by it."""

    def friction_along(joint, path, period=1e-3, state=rest):
        held, torques = joint._replace(inertia=1e18), []
        for here, there in zip(path[:-1].tolist(), path[1:].tolist(), strict=True):
            state = step(held, state._replace(velocity=(there - here) / period), 0.0, period)
            torques.append(state.friction_torque)
        return np.array(torques)

    return friction_along
