"""The scenario of an identified joint: a file that ``adaptive-ff compare`` takes, with what is assumed as comments."""

import math
from contextlib import suppress
from typing import Any

import numpy as np

from adaptive_ff.errors import InputError
from adaptive_ff.friction.model import TorqueModel
from adaptive_ff.identify.columns import GRAVITY
from adaptive_ff.identify.first_estimate import torque_model
from adaptive_ff.identify.motion import Array
from adaptive_ff.identify.result import ASYMMETRY, IdentifiedJoint
from adaptive_ff.scenario.content import MAIN_JOB
from adaptive_ff.scenario.file import toml_text
from plant.lugre import LuGreJoint

BANDWIDTH, PERIODS = 10.0, 0.1
"""Crossover of the assumed PI loop, Hz, and the most that it may be times the sampling period."""

SOLVER_STEP, SOLVER_TIMES = 0.001, (1, 2, 4, 8, 16)
"""Longest solver period, s, and over how many times as many steps a joint on bristles is solved."""

MOST_VARIED = 0.9
"""Largest variation of the simulated friction over position, as a fraction."""

SEAM = 1e-3
"""Difference of the velocities at both ends of the motion from which on they are joined, over the largest speed."""

NOT_SIMULATED = ("torque_delay", "load_friction")
"""Terms that the simulated joint has not, beside those over position."""


def reference_columns(found: IdentifiedJoint) -> dict[str, Array]:
    """Return the motion of the longest segment as the columns of a recorded reference."""
    rows = found.motion
    every = max(1, int(0.1 / (found.bandwidth * rows.period)))
    return joined_ends(rows.time[::every] - rows.time[0], rows.in_band(rows.velocity)[::every])


def joined_ends(time: Array, velocity: Array) -> dict[str, Array]:
    """Return a motion that a simulation can repeat without a jump.

    Half a cosine leads from the velocity at its end to that at its start, no steeper than the motion itself.
    """
    apart = float(velocity[0] - velocity[-1])
    steepest = float(np.max(np.abs(np.diff(velocity) / np.diff(time))))
    if abs(apart) > SEAM * float(np.max(np.abs(velocity))):
        step = float(time[1] - time[0])
        count = max(2, math.ceil(0.5 * math.pi * abs(apart) / (steepest * step)))
        fraction = np.arange(1, count + 1) / count
        time = np.concatenate([time, time[-1] + step * count * fraction])
        velocity = np.concatenate([velocity, velocity[-1] + 0.5 * apart * (1.0 - np.cos(math.pi * fraction))])
    return {"time": time, "velocity": velocity}


def left_out(found: IdentifiedJoint) -> list[str]:
    """Return the names of what the best model has and the simulated joint has not."""
    values = found.best.values
    names = [name for name in values if name in NOT_SIMULATED or name.startswith(("force_hat", "friction_hat"))]
    return names + (["dip at low speed"] if values.get("stiction_excess", 0.0) < 0.0 else [])


def scenario_text(found: IdentifiedJoint, reference: str) -> str:
    """Return the scenario of an identified joint.

    Parameters
    ----------
    found : IdentifiedJoint
        The joint.
    reference : str
        Name of the file with the recorded reference, beside the scenario file.

    Raises
    ------
    InputError
        Inertia or friction is not identifiable: there is no joint to simulate.
    """
    for name in ("inertia", "coulomb"):
        if name in found.unidentified or (name == "inertia" and found.value(name) <= 0.0):
            raise InputError(f"{found.name}: the {name} is not identifiable, so there is no scenario")
    period = float(f"{found.period:.4g}")
    joint = joint_fields(found, period)
    content = {
        "controllers": list(MAIN_JOB),
        "joint": joint,
        "sampling": {"period": period},
        "sensor": {"velocity_noise": _rounded(found.motion.noise)},
        "reference": {"kind": "csv", "path": reference},
        "feedback": {"inertia": joint["inertia"], "bandwidth": _rounded(min(BANDWIDTH, PERIODS / period))},
        "adaptation": {
            "stribeck_velocity": joint["stribeck_velocity"],
            "memory": 5.0,
            **_learnt(found, joint),
            **_mapped(found),
        },
        **_over_position(found),
        "fixed": {**{name: joint[name] for name in ("inertia", "coulomb")}, "viscous": _rounded(_model(found).viscous)},
    }
    return toml_text(content, _comments(found, joint), _head(found))


def joint_fields(found: IdentifiedJoint, period: float) -> dict[str, Any]:
    """Return the fields of a scenario's joint; the sampling period in s."""
    model = _model(found)
    substeps = max(1, math.ceil(period / SOLVER_STEP - 1e-9))
    joint: dict[str, Any] = {"axis": "linear"} if found.linear else {}
    joint |= {name: _rounded(getattr(model, name)) for name in ("inertia", "coulomb", "stiction", "viscous")}
    joint |= {name: _rounded(getattr(model, name)) for name in ("stribeck_velocity", "stribeck_shape")}
    joint["offset"] = _rounded(model.offset)
    if model.viscous_asymmetry:
        joint["viscous"] = _rounded(max(0.0, model.viscous + model.viscous_asymmetry))
        joint["viscous_backward"] = _rounded(max(0.0, model.viscous - model.viscous_asymmetry))
    amplitude, phase = found.gravity
    if amplitude > 0.0:
        phase += float(found.motion.position[0])  # the simulated position is zero at the start
        joint |= {"gravity": _rounded(amplitude), "gravity_phase": _rounded(phase)}
    rest = {"friction_lag": _rounded(found.value("friction_lag")), "solver_period": _rounded(period / substeps)}
    return joint | (_on_bristles(found, joint, period / substeps) or rest)


