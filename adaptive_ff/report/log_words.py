"""What was made of a recorded log in words: identification, open-loop score, replay; verdicts, what to do next."""

import shlex
from collections.abc import Mapping
from typing import Any

from adaptive_ff.identify.columns import is_mapped, unit_of
from adaptive_ff.identify.motion import TUNING
from adaptive_ff.identify.regression import Parameter
from adaptive_ff.identify.result import CARE, GOOD, LEFT, LogIdentification
from adaptive_ff.identify.score import Score
from adaptive_ff.replay.replay import COLD, FIXED, NONE, RECORDED, SAVED, Replay
from adaptive_ff.report.table import Cell, Columns, Table, shown, table
from adaptive_ff.report.verdicts import parameters_line

NAMES = {"viscous_asymmetry": "by direction", "stiction_excess": "stiction − coulomb", "torque_delay": "torque delay"}

MORE = {"speed": "higher speeds", "acceleration": "faster changes of speed"}
LESS = {"speed": "more motion at low speeds", "acceleration": "more motion at steady speeds"}
"""What to record, by the motion that narrows an interval, more or less of it than is usual."""

SAYS = {
    "one_way": "the motion is one-way: record both directions",
    "one_speed": "the speed hardly changes: record several speeds",
    "no_acceleration": "the acceleration does not stand out of its noise: record faster changes of speed",
    "one_sine": "on one sine inertia and gravity are one number: record several frequencies or a larger stroke",
}
"""What to record where a parameter is not identifiable, by its reason."""

NOTHING = 1e-6  # fraction of its interval below which a value is shown as zero
LEAST_MOVE = 0.1  # fraction of half its interval by which a refinement must move a value to be said to

SCORES = {
    "follows": "the model follows the joint",
    "drifts": "the model drifts away from the joint within seconds, as open loop does where little holds a position",
    "does not follow": "the model does not follow the joint",
}
"""Verdicts of a score in words."""

FEEDFORWARDS = {
    NONE: "none",
    RECORDED: "the machine's own, as recorded",
    FIXED: "fixed model of the first half",
    COLD: "adaptive, cold start",
    SAVED: "adaptive, from the saved state",
}


def parameters_table(found: LogIdentification) -> Table:
    """Return parameters with half widths of their intervals: the textbook's model, and what refinements make of it."""
    models = {"textbook": found.textbook, **({} if found.refined is None else {"refined": found.refined})}
    names = dict.fromkeys(name for model in models.values() for name in model.parameters if not is_mapped(name))
    rows: list[list[Cell]] = []
    for name in names:
        cells = [_half(model.parameters.get(name)) for model in models.values()]
        rows.append([NAMES.get(name, name.replace("_", " ")), *cells, unit_of(found.units, name)])
    rows.append(["torque left", *(_percent(model.left) for model in models.values()), "cross-validated"])
    title = f"{found.data.used} of {found.data.log.time.size} samples, band {found.data.band:.3g} Hz"
    return table(title, rows, {"": None, **dict.fromkeys(models, ("", 4)), "unit": None})


def map_table(found: LogIdentification) -> Table | None:
    """Return friction and force over position with their intervals; None where the model has none."""
    mapped = {name: one for name, one in found.best.parameters.items() if is_mapped(name)}
    if not mapped:
        return None
    rows = [[name.replace("_", " "), _half(one)] for name, one in mapped.items()]
    return table("Over position", rows, {"part": None, found.units["torque"]: ("", 4)})


def verdict_lines(found: LogIdentification) -> list[str]:
    """Return the verdict with its reasons."""
    reasons = [f"{name}: {SAYS[code]}" for name, code in found.unidentified.items()]
    left = found.best.left
    if found.validation is not None:
        reasons.append(f"{_percent(found.validation)} of the torque of {found.validated_on} are left")
        left = max(left, found.validation)
    if left > LEFT[GOOD]:
        what = "most of the torque is something else" if left > LEFT[CARE] else "part of the torque is something else"
        reasons.append(f"{_percent(left)} of the torque are left: {what} (load, coupling, other axes)")
    if found.vague:
        reasons.append(f"{', '.join(found.vague)}: known to {TUNING.vague:.0%} or worse; {_narrowing(found)}")
    lines = [f"Verdict: {found.grade}" + (f"; {'; '.join(reasons)}." if reasons else ".")]
    if found.refined is not None:
        lines.append(f"Refined by {', '.join(found.taken)}; {_moved(found)}.")
    return [*lines, parameters_line(found.given, list(found.best.values))]


