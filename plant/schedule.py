"""Joints that change: suddenly at given times, and their friction with warmth, position and load, too.

A sudden change may be of friction, inertia, friction lag and load. The changes of all friction are a factor:

    factor = jump(t) (1 + excess exp(-t/T)) (1 + amplitude sin(2 pi q / period)) (1 + c |load|) exp(-beta theta)

``load`` is what the gear transmits beside friction and inertia, gravity and the loads of changes. ``theta`` is by how
much the joint is warmer than its surroundings; friction itself heats it:

    T_h dtheta/dt = R f w - theta

with thermal resistance ``R`` and time constant ``T_h``. Lubricants thin out exponentially over such a range (O.
Reynolds, 1886). The power is taken as constant over a solver step: first order in its period, like the steps.
"""

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import Annotated, Any, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from plant.fields import Finite, NonNegative, Positive, Table, check_period
from plant.friction import UNCHANGED, JointChange
from plant.registry import CHANGE_JOINT, CHECK_PERIOD, SCALE_JOINT

LOAD = JointChange._fields.index("load")
"""Place of the load in a change."""


class FrictionChange(Table):
    """A sudden change of friction, inertia or load; the velocity does not jump.

    All factors are on the joint's original parameters, not on those before the change, and what is not given is as
    originally: a later change without ``load`` takes the load away.
    """

    time: NonNegative  # when it happens, s
    friction_scale: Positive = 1.0  # factor on ``Fc``, ``Fs`` and ``sigma`` from then on
    # further factors on ``Fc`` and ``Fs``, and on ``sigma``
    coulomb_scale: Positive = 1.0
    viscous_scale: Positive = 1.0
    # factor on the inertia, as when a payload is taken up; of an elastic joint on the link's
    inertia_scale: Positive = 1.0
    lag_scale: Positive = 1.0  # factor on the friction lag, for joints that have one
    load: Finite = 0.0  # constant torque against the motor's beside the joint's offset, N m, of either sign

    @model_validator(mode="after")
    def _check_content(self) -> Self:
        if self.model_fields_set <= {"time"}:
            others = ", ".join(name for name in type(self).model_fields if name != "time")
            raise ValueError(f"nothing changes at time = {self.time:g} s; give at least one of {others}")
        return self

    @property
    def parameters(self) -> JointChange:
        """The change as the kernels take it, without ``friction_scale``."""
        return JointChange(self.coulomb_scale, self.viscous_scale, self.inertia_scale, self.lag_scale, self.load)

    @property
    def text(self) -> str:
        """What changes, in a few words."""
        names = {"friction_scale": "friction", "coulomb_scale": "dry friction", "viscous_scale": "viscous friction"}
        names |= {"inertia_scale": "inertia", "lag_scale": "friction lag"}
        given = {name: getattr(self, name) for name in self.model_fields_set}
        parts = [f"{text} × {given[name]:.3g}" for name, text in names.items() if name in given]
        return ", ".join([*parts, *([f"load {self.load:.3g} N m"] if "load" in given else [])])


class FrictionVariation(Table):
    """Friction that drifts as the joint warms up, and varies with its position, its load and its own heat."""

    # friction of the cold joint beyond that of the warm one, as a fraction of the latter; more than -1
    warm_up_excess: Annotated[float, Field(gt=-1.0, allow_inf_nan=False, strict=True)] = 0.0
    warm_up_time: Positive = 30.0  # time constant of warming up, s
    # amplitude of the variation with position, as a fraction of the friction; less than 1
    position_amplitude: Annotated[float, Field(ge=0.0, lt=1.0, allow_inf_nan=False, strict=True)] = 0.0
    position_period: Positive = 1.0  # motion after which it repeats, rad
    # fraction by which friction rises for each N m of gravity and of the loads of changes, of either sign, 1/(N m)
    load_share: NonNegative = 0.0
    thermal_resistance: NonNegative = 0.0  # warmth that each watt of friction leads to, K/W
    thermal_time: Positive = 60.0  # time constant of heating and cooling, s
    thinning: NonNegative = 0.0  # relative fall of friction for each kelvin, 1/K


class FrictionSchedule(NamedTuple):
    """How the friction of a joint changes."""

    starts: NDArray[np.int64]  # first solver step of each phase, ascending; the first is 0
    scales: NDArray[np.float64]  # factor on all friction of the joint in each phase; the first is 1
    changes: NDArray[np.float64]  # what else differs in each phase, in the order of :class:`plant.friction.JointChange`
    varies: bool  # whether friction changes within a phase
    warm_up_excess: float  # excess of the cold joint
    warm_up_time: float  # time constant of warming up, s
    position_amplitude: float  # amplitude of the variation with position
    waves: float  # its periods in a radian, times ``2 pi``
    load_share: float  # fraction by which friction rises for each N m of load, 1/(N m)
    thermal_resistance: float  # thermal resistance, K/W
    thermal_time: float  # thermal time constant, s
    thinning: float  # relative fall of friction for each kelvin, 1/K


