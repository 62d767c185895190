"""Diagnosis of the adaptive controller in words."""

import io

import numpy as np
from rich.console import Console

from adaptive_ff.adaptive.diagnosis import Code, Diagnosis, Finding
from adaptive_ff.adaptive.extensions.over_position import LearntMap
from adaptive_ff.friction.model import unit_of
from adaptive_ff.report.table import Cell, Table, table

WIDTH = 80  # width of the text, characters
LEAST_VARIATION = 0.01  # least rise and fall of friction over position that is worth a sentence

SENTENCES = {
    Code.HELD: "Holds its estimates: enabled is False.",
    Code.NO_MOTION: "In {time:.3g} s there was nothing to learn from: the reference was zero.",
    Code.NOT_LEARNT: "The motion so far has not shown {names}: do not rely on these numbers.",
    Code.NO_POSITION: "Nothing is known of {names}: no position was given, or the joint stayed where it was.",
    Code.TORQUE_UNKNOWN: (
        "neither torque_limit nor realised_torque is given: nothing is observed, and torque that the drive cut off is "
        "learnt as friction."
    ),
    Code.PLAN_UNKNOWN: "next_reference is never given: reversals are found from the past, a period late.",
    Code.NO_INTEGRAL: "the integral gain is zero: the torque jumps where estimates change, and no offset is known.",
    Code.MEASUREMENTS_LOST: "{lost:g} measurements of {samples:g} were not finite and skipped.",
    Code.INPUTS_IMPLAUSIBLE: "at {samples:g} samples an input was not plausible and was not used.",
    Code.INNOVATIONS_COLOURED: (
        "successive prediction errors are correlated by {correlation:.2f}: delay, velocity_lag, inertia or gear are "
        "not what was given, or friction is of a kind that the columns lack."
    ),
    Code.JUST_CHANGED: "The joint has changed lately with a probability of {probability:.0%}: it learns fast.",
    Code.OBSERVER_HELPS: "The observer gives {gain:.0%} of the {torque:.3g} N m that the feedforward lacks.",
    Code.AT_BOUND: "{names} is at the end of what is assumed possible, {value:.3g} {unit}.",
    Code.INERTIA_FAR: (
        "the inertia is {ratio:.2g} times the {assumed:.3g} kg m² that the feedback was designed for: so is its "
        "bandwidth, divided by {ratio:.2g}."
    ),
    Code.FRICTION_RISES: (
        "Friction rises from {from:.3g} N m at standstill to {to:.3g} N m: the joint has no Stribeck peak."
    ),
}
"""A sentence for each code."""


def sentence(finding: Finding) -> str:
    """Return what was found in words."""
    unit = unit_of(finding.names[0]) if finding.names else ""
    names = " and ".join(filter(None, (", ".join(finding.names[:-1]), *finding.names[-1:])))
    return SENTENCES[finding.code].format(names=names, unit=unit, **finding.values)


def sentences(diagnosis: Diagnosis) -> list[str]:
    """Return what is to be said beside the table, warnings last."""
    said = [f"Learnt from {diagnosis.moved:.3g} s of motion so far."]
    warnings = diagnosis.warnings
    said += [sentence(finding) for finding in diagnosis.findings if finding not in warnings]
    said += map_sentences(diagnosis.friction_map)
    return said + [f"Warning: {sentence(finding)}" for finding in warnings]


def map_sentences(learnt: LearntMap | None) -> list[str]:
    """Return where friction rises and falls, and by how much; nothing of a controller without a map."""
    said: list[str] = []
    if learnt is None:
        return said
    factor, position = learnt.factor, learnt.position
    if factor.size and np.ptp(factor) > LEAST_VARIATION:
        high, low = np.argmax(factor), np.argmin(factor)
        repeats = f", and repeats every {learnt.periods[0]:.3g} rad" if len(learnt.periods) == 1 else ""
        said.append(
            f"Friction depends on position: it rises by {100.0 * (factor[high] - 1.0):.0f} % at {position[high]:.3g} "
            f"rad and falls by {100.0 * (1.0 - factor[low]):.0f} % at {position[low]:.3g} rad{repeats}."
        )
    if slope := learnt.load_share:
        change = "rises" if slope > 0.0 else "falls"
        said.append(f"Friction {change} by {100.0 * abs(slope):.2g} % for each N m of known torque.")
    return said


def diagnosis_table(diagnosis: Diagnosis) -> Table:
    """Return the estimates with their standard deviations."""
    rows: list[list[Cell]] = [
        [f"{one.name}, {one.unit}" if one.unit else one.name, (one.estimate, one.uncertainty), 100.0 * one.learnt]
        for one in diagnosis.parameters
    ]
    return table("", rows, {"parameter": None, "estimate ± deviation": ("", 4), "of the prior's": ("%", 2)})


def diagnosis_text(diagnosis: Diagnosis) -> str:
    """Return the table and the sentences as a text."""
    text = io.StringIO()
    console = Console(file=text, width=WIDTH, color_system=None)
    console.print(diagnosis_table(diagnosis))
    for said in sentences(diagnosis):
        console.print(said, markup=False, highlight=False)
    return text.getvalue().strip("\n")