def next_step(found: LogIdentification, folder: str, *, written: bool, simulated: bool) -> str:
    """Return what to do next, by whether the scenario and files for simulators are written."""
    if found.unidentified:
        return "Next: record again as said above."
    if not written or found.grade not in (GOOD, CARE):
        return "Next: give what is known of the load (--known-torque), or another column of the torque."
    further = "" if simulated else ", or --write mjcf,urdf,isaac,drake"
    return f"Next: adaptive-ff compare {shlex.quote(folder)}/scenario.toml{further}."


def _narrowing(found: LogIdentification) -> str:
    """Return which motion narrows the widest interval of those that a simulated joint needs."""
    widest = max(found.vague, key=lambda name: found.joint_parameters[name].half_width)
    kind, times = found.narrowed_by[widest]
    more = {True: MORE, False: LESS}[times > 1.0][kind]
    return f"{more} would narrow {widest} most ({times:.2g} times the usual {kind})"


def details(found: LogIdentification) -> list[str]:
    """Return how the numbers came about."""
    ends = [
        f"{name.replace('_', ' ')} {one.lower:.4g} to {one.upper:.4g} {unit_of(found.units, name)}"
        for name, one in found.parameters.items()
    ]
    return [
        f"Least squares of torque and unit torques behind one zero-phase low-pass of {found.data.band:.3g} Hz; "
        "inertia, Coulomb and viscous friction not negative.",
        f"± is half of the {100.0 * found.confidence:g} % interval: the spread that leaving out segments of the log "
        "shows, by Student's t, three times what half of the band changes, and how far models differ over which the "
        "textbook's values are averaged, by Akaike's weights.",
        "Refinements are taken where they leave at least 10 % less (rms) of segments that were left out, by one and a "
        "half standard errors.",
        f"Intervals of the textbook's model: {'; '.join(ends)}.",
    ]


def score_lines(score: Score) -> list[str]:
    """Return what an open-loop score says, a sentence each."""
    unit = "mm" if score.found.linear else "mrad"
    whole, windows, moved, training, close = (
        f"{1e3 * value:.3g} {unit}"
        for value in (score.rms, score.windows, score.moved, score.training_rms, score.training_windows)
    )
    return [
        f"Open loop on {score.tested}: {whole} rms, fit {score.fit:.4g} %; in windows of 1 s "
        f"{windows} of the {moved} moved.",
        f"On the log that was identified: {training}; in windows {close}. Torque left on the other: "
        f"{_percent(score.torque_left)}.",
        f"Verdict: {SCORES[score.grade]}.",
    ]


def left_table(replay: Replay) -> Table:
    """Return the torque left by each feedforward, one a row."""
    title = f"Torque left to the feedback (rms) in a band of {replay.data.band:.3g} Hz"
    rows: list[list[Cell]] = [
        [words, *(float(value) for value in replay.left[name])]
        for name, words in FEEDFORWARDS.items()
        if name in replay.left
    ]
    columns: Columns = dict.fromkeys(("whole log", "second half", "joint moves"), (replay.unit, 3))
    return table(title, rows, {"feedforward": None, **columns})


def replay_lines(found: Mapping[str, Any]) -> list[str]:
    """Return the verdict of a replay."""
    first = f"Verdict: {FEEDFORWARDS[found['best']]}"
    if not found["worth"]:
        return [f"{first}: no feedforward is worth it here. Next: what is known of the load (--known-torque)."]
    first += f", {found['over_none']:.3g} times less torque left than without"
    if found["over_recorded"] is not None and found["best"] != "recorded":
        first += f", {found['over_recorded']:.3g} times less than with the machine's own"
    step = "adaptive-ff identify, then export the controller with its scenario.toml"
    rest = found["given"] + found["unidentified"]
    return [f"{first} (second half). Next: {step}.", parameters_line(rest, found["identified"])]


def _half(one: Parameter | None) -> Cell:
    if one is None:
        return ""
    half = 0.5 * (one.upper - one.lower)
    return (one.value if abs(one.value) > NOTHING * half else 0.0, half)


def _percent(part: float) -> str:
    return f"{100.0 * part:.2g} %"


def _moved(found: LogIdentification) -> str:
    """Say how far the refinements move the textbook's parameters."""
    parts, refined = [], {} if found.refined is None else found.refined.values
    for name in ("inertia", "coulomb", "viscous"):
        before, after = found.textbook.parameters.get(name), refined.get(name)
        if before is not None and before.lower > 0.0 and after is not None:
            moved = after / before.value - 1.0
            if abs(moved) > LEAST_MOVE * before.half_width:
                parts.append(f"{name} {'+' * (moved > 0.0)}{shown(100.0 * moved, 2)} %")
    return f"against the textbook {', '.join(parts)}" if parts else "the textbook's values stay within their intervals"
