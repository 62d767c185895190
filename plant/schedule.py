"""Friction that changes at given times."""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict

from plant.joint import NonNegative, Positive, check_unique_step
from plant.step import JointParameters, scaled_joint


class FrictionChange(BaseModel):
    """A sudden change of friction.

    Parameters
    ----------
    time : float
        When it happens, s.
    friction_scale : float
        Factor on the joint's original ``Fc``, ``Fs`` and ``sigma`` from then on.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    time: NonNegative
    friction_scale: Positive


class JointSchedule(NamedTuple):
    """A joint whose friction changes in phases.

    Attributes
    ----------
    joint : JointParameters
        The joint before the first change.
    starts : ndarray of int64, shape (phases,)
        First solver step of each phase, ascending; the first is 0.
    scales : ndarray, shape (phases,)
        Factor on the joint's original friction in each phase; the first is 1.
    """

    joint: JointParameters
    starts: NDArray[np.int64]
    scales: NDArray[np.float64]


@register_jitable
def joint_in_phase(plan: JointSchedule, phase: int) -> JointParameters:
    """Return the joint as it is in a phase."""
    return scaled_joint(plan.joint, plan.scales[phase])


def schedule(joint: JointParameters, changes: Sequence[FrictionChange], solver_period: float) -> JointSchedule:
    """Lay the changes on the solver's grid.

    Parameters
    ----------
    joint : JointParameters
        The joint before the first change.
    changes : sequence of FrictionChange
        Changes in ascending order of time. One between two solver steps takes effect at the later of them.
    solver_period : float
        Solver period, s.

    Returns
    -------
    JointSchedule
        The phases of the joint.

    Raises
    ------
    ValueError
        The times do not ascend, or a change makes the implicit step ambiguous.
    """
    for earlier, later in pairwise(changes):
        if later.time <= earlier.time:
            raise ValueError(
                f"time = {later.time:g} s follows {earlier.time:g} s; the times of changes must ascend strictly"
            )
    starts = [0, *(math.ceil(change.time / solver_period - 1e-6) for change in changes)]
    scales = [1.0, *(change.friction_scale for change in changes)]
    plan = JointSchedule(joint, np.array(starts, dtype=np.int64), np.array(scales))
    for phase, scale in enumerate(scales):
        try:
            check_unique_step(joint_in_phase(plan, phase), solver_period)
        except ValueError as error:
            raise ValueError(f"friction_scale = {scale:g} is not allowed: {error}") from error
    return plan
