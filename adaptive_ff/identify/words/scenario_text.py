"""The scenario of an identified joint: a file that ``adaptive-ff compare`` takes, with what is assumed as comments."""

import math
from contextlib import suppress
from typing import Any

import numpy as np

from adaptive_ff.errors import InputError
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.identify.stiction import Stiction, known_stiction
from adaptive_ff.identify.terms import DAMPING, PATH, SATURATIONS
from adaptive_ff.identify.units import LINEAR, ROTARY, is_linear, is_of_current
from adaptive_ff.identify.words.unattributed import unattributed
from adaptive_ff.logs.derivatives import Array
from adaptive_ff.scenario.file import toml_text
from adaptive_ff.scenario.scenario import MAIN_JOB
from plant.lugre import MOST_PASSIVE, LuGreJoint

BANDWIDTH, PERIODS = 10.0, 0.1
"""Crossover of the assumed PI loop, Hz, and the most that it may be times the sampling period."""

LEFT_OUT = ("offset", "viscous_asymmetry", "gravity_sine", "gravity_cosine", *SATURATIONS)
"""Terms that the scenario does without."""

MOST_VARIED = 0.9
"""Largest variation of the simulated friction over position, as a share."""

SOLVER_STEP = 0.001
"""Longest solver period, s."""

SOLVER_TIMES = (1, 2, 4, 8, 16)
"""Over how many times as many steps a joint on bristles is solved where it takes shorter ones."""

KNOWN_OF_JOINT = ("inertia", "coulomb", "viscous", "friction_lag")
"""Fields of the joint that are parameters of the report."""

SEAM = 1e-3
"""Difference of the velocities at both ends of the motion from which on they are joined, over the largest speed."""


def reference_columns(found: LogIdentification) -> dict[str, Array]:
    """Return the motion of a log as the columns of a recorded reference.

    A short one is repeated by the simulation. So that it does not jump then, half a cosine leads from the velocity at
    its end to that at its start, no steeper than the motion itself.
    """
    time, velocity = found.reference.time, found.reference.velocity
    apart = float(velocity[0] - velocity[-1])
    steepest = float(np.max(np.abs(np.diff(velocity) / np.diff(time))))
    if abs(apart) > SEAM * float(np.max(np.abs(velocity))):
        step = float(time[1] - time[0])
        count = max(2, math.ceil(0.5 * math.pi * abs(apart) / (steepest * step)))
        share = np.arange(1, count + 1) / count
        time = np.concatenate([time, time[-1] + step * count * share])
        velocity = np.concatenate([velocity, velocity[-1] + 0.5 * apart * (1.0 - np.cos(math.pi * share))])
    return {"time": time, "velocity": velocity}


