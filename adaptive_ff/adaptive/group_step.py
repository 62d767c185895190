"""One sample of all joints of a group in one compiled call.

The joints are a tuple, of which compiled code takes one after the other, by types: the step of a joint is compiled once
for joints of the same types, and the time grows with the number of joints.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numba.extending import overload, register_jitable
from numpy.typing import NDArray

from controllers import Inputs, compiled_in_place, step

COLUMNS = Inputs._fields
"""Columns of the inputs of a group."""


@register_jitable
def step_one(block: Any, state: Any, rows: NDArray[np.float64], joint: int, torques: NDArray[np.float64]) -> Any:
    """Step one joint of a group; write its torque and return its new state."""
    row = rows[joint]
    inputs = Inputs(row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8])
    output, new = step(block, state, inputs)
    torques[joint] = output.torque
    return new


def step_joints(
    blocks: Any, states: Any, rows: NDArray[np.float64], joint: int, torques: NDArray[np.float64]
) -> tuple[Any, ...]:
    """Step all joints from one on.

    Parameters
    ----------
    blocks, states : tuple of NamedTuple
        Parameters and states of the joints from ``joint`` on.
    rows : ndarray, shape (n, 9)
        Inputs of all joints, a column for each field of ``Inputs``.
    joint : int
        The first joint.
    torques : ndarray, shape (n,)
        Commanded torques, N m; filled in from ``joint`` on.

    Returns
    -------
    tuple of NamedTuple
        The new states.
    """
    pairs = enumerate(zip(blocks, states, strict=True), joint)
    return tuple(step_one(block, state, rows, k, torques) for k, (block, state) in pairs)


def _compiled_joints(blocks: Any, states: Any, rows: Any, joint: Any, torques: Any) -> Callable[..., Any]:
    def step_last(blocks: Any, states: Any, rows: Any, joint: Any, torques: Any) -> Any:
        return (step_one(blocks[0], states[0], rows, joint, torques),)

    def step_first(blocks: Any, states: Any, rows: Any, joint: Any, torques: Any) -> Any:
        first = step_one(blocks[0], states[0], rows, joint, torques)
        return (first, *step_joints(blocks[1:], states[1:], rows, joint + 1, torques))

    return step_first if len(blocks) > 1 else step_last


overload(step_joints)(_compiled_joints)


def _step_group(blocks: Any, states: Any, rows: Any, torques: Any) -> Any:
    return step_joints(blocks, states, rows, 0, torques)


step_group = compiled_in_place(_step_group)
"""Step all joints of a group: ``(blocks, states, rows, torques) -> states``; writes the torques."""
