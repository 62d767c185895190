"""The scenario of an identified joint: a file that ``adaptive-ff compare`` takes, with what is assumed as comments."""

import math
from contextlib import suppress
from itertools import starmap
from typing import Any

import numpy as np

from adaptive_ff.files import template
from adaptive_ff.friction.model import TorqueModel
from adaptive_ff.identify.columns import ASYMMETRY
from adaptive_ff.identify.motion import TUNING, Array
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.scenario.content import MAIN_JOB
from adaptive_ff.scenario.file import toml_value, with_comment
from plant.lugre import LuGreJoint

BANDWIDTH, PERIODS = 10.0, 0.1
"""Crossover of the assumed PI loop, Hz, and the most that it may be times the sampling period."""

SOLVER_STEP, SOLVER_TIMES = 0.001, (1, 2, 4, 8, 16)
"""Longest solver period, s, and over how many times as many steps a joint on bristles is solved."""

SEAM = 1e-3
"""Difference of the velocities at both ends of the motion from which on they are joined, over the largest speed."""

SAME = ("inertia", "coulomb", "stiction", "viscous", "stribeck_velocity", "stribeck_shape", "offset")
"""Fields of a torque model that the joint of a scenario has by the same name."""


def reference_columns(found: LogIdentification) -> dict[str, Array]:
    """Return the motion of the longest segment as the columns of a recorded reference."""
    rows = found.data.longest
    every = max(1, int(0.1 / (found.data.band * rows.period)))
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
    loaded = "load_share" in _beside_friction(found)[1].get("variation", {})
    lacks = ("torque_delay", "force_hat", "friction_hat", *(() if loaded else ("load_friction",)))
    names = [name for name in found.best.values if name.startswith(lacks)]
    names += ["dip at low speed"] if found.value("stiction_excess") < 0.0 else []
    return names + (["viscous friction below zero"] if abs(found.value(ASYMMETRY)) > found.value("viscous") else [])


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
    found.check_joint("scenario")
    period = float(f"{found.data.period:.4g}")
    model = found.torque_model(1.0 if found.units["torque"] == "A" else None)
    joint = _joint(found, model, period)
    learnt, simulated = _beside_friction(found)
    intervals = {
        name: f"{100.0 * found.confidence:g} % interval {one.lower:.4g} to {one.upper:.4g}"
        for name, one in found.joint_parameters.items()
    }
    return template("adaptive_ff.identify", "scenario.toml").render(
        found=found,
        field=lambda name, value, said="": with_comment(f"{name} = {toml_value(_rounded(value))}", said),
        interval=lambda name: intervals.get(name, "assumed: the log shows none"),
        controllers=list(MAIN_JOB),
        joint=joint,
        period=period,
        reference=reference,
        bandwidth=min(BANDWIDTH, PERIODS / period),
        learnt=learnt,
        simulated=simulated,
        viscous=model.viscous,
        left_out=left_out(found),
    )


def _joint(found: LogIdentification, model: TorqueModel, period: float) -> dict[str, Any]:
    """Return the fields of a scenario's joint; the sampling period in s."""
    joint: dict[str, Any] = {"axis": "linear"} if found.linear else {}
    joint |= {name: getattr(model, name) for name in SAME}
    if model.viscous_asymmetry:
        joint["viscous"] = max(0.0, model.viscous + model.viscous_asymmetry)
        joint["viscous_backward"] = max(0.0, model.viscous - model.viscous_asymmetry)
    amplitude, phase = found.gravity
    if amplitude > 0.0:  # the simulated position is zero at the start
        joint |= {"gravity": amplitude, "gravity_phase": phase + float(found.data.longest.position[0])}
    step = period / max(1, math.ceil(period / SOLVER_STEP - 1e-9))
    if model.presliding > 0.0 and model.coulomb > 0.0:  # bristles of the LuGre model
        bristles = {"kind": "lugre", "stiffness": model.coulomb / model.presliding, "damping": 0.0}
        for finer in SOLVER_TIMES:
            made = {**joint, **bristles, "solver_period": step / finer}
            with suppress(ValueError):
                LuGreJoint(**{name: _rounded(value) for name, value in made.items()})
                return made
    return {**joint, "friction_lag": found.value("friction_lag"), "solver_period": step}


def _beside_friction(found: LogIdentification) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return what the controller is to learn beside friction, and the strongest waves over position, as simulated."""
    place, learnt, strongest = found.data.place, dict[str, Any](), {}
    if found.linear:
        learnt["identify"] = "directions" if found.value(ASYMMETRY) else "offset"
    elif found.gravity[0] > 0.0:
        learnt["identify"] = "gravity"
    for kind, key in (("force", "ripple_periods"), ("friction", "position_periods")):
        numbers = range(1, len(place.periods) + 1)
        waves = (tuple(found.value(f"{kind}_{part}_{number}") for part in ("sine", "cosine")) for number in numbers)
        strongest[kind] = max(zip(starmap(math.hypot, waves), place.periods, strict=True), default=(0.0, 0.0))
        if strongest[kind][0] > 0.0:
            learnt[key] = list(place.periods)
    if any(name.startswith("friction_hat") for name in found.best.values):
        start = float(found.data.longest.position[0])
        learnt |= {"position_hats": place.hats, "position_range": [place.low - start, place.high - start]}
    variation, coulomb = dict[str, float](), found.value("coulomb")
    size, period = strongest["friction"]
    if size > 0.0 and coulomb > 0.0:
        variation |= {"position_amplitude": min(size / coulomb, TUNING.most_variation), "position_period": period}
    if found.gravity[0] > 0.0 and found.best.model.shape.load and coulomb > 0.0:
        variation["load_share"] = max(0.0, found.value("load_friction")) / coulomb
    simulated: dict[str, Any] = {"variation": variation} if variation else {}
    size, period = strongest["force"]
    if size > 0.0:
        simulated["actuator"] = {"ripple_amplitude": size, "ripple_period": period}
    return learnt, simulated


def _rounded(value: Any) -> Any:
    """Return a number, or those of a list, with the digits that a person reads."""
    if isinstance(value, list):
        return [_rounded(one) for one in value]
    return float(f"{value:.6g}") if isinstance(value, float) else value
