"""Friction that changes: suddenly at given times, with the warmth of the joint, and with its position.

All three are a factor on the joint's friction:

    factor(t, q) = jump(t) (1 + excess exp(-t/T)) (1 + amplitude sin(2 pi q / period))
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, Any, NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from plant.fields import NonNegative, Positive
from plant.kinds import CHECK_PERIOD, SCALE_JOINT


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


class FrictionVariation(BaseModel):
    """Friction that drifts as the joint warms up, and varies with its position.

    Parameters
    ----------
    warm_up_excess : float, optional
        Friction of the cold joint beyond that of the warm one, as a share of the latter; more than -1.
    warm_up_time : float, optional
        Time constant of warming up, s.
    position_amplitude : float, optional
        Amplitude of the variation with position, as a share of the friction; less than 1.
    position_period : float, optional
        Motion after which it repeats, rad.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    warm_up_excess: Annotated[float, Field(gt=-1.0, allow_inf_nan=False, strict=True)] = 0.0
    warm_up_time: Positive = 30.0
    position_amplitude: Annotated[float, Field(ge=0.0, lt=1.0, allow_inf_nan=False, strict=True)] = 0.0
    position_period: Positive = 1.0


class FrictionSchedule(NamedTuple):
    """How the friction of a joint changes.

    Attributes
    ----------
    starts : ndarray of int64, shape (phases,)
        First solver step of each phase, ascending; the first is 0.
    scales : ndarray, shape (phases,)
        Factor on the joint's friction in each phase; the first is 1.
    varies : bool
        Whether friction changes within a phase.
    excess : float
        Excess of the cold joint.
    warm_up_time : float
        Time constant of warming up, s.
    amplitude : float
        Amplitude of the variation with position.
    waves : float
        Its periods in a radian, times ``2 pi``.
    """

    starts: NDArray[np.int64]
    scales: NDArray[np.float64]
    varies: bool
    excess: float
    warm_up_time: float
    amplitude: float
    waves: float


@register_jitable
def friction_factor(plan: FrictionSchedule, phase: int, time: float, position: float) -> float:
    """Return the factor on the joint's friction in a phase, at a time (s) and a position (rad)."""
    factor: float = plan.scales[phase]
    if plan.varies:
        factor *= 1.0 + plan.excess * math.exp(-time / plan.warm_up_time)
        factor *= 1.0 + plan.amplitude * math.sin(plan.waves * position)
    return factor


def check_factor(joint: Any, plan: FrictionSchedule, solver_period: float) -> None:
    """Refuse changes of friction that make the implicit step of a joint ambiguous.

    Parameters
    ----------
    joint : NamedTuple
        Parameters of a joint of any kind.
    plan : FrictionSchedule
        How its friction changes.
    solver_period : float
        Solver period, s.

    Raises
    ------
    ValueError
        The largest factor on the friction does so.
    """
    factor = float(np.max(plan.scales)) * (1.0 + max(0.0, plan.excess)) * (1.0 + plan.amplitude)
    try:
        CHECK_PERIOD[type(joint)](SCALE_JOINT[type(joint)](joint, factor), solver_period)
    except ValueError as error:
        raise ValueError(f"friction up to {factor:g} times the joint's is not allowed: {error}") from error


def schedule(
    changes: Sequence[FrictionChange], solver_period: float, variation: FrictionVariation | None = None
) -> FrictionSchedule:
    """Lay the changes on the solver's grid.

    Parameters
    ----------
    changes : sequence of FrictionChange
        Changes in ascending order of time. One between two solver steps takes effect at the later of them.
    solver_period : float
        Solver period, s.
    variation : FrictionVariation, optional
        Drift and variation with position; none by default.

    Returns
    -------
    FrictionSchedule
        The phases and the variation.

    Raises
    ------
    ValueError
        The times do not ascend.
    """
    for earlier, later in pairwise(changes):
        if later.time <= earlier.time:
            raise ValueError(
                f"time = {later.time:g} s follows {earlier.time:g} s; the times of changes must ascend strictly"
            )
    slow = FrictionVariation() if variation is None else variation
    starts = [0, *(math.ceil(change.time / solver_period - 1e-6) for change in changes)]
    scales = [1.0, *(change.friction_scale for change in changes)]
    return FrictionSchedule(
        np.array(starts, dtype=np.int64),
        np.array(scales),
        slow.warm_up_excess != 0.0 or slow.position_amplitude != 0.0,
        slow.warm_up_excess,
        slow.warm_up_time,
        slow.position_amplitude,
        2.0 * math.pi / slow.position_period,
    )
