"""Open loop: the identified model, simulated on another log from its torque alone.

It is the protocol of the EMPS benchmark (A. Janot, M. Gautier, M. Brunot, 2019): identified on one record, the model
simulates the position of the other, and the root mean square of the error counts. What the simulated joint lacks of the
identified model is said; nothing is fitted anew.
"""

import math
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple

import numpy as np

from adaptive_ff.errors import InputError
from adaptive_ff.identify.columns import ASYMMETRY, is_mapped
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.identify.motion import Array, cut_edges, derivative, lowpass
from adaptive_ff.identify.preparation import prepare
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.logs.log import Log, check_log
from adaptive_ff.reported import Reported
from controllers import compiled
from plant.friction import Stribeck
from plant.joint import Gravity, gravity_torque
from plant.step import JointParameters, JointState, friction_at, step_joint

WINDOW = 1.0
"""Length of a window, s."""

STEP = 1e-3
"""Longest step of the simulation, s."""

FOLLOWS, DRIFTS = 0.1, 0.5
"""Error in the windows over the motion in them, up to which the model follows, and up to which it drifts only."""


class Beside(NamedTuple):
    """What the torque of a joint holds beside inertia, Coulomb and viscous friction, offset and lag."""

    weight: Gravity
    load_friction: float  # by how much friction rises with that torque and the one that accelerates the joint
    excess: float  # what friction is more, or less, at standstill than at speed, N m
    stribeck_velocity: float  # rad/s
    asymmetry: float  # half of what viscous friction differs by between both directions, N m s/rad


@compiled
def _follow(
    joint: JointParameters, beside: Beside, torque: Array, start: Array, period: float, length: int, position: Array
) -> None:
    """Simulate the joint from the measured state at the start of each segment of a length."""
    state, before = JointState(0.0, 0.0, 0.0), 0.0
    for k in range(torque.size):
        if k % length == 0:
            state = JointState(start[1, k], friction_at(joint.friction, joint.backward, start[1, k]), start[0, k])
            before = state.velocity
        position[k] = state.position
        pull, speed = gravity_torque(beside.weight, state.position), abs(state.velocity)
        more = beside.load_friction * abs(pull + joint.inertia * (state.velocity - before) / period)
        if beside.excess != 0.0:
            more += beside.excess * math.exp(-speed / beside.stribeck_velocity)
        dry, before = max(0.0, joint.friction.coulomb + more), state.velocity
        curve = Stribeck(dry, dry, joint.friction.viscous, joint.friction.stribeck_velocity, 1.0)
        now = JointParameters(joint.inertia, curve, curve, joint.offset, joint.friction_lag)
        state = step_joint(now, state, torque[k] - pull - beside.asymmetry * speed, period)


@dataclass(frozen=True, eq=False)
class Score(Reported):
    """What the identified model makes of another log in open loop; positions in rad, or m.

    Attributes
    ----------
    found : LogIdentification
        The model.
    tested : str
        Name of the other log.
    rms, fit : float
        Error of the simulation of the longest segment, rms, and how much of its variation is explained, per cent.
    windows, moved : float
        Error and motion in windows of 1 s, each begun from the measured state, rms.
    training_rms, training_windows : float
        The same errors on the log that was identified.
    torque_left : float
        What the model leaves of the other log's torque in its band, rms over the torque's about its mean.
    time, measured, simulated : ndarray, shape (n,)
        The longest segment of the other log.
    cautions : list of str
        What was done to the logs, or is probably wrong with them.
    """

    _drawn_by = "plot_score"

    found: LogIdentification
    tested: str
    rms: float
    fit: float
    windows: float
    moved: float
    training_rms: float
    training_windows: float
    torque_left: float
    time: Array
    measured: Array
    simulated: Array
    cautions: list[str] = field(default_factory=list)

    @property
    def grade(self) -> str:
        """How far the model can be simulated: ``follows``, ``drifts`` or ``does not follow``."""
        fraction = self.windows / self.moved if self.moved else math.inf
        return "follows" if fraction <= FOLLOWS else "drifts" if fraction <= DRIFTS else "does not follow"

    def to_dict(self) -> dict[str, Any]:
        """Return everything but the series as plain values."""
        apart = ("found", "time", "measured", "simulated", "cautions")
        result: dict[str, Any] = {"trained": self.found.name}
        result |= {one.name: getattr(self, one.name) for one in fields(self) if one.name not in apart}
        result |= {"verdict": self.grade, "unit": "m" if self.found.linear else "rad", "warnings": self.cautions}
        return result | {"model": self.found.best.values, "identification": self.found.to_dict()}


