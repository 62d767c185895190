"""Joints stepped by their kernel alone: with torques, or along a path that is forced upon them."""

import numpy as np


def with_torques(step):
    """Return a function, for numba as well, that steps a joint: its state after each step; row 0 is the start."""

    def run(joint, state, torques, period):
        motion = np.empty((torques.size + 1, len(state)))
        motion[0] = state
        for k in range(torques.size):
            state = step(joint, state, torques[k], period)
            motion[k + 1] = state
        return motion

    return run


def along_paths(step, rest):
    """Return a function that finds friction along a path, of a joint which is too heavy to be moved by it."""

    def friction_along(joint, path, period=1e-3, state=rest):
        held, torques = joint._replace(inertia=1e18), []
        for here, there in zip(path[:-1].tolist(), path[1:].tolist(), strict=True):
            state = step(held, state._replace(velocity=(there - here) / period), 0.0, period)
            torques.append(state.friction_torque)
        return np.array(torques)

    return friction_along