def phase_change(plan: FrictionSchedule, phase: int) -> JointChange:
    """Return what differs in a phase, without the factor on all friction."""
    row = plan.changes[phase]
    return JointChange(row[0], row[1], row[2], row[3], row[4])


def friction_factor(
    plan: FrictionSchedule, phase: int, time: float, position: float, weight: float = 0.0, warmth: float = 0.0
) -> float:
    """Return the factor on the joint's friction.

    Parameters
    ----------
    plan : FrictionSchedule
        How it changes.
    phase : int
        The phase.
    time : float
        Time, s.
    position : float
        Position, rad.
    weight : float, optional
        Torque of gravity, N m; the load of the phase is known.
    warmth : float, optional
        Temperature above that of the surroundings, K.
    """
    factor: float = plan.scales[phase]
    if plan.varies:
        factor *= 1.0 + plan.warm_up_excess * math.exp(-time / plan.warm_up_time)
        factor *= 1.0 + plan.position_amplitude * math.sin(plan.waves * position)
        factor *= 1.0 + plan.load_share * abs(weight + plan.changes[phase, LOAD])
        factor *= math.exp(-plan.thinning * warmth)
    return factor


def heated(plan: FrictionSchedule, warmth: float, power: float, duration: float) -> float:
    """Return the temperature (K, above the surroundings) after a constant power (W) of friction for a time (s)."""
    settled = plan.thermal_resistance * power
    return settled + (warmth - settled) * math.exp(-duration / plan.thermal_time)


def check_factor(joint: Any, plan: FrictionSchedule, solver_period: float, weight: float = 0.0) -> None:
    """Refuse changes that make the implicit step of a joint ambiguous.

    Parameters
    ----------
    joint : NamedTuple
        Parameters of a joint of any kind.
    plan : FrictionSchedule
        How its friction changes.
    solver_period : float
        Solver period, s.
    weight : float, optional
        Largest torque of gravity, N m.

    Raises
    ------
    ValueError
        They do so in one of the phases.
    """
    kind, slow = type(joint), (1.0 + max(0.0, plan.warm_up_excess)) * (1.0 + plan.position_amplitude)
    for phase, scale in enumerate(plan.scales.tolist()):
        change = JointChange(*plan.changes[phase].tolist())
        factor = scale * slow * (1.0 + plan.load_share * (weight + abs(change.load)))
        changed = CHANGE_JOINT[kind](joint, change)
        try:
            CHECK_PERIOD[kind](SCALE_JOINT[kind](changed, factor), solver_period)
        except ValueError as error:
            others = [f"{name} {value:g} times" for name, value in change._asdict().items() if value != 1.0]
            also = f" ({', '.join(others[:-1])})" if len(others) > 1 else ""
            raise ValueError(f"friction up to {factor:g} times the joint's{also} is not allowed: {error}") from error


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
        The times do not ascend, or the solver period is not positive.
    TypeError
        A change or the variation is of another class.
    """
    if not isinstance(changes, Sequence) or not all(isinstance(change, FrictionChange) for change in changes):
        raise TypeError(f"changes = {changes!r} is not allowed: it must be a sequence of FrictionChange")
    if not isinstance(variation, FrictionVariation | None):
        raise TypeError(f"variation = {variation!r} is not allowed: it must be a FrictionVariation")
    check_period("solver_period", solver_period)
    for earlier, later in pairwise(changes):
        if later.time <= earlier.time:
            raise ValueError(
                f"time = {later.time:g} s follows {earlier.time:g} s; the times of changes must ascend strictly"
            )
    slow = FrictionVariation() if variation is None else variation
    heats = slow.thermal_resistance > 0.0 and slow.thinning > 0.0
    starts = [0, *(math.ceil(change.time / solver_period - 1e-6) for change in changes)]
    scales = [1.0, *(change.friction_scale for change in changes)]
    return FrictionSchedule(
        starts=np.array(starts, dtype=np.int64),
        scales=np.array(scales),
        changes=np.array([UNCHANGED, *(change.parameters for change in changes)], dtype=float),
        varies=slow.warm_up_excess != 0.0 or slow.position_amplitude != 0.0 or slow.load_share > 0.0 or heats,
        waves=2.0 * math.pi / slow.position_period,
        **slow.model_dump(exclude={"position_period"}),
    )