def score_log(train: Log, test: Log, **given: Any) -> Score:
    """Identify a log, and simulate another one with the model in open loop.

    Parameters
    ----------
    train, test : Log
        Logs of the same joint, with positions.
    **given
        As :func:`identify_log` takes it.

    Raises
    ------
    InputError
        A log has no position, or does not determine a joint, or an argument is out of range.
    """
    check_log("train", train)
    check_log("test", test)
    for log in (train, test):
        if log.position is None:
            raise InputError(f"{log.name}: a score takes a log with positions, not velocities")
    same = train.is_same_record(test)
    found = identify_log(train, **{**given, "validation": None if same else test})
    found.check_joint("model to simulate", ("inertia",))
    delay = given.get("torque_delay")
    training = _simulated(found, train, delay)
    other = training if same else _simulated(found, test, delay)
    deviation = float(np.std(other["measured"]))
    said = [*found.cautions, *other.pop("cautions")]
    lacking = ("path",) if found.best.model.shape.load else ("path", "load_friction")
    lacks = [one for one in found.best.values if is_mapped(one) or one in lacking]
    if lacks:
        said.append(f"{train.name}: the model has as well, and the simulated joint lacks: {', '.join(lacks)}")
    if same:
        said.append(
            f"{test.name}: is the log that the model is identified on; its error says nothing about other motion"
        )
    return Score(
        found,
        test.name,
        **other,
        fit=100.0 * (1.0 - other["rms"] / deviation) if deviation else -math.inf,
        training_rms=training["rms"],
        training_windows=training["windows"],
        torque_left=found.best.left if found.validation is None else found.validation,
        cautions=said,
    )


def _simulated(found: LogIdentification, log: Log, delay: float | None) -> dict[str, Any]:
    """Return what a :class:`Score` says of the simulation of a log, by the name of its field.

    It begins and ends a cycle of the band away from the ends of the log, where the filter does not know the velocity.
    """
    prepared = prepare(log, torque_delay=delay, linear=found.linear)
    segment = max(prepared.segments, key=lambda one: one.position.size)
    fine = max(1, math.ceil(segment.period / STEP - 1e-9))
    smooth = derivative(lowpass(prepared.band, segment.period)(segment.position), segment.period)
    inner = cut_edges(segment.position.size, prepared.band * segment.period)
    position, step = segment.position[inner], segment.period / fine
    count = position.size
    time = segment.period * np.arange(count)
    grid = step * np.arange((count - 1) * fine + 1)
    late = found.value("torque_delay")
    torque = np.interp(grid - late, time, segment.torque[inner])
    start = np.vstack([np.interp(grid, time, one) for one in (position, smooth[inner])])
    names = ("coulomb", "viscous", "stribeck_velocity")
    coulomb, viscous, slow = (max(0.0, found.value(name)) for name in names)
    slow = slow or 1.0  # of no excess
    curve = Stribeck(coulomb, coulomb, viscous, slow, 1.0)
    joint = JointParameters(found.value("inertia"), curve, curve, found.value("offset"), found.value("friction_lag"))
    carried = max(0.0, found.value("load_friction")) if found.best.model.shape.load else 0.0
    beside = Beside(Gravity(*found.gravity), carried, found.value("stiction_excess"), slow, found.value(ASYMMETRY))
    results = []
    rows = max(1, round(WINDOW / segment.period))  # of a window
    for length in (grid.size, fine * rows):
        simulated = np.empty(grid.size)
        _follow(joint, beside, torque, start, step, length, simulated)
        results.append(simulated[::fine])
    whole, windows = (np.where(np.isfinite(one), one, 1e300) for one in results)
    begun = position[np.arange(count) // rows * rows]
    with np.errstate(over="ignore"):
        errors = [math.sqrt(float(np.mean(one**2))) for one in (whole - position, windows - position, position - begun)]
    number = len(prepared.segments)
    said = [f"{log.name}: the longest of {number} segments is simulated, {time[-1]:.4g} s"] if number > 1 else []
    first = segment.start + segment.period * inner.start
    series = {"time": first + time, "measured": position, "simulated": whole, "cautions": said}
    return {**series, "rms": errors[0], "windows": errors[1], "moved": errors[2]}