def left_out(found: LogIdentification) -> list[str]:
    """Return the names of what the log shows of a joint and its scenario does without."""
    return [name for name in LEFT_OUT if _identifiable(found, name)] + _unmapped(found)


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
        The inertia is not identifiable, or the log does not say which friction it shows: there is no joint to simulate.
    """
    inertia, coulomb = found.value("inertia"), found.value("coulomb")
    if inertia <= 0.0:
        raise InputError(f"{found.name}: the inertia is not identifiable, so there is no scenario")
    if vague := unattributed(found):
        raise InputError(f"{found.name}: {vague}; so there is no scenario")
    slow = known_stiction(found, coulomb)
    period = float(f"{found.period:.4g}")
    joint = _joint(found, slow, period)
    content = {
        "controllers": list(MAIN_JOB),
        "joint": joint,
        "sampling": {"period": period},
        "sensor": {"velocity_noise": _rounded(found.reference.noise)},
        **_ripple(found),
        "reference": {"kind": "csv", "path": reference},
        "feedback": {"inertia": joint["inertia"], "bandwidth": _rounded(min(BANDWIDTH, PERIODS / period))},
        "adaptation": {"stribeck_velocity": joint["stribeck_velocity"], "memory": 5.0, **_mapped(found)},
        **_variation(found),
        "fixed": {name: joint[name] for name in ("inertia", "coulomb", "viscous")},
    }
    return toml_text(content, {**_comments(found, slow, joint), **_map_comments(found)}, _head(found))


def _joint(found: LogIdentification, slow: Stiction, period: float) -> dict[str, Any]:
    """Return the simulated joint; the sampling period in s."""
    substeps = max(1, math.ceil(period / SOLVER_STEP - 1e-9))
    joint = {
        **({"axis": "linear"} if is_linear(found.units) else {}),
        "inertia": _rounded(found.value("inertia")),
        "coulomb": _rounded(found.value("coulomb")),
        "stiction": _rounded(slow.stiction),
        "viscous": _rounded(found.value("viscous")),
        "stribeck_velocity": _rounded(slow.velocity),
        "stribeck_shape": _rounded(slow.shape),
    }
    rest = {"friction_lag": _rounded(found.value("friction_lag")), "solver_period": _rounded(period / substeps)}
    return joint | (_on_bristles(found, joint, period, substeps) or rest)


def _head(found: LogIdentification) -> list[str]:
    """Return the comments above the scenario: where it comes from, what it does without, and in which units it is."""
    left = left_out(found)
    head = [
        f"Joint identified from {_one_line(found.name)} in a band of {found.bandwidth:.3g} Hz.",
        "The simulated joint is the same in both directions and has no offset of the torque"
        + (f"; left out of the log: {' and '.join(left)}." if left else "."),
    ]
    if is_of_current(found.units):
        taken = LINEAR if is_linear(found.units) else ROTARY
        mass, read = (units["inertia"].replace("²", "^2") for units in (found.units, taken))
        head.append(
            f"The torque of the log is a current: read A for {taken['torque']} and {mass} for {read}, or give a torque "
            "constant."
        )
    return head


def _comments(found: LogIdentification, slow: Stiction, joint: dict[str, Any]) -> dict[str, str]:
    """Return how well each value is known, or that it is assumed, by its key."""
    known = slow.remark or _interval(found, "stiction")
    bend_known = _interval(found, "stribeck_velocity") if _identifiable(found, "stiction") else known
    return {
        **{f"joint.{name}": _interval(found, name) for name in KNOWN_OF_JOINT if name in joint},
        **({"joint.stiffness": _path_words(found)} if "stiffness" in joint else {}),
        "joint.stiction": known,
        "joint.stribeck_velocity": bend_known,
        "joint.stribeck_shape": known if slow.shape != 1.0 else "assumed",
        "sampling.period": "as recorded",
        "sensor.velocity_noise": "scatter of the log's velocity without a filter",
        "reference.path": "the motion of the log in its band, its end led to its start, so that it repeats",
        "feedback.inertia": "assumed: the designer knows it",
        "feedback.bandwidth": "assumed; the machine's own loop is not known",
        "adaptation.stribeck_velocity": bend_known,
        "adaptation.memory": "assumed",
        "fixed": "the identified Coulomb and viscous friction",
    }


def _map_comments(found: LogIdentification) -> dict[str, str]:
    """Return the comments on friction over position and on a ripple, by key."""
    learnt = found.position_map
    if learnt is None:
        return {}
    comments = {}
    if learnt.friction is not None:
        comments["variation"] = "the largest rise over the identified period; sin(2 pi q/period) from the start on"
        key = "position_periods" if learnt.periods else "position_hats"
        comments[f"adaptation.{key}"] = "friction depends on position in the log: the controller learns it anew"
        ends = " to ".join(f"{end:.4g}" for end in learnt.range)
        comments["adaptation.position_range"] = f"from the start of the motion; {ends} in the log"
    if learnt.force_periods:
        comments["actuator"] = "the largest ripple of the log; sin(2 pi q/period) from the start on"
        comments["adaptation.ripple_periods"] = "the controller learns its size"
    return comments


def _on_bristles(
    found: LogIdentification, joint: dict[str, Any], period: float, substeps: int
) -> dict[str, Any] | None:
    """Return what a joint has beside its friction where that follows over a path: bristles of the LuGre model.

    None without a path, and where no solver period that is short enough is found.
    """
    path, coulomb = found.value(PATH), joint["coulomb"]
    if path <= 0.0 or coulomb <= 0.0:
        return None
    damping = found.selection.chosen.values.get(DAMPING, 0.0) / path
    bristles = {
        "kind": "lugre",
        "stiffness": _rounded(coulomb / path),
        "damping": _rounded(min(max(damping, 0.0), MOST_PASSIVE * coulomb / joint["stribeck_velocity"])),
    }
    for finer in SOLVER_TIMES:
        made = bristles | {"solver_period": _rounded(period / (finer * substeps))}
        with suppress(ValueError):
            LuGreJoint(**{name: value for name, value in {**joint, **made}.items() if name != "axis"})
            return made
    return None


def _path_words(found: LogIdentification) -> str:
    """Say how well the path is known over which bristles bend."""
    return f"coulomb over a path of {found.value(PATH):.4g} {found.units[PATH]}, {_interval(found, PATH)}"


def _mapped(found: LogIdentification) -> dict[str, Any]:
    """Return what the controller is to learn of friction and force over position."""
    learnt = found.position_map
    if learnt is None:
        return {}
    made: dict[str, Any] = {}
    if learnt.force_periods:
        made["ripple_periods"] = [_rounded(period) for period in learnt.force_periods]
    if learnt.periods:
        made["position_periods"] = [_rounded(period) for period in learnt.periods]
    if learnt.hats:
        made["position_hats"] = learnt.hats
        made["position_range"] = [_rounded(end - found.reference.start) for end in learnt.range]
    return made


def _unmapped(found: LogIdentification) -> list[str]:
    """Return what of a map the simulated joint has not."""
    learnt = found.position_map
    if learnt is None:
        return []
    parts = {
        "force over position": learnt.force is not None and not learnt.force_periods,
        "hats of friction over position": learnt.hats > 0,
        "friction over load": learnt.load_share is not None,
    }
    return [name for name, there in parts.items() if there]


def _ripple(found: LogIdentification) -> dict[str, Any]:
    """Return the ripple of the simulated drive: the largest one of the log."""
    learnt = found.position_map
    if learnt is None or not learnt.force_periods:
        return {}
    amplitude, period = max(zip(learnt.ripple_sizes, learnt.force_periods, strict=True))
    return {"actuator": {"ripple_amplitude": _rounded(amplitude), "ripple_period": _rounded(period)}}


def _variation(found: LogIdentification) -> dict[str, Any]:
    """Return how friction of the simulated joint varies: the strongest of the identified periods."""
    learnt = found.position_map
    if learnt is None or not learnt.periods:
        return {}
    pairs = zip(learnt.coefficients[::2], learnt.coefficients[1::2], learnt.periods, strict=False)
    amplitude, period = max((math.hypot(cosine, sine), period) for cosine, sine, period in pairs)
    return {
        "variation": {
            "position_amplitude": _rounded(min(amplitude, MOST_VARIED)),
            "position_period": _rounded(period),
        }
    }


def _identifiable(found: LogIdentification, name: str) -> bool:
    return name in found.parameters and found.parameters[name].identifiable


def _interval(found: LogIdentification, name: str) -> str:
    """Say how well a parameter is known."""
    if not _identifiable(found, name):
        return "not identifiable from the log"
    estimate, confounded = found.parameters[name].estimate, found.parameters[name].confounded
    end = f", confounded with {', '.join(confounded).replace('_', ' ')}" if confounded else ""
    return f"{100.0 * found.confidence:g} % interval {estimate.lower:.4g} to {estimate.upper:.4g}{end}"


def _rounded(value: float) -> float:
    """Return a value with the digits that a person reads."""
    return float(f"{value:.6g}")


def _one_line(text: str) -> str:
    return " ".join(text.split())