def _model(found: IdentifiedJoint) -> TorqueModel:
    return torque_model(found, None if found.units["torque"] != "A" else 1.0)


def _learnt(found: IdentifiedJoint, joint: dict[str, Any]) -> dict[str, str]:
    """Return what a controller is to learn: gravity where the joint has some, and never on a linear axis."""
    if found.linear:
        return {"identify": "directions" if found.value(ASYMMETRY) else "offset"}
    return {"identify": "gravity"} if "gravity" in joint else {}


def _on_bristles(found: IdentifiedJoint, joint: dict[str, Any], step: float) -> dict[str, Any] | None:
    """Return bristles of the LuGre model for a joint whose friction follows a path; None for another one."""
    if not (found.value("path") > 0.0 and joint["coulomb"] > 0.0):
        return None
    bristles = {"kind": "lugre", "stiffness": _rounded(joint["coulomb"] / found.value("path")), "damping": 0.0}
    for finer in SOLVER_TIMES:
        made = bristles | {"solver_period": _rounded(step / finer)}
        with suppress(ValueError):
            LuGreJoint(**{**joint, **made})
            return made
    return None


def _waves(found: IdentifiedJoint, kind: str) -> list[tuple[float, float]]:
    """Return amplitude, N m, and period, rad, of each wave of friction or force over position."""
    pairs = []
    for number, period in enumerate(found.place.periods, start=1):
        size = math.hypot(*(found.value(f"{kind}_{part}_{number}") for part in ("sine", "cosine")))
        if size > 0.0:
            pairs.append((size, period))
    return pairs


def _over_position(found: IdentifiedJoint) -> dict[str, Any]:
    """Return friction and drive of the simulated joint over position: the strongest wave of each."""
    made: dict[str, Any] = {}
    friction, force, coulomb = _waves(found, "friction"), _waves(found, "force"), found.value("coulomb")
    if friction and coulomb > 0.0:
        size, period = max(friction)
        fraction = min(size / coulomb, MOST_VARIED)
        made["variation"] = {"position_amplitude": _rounded(fraction), "position_period": _rounded(period)}
    if force:
        size, period = max(force)
        made["actuator"] = {"ripple_amplitude": _rounded(size), "ripple_period": _rounded(period)}
    return made


def _mapped(found: IdentifiedJoint) -> dict[str, Any]:
    """Return what the controller is to learn of friction and force over position."""
    made: dict[str, Any] = {}
    if _waves(found, "force"):
        made["ripple_periods"] = [_rounded(period) for _, period in _waves(found, "force")]
    if _waves(found, "friction"):
        made["position_periods"] = [_rounded(period) for _, period in _waves(found, "friction")]
    if any(name.startswith("friction_hat") for name in found.best.values):
        made["position_hats"] = found.place.hats
        start = float(found.motion.position[0])
        made["position_range"] = [_rounded(end - start) for end in (found.place.low, found.place.high)]
    return made


def _head(found: IdentifiedJoint) -> list[str]:
    """Return the comments above the scenario."""
    lines = [
        f"Joint identified from {found.source} in a band of {found.bandwidth:.3g} Hz: "
        f"{found.grade}, {100.0 * found.best.left:.2g} % of the torque left."
    ]
    left = left_out(found)
    if left:
        lines.append(f"The log shows as well, and the simulated joint has not: {', '.join(left)}.")
    if found.units["torque"] == "A":
        lines.append("The torque of the log is a current: read A where units say N m (N), or give a torque constant.")
    return lines


def _comments(found: IdentifiedJoint, joint: dict[str, Any]) -> dict[str, str]:
    """Return how well each value is known, or that it is assumed, by its key."""
    bend = _interval(found, "stribeck_velocity")
    mean = "mean of both directions: " if ASYMMETRY in found.best.values else ""
    gravity = "from " + " and ".join(f"{name} {found.value(name):.4g}" for name in GRAVITY if name in found.best.values)
    said = {
        **{f"joint.{name}": _interval(found, name) for name in ("inertia", "coulomb", "offset")},
        "joint.viscous": mean + _interval(found, "viscous"),
        "joint.friction_lag": _interval(found, "friction_lag"),
        "joint.viscous_backward": "half of what both directions differ by: " + _interval(found, ASYMMETRY),
        "joint.stiffness": f"coulomb over a path of {found.value('path'):.4g}, {_interval(found, 'path')}",
        "joint.stiction": _interval(found, "stiction_excess") + " of what is above coulomb",
        "joint.stribeck_velocity": bend,
        "joint.gravity": gravity,
        "joint.gravity_phase": "at the start of the motion",
    }
    return {
        **{key: text for key, text in said.items() if key.removeprefix("joint.") in joint},
        "sampling.period": "as recorded",
        "sensor.velocity_noise": "of the log's motion",
        "reference.path": "the motion of the log in its band, its end led to its start, so that it repeats",
        "feedback.inertia": "assumed: the designer knows it",
        "feedback.bandwidth": "assumed; the machine's own loop is not known",
        "adaptation.stribeck_velocity": bend,
        "adaptation.memory": "assumed",
        "fixed": "the identified Coulomb and viscous friction",
    }


def _interval(found: IdentifiedJoint, name: str) -> str:
    """Say how well a parameter is known."""
    one = found.joint_parameters.get(name)
    if one is None:
        return "assumed: the log shows none"
    return f"{100.0 * found.confidence:g} % interval {one.lower:.4g} to {one.upper:.4g}"


def _rounded(value: float) -> float:
    """Return a value with the digits that a person reads."""
    return float(f"{value:.6g}")
