"""The scenario of an identified joint: a file that ``adaptive-ff compare`` takes, with what is assumed as comments."""

import math
from collections import defaultdict
from contextlib import suppress
from typing import Any

import numpy as np

from adaptive_ff.errors import InputError
from adaptive_ff.friction.model import TorqueModel
from adaptive_ff.identify.columns import ASYMMETRY
from adaptive_ff.identify.motion import Array
from adaptive_ff.identify.result import LogIdentification
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

SAME = ("inertia", "coulomb", "stiction", "viscous", "stribeck_velocity", "stribeck_shape", "offset")
"""Fields of a torque model that the joint of a scenario has by the same name."""

NOT_SIMULATED = ("torque_delay", "load_friction")
"""Terms that the simulated joint has not, beside those over position."""


def reference_columns(found: LogIdentification) -> dict[str, Array]:
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


def left_out(found: LogIdentification) -> list[str]:
    """Return the names of what the best model has and the simulated joint has not."""
    values = found.best.values
    names = [name for name in values if name in NOT_SIMULATED or name.startswith(("force_hat", "friction_hat"))]
    return names + (["dip at low speed"] if values.get("stiction_excess", 0.0) < 0.0 else [])


def scenario_text(found: LogIdentification, reference: str) -> str:
    """Return the scenario of an identified joint.

    Parameters
    ----------
    found : LogIdentification
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
    model = found.torque_model(1.0 if found.units["torque"] == "A" else None)
    joint = _joint(found, model, period)
    learnt, simulated = _over_position(found)
    adaptation: dict[str, Any] = {"stribeck_velocity": joint["stribeck_velocity"], "memory": 5.0}
    if found.linear:
        adaptation["identify"] = "directions" if found.value(ASYMMETRY) else "offset"
    elif "gravity" in joint:
        adaptation["identify"] = "gravity"
    content = {
        "controllers": list(MAIN_JOB),
        "joint": joint,
        "sampling": {"period": period},
        "sensor": {"velocity_noise": found.motion.noise},
        "reference": {"kind": "csv", "path": reference},
        "feedback": {"inertia": joint["inertia"], "bandwidth": min(BANDWIDTH, PERIODS / period)},
        "adaptation": adaptation | learnt,
        **simulated,
        "fixed": {"inertia": joint["inertia"], "coulomb": joint["coulomb"], "viscous": model.viscous},
    }
    return toml_text(_rounded(content), _comments(found, joint), _head(found))


def _joint(found: LogIdentification, model: TorqueModel, period: float) -> dict[str, Any]:
    """Return the fields of a scenario's joint; the sampling period in s."""
    joint: dict[str, Any] = {"axis": "linear"} if found.linear else {}
    joint |= {name: getattr(model, name) for name in SAME}
    if model.viscous_asymmetry:
        joint["viscous"] = max(0.0, model.viscous + model.viscous_asymmetry)
        joint["viscous_backward"] = max(0.0, model.viscous - model.viscous_asymmetry)
    amplitude, phase = found.gravity
    if amplitude > 0.0:  # the simulated position is zero at the start
        joint |= {"gravity": amplitude, "gravity_phase": phase + float(found.motion.position[0])}
    step = period / max(1, math.ceil(period / SOLVER_STEP - 1e-9))
    if model.presliding > 0.0 and model.coulomb > 0.0:  # bristles of the LuGre model
        bristles = {"kind": "lugre", "stiffness": model.coulomb / model.presliding, "damping": 0.0}
        for finer in SOLVER_TIMES:
            made: dict[str, Any] = _rounded(joint | bristles | {"solver_period": step / finer})
            with suppress(ValueError):
                LuGreJoint(**made)
                return made
    joint |= {"friction_lag": found.value("friction_lag"), "solver_period": step}
    return {name: _rounded(value) for name, value in joint.items()}


def _over_position(found: LogIdentification) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return what the controller is to learn over position, and the strongest wave of each kind, which is simulated."""
    waves: dict[str, list[tuple[float, float]]] = {"friction": [], "force": []}
    for kind, pairs in waves.items():
        for number, period in enumerate(found.place.periods, start=1):
            size = math.hypot(*(found.value(f"{kind}_{part}_{number}") for part in ("sine", "cosine")))
            pairs.extend([(size, period)] if size > 0.0 else [])
    learnt: dict[str, Any] = {
        key: [period for _, period in waves[kind]]
        for key, kind in (("ripple_periods", "force"), ("position_periods", "friction"))
        if waves[kind]
    }
    if any(name.startswith("friction_hat") for name in found.best.values):
        start = float(found.motion.position[0])
        learnt |= {"position_hats": found.place.hats}
        learnt |= {"position_range": [end - start for end in (found.place.low, found.place.high)]}
    simulated: dict[str, Any] = {}
    if waves["friction"] and found.value("coulomb") > 0.0:
        size, period = max(waves["friction"])
        fraction = min(size / found.value("coulomb"), MOST_VARIED)
        simulated["variation"] = {"position_amplitude": fraction, "position_period": period}
    if found.gravity[0] > 0.0 and found.best.model.shape.load and found.value("coulomb") > 0.0:
        share = max(0.0, found.value("load_friction")) / found.value("coulomb")
        simulated.setdefault("variation", {})["load_share"] = share
    if waves["force"]:
        size, period = max(waves["force"])
        simulated["actuator"] = {"ripple_amplitude": size, "ripple_period": period}
    return learnt, simulated


def _head(found: LogIdentification) -> list[str]:
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


SAYS = {
    "inertia": "{inertia}",
    "coulomb": "{coulomb}",
    "stiction": "{stiction_excess} of what is above coulomb",
    "viscous": "{viscous}",
    "viscous_backward": "half of what both directions differ by: {viscous_asymmetry}",
    "stribeck_velocity": "{stribeck_velocity}",
    "offset": "{offset}",
    "friction_lag": "{friction_lag}",
    "stiffness": "coulomb over a path, {path}",
    "gravity": "sine {gravity_sine}, cosine {gravity_cosine}",
    "gravity_phase": "at the start of the motion",
}
"""How well each field of the joint is known; names in braces stand for the intervals of parameters."""

SAID = {
    "sampling.period": "as recorded",
    "sensor.velocity_noise": "of the log's motion",
    "reference.path": "the motion of the log in its band, its end led to its start, so that it repeats",
    "feedback.inertia": "assumed: the designer knows it",
    "feedback.bandwidth": "assumed; the machine's own loop is not known",
    "adaptation.memory": "assumed",
    "fixed": "the identified Coulomb and viscous friction",
}
"""Where the other fields are from."""


def _comments(found: LogIdentification, joint: dict[str, Any]) -> dict[str, str]:
    """Return how well each value is known, or that it is assumed, by its key."""
    intervals = defaultdict(lambda: "assumed: the log shows none")
    for name, one in found.joint_parameters.items():
        intervals[name] = f"{100.0 * found.confidence:g} % interval {one.lower:.4g} to {one.upper:.4g}"
    said = {f"joint.{name}": text.format_map(intervals) for name, text in SAYS.items() if name in joint}
    if "viscous_backward" in joint:
        said["joint.viscous"] = f"mean of both directions: {intervals['viscous']}"
    return said | SAID | {"adaptation.stribeck_velocity": said["joint.stribeck_velocity"]}


def _rounded(content: Any) -> Any:
    """Return numbers, of tables and lists as well, with the digits that a person reads."""
    if isinstance(content, dict):
        return {name: _rounded(value) for name, value in content.items()}
    if isinstance(content, list):
        return [_rounded(value) for value in content]
    return float(f"{content:.6g}") if isinstance(content, float) else content
