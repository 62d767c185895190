"""Verdicts in words: what is best, by how much, whether it is worth it, what limits it, what to do next."""

from collections.abc import Mapping, Sequence
from typing import Any

from adaptive_ff.comparison.comparison import Verdict
from adaptive_ff.report.table import DEVIATIONS, shown

LIMITS = {
    "saturation": ("the torque limit", "take a larger drive, or a slower reference"),
    "noise": ("noise", "take a finer sensor, or a slower loop (adaptive-ff tune)"),
    "delay": ("delay", "shorten it, and let the controller know the reference ahead"),
    "bandwidth": ("bandwidth", "take a faster loop (adaptive-ff tune), or sample faster"),
    "friction": ("friction", "learn longer, or on another motion (adaptive-ff excite)"),
}
"""What most of the error that is left is due to, and what to do about it, by code."""

IN_THE_BEST_LOOP = {
    "noise": "take a finer sensor, or a lower velocity.cutoff",
    "bandwidth": "sample faster, or shorten the delay: no faster loop is sound",
    "friction": "give the scenario this bandwidth, and see adaptive-ff compare",
}
"""What to do about it where each controller has its best bandwidth, by the same code."""


def comparison_lines(found: Verdict) -> list[str]:
    """Return the verdict of a comparison, a sentence each."""
    first = f"Verdict: {found.best}"
    if found.over_pi is not None and found.best != "pi":
        first += f", {found.over_pi:.3g} times better than pi"
        if found.torque_variation is not None:
            first += f" at {found.torque_variation:.2g} times its torque variation"
    kept = "nothing that ran is worth it on this joint, keep pi"
    if found.over_pi is None:
        kept = "the least settled error; pi beside it says whether it is worth it"
    lines = [f"{first}." if found.worth else f"{first}: {kept}."]
    if found.limit is not None:
        lines.append(limit_line(found.limit, LIMITS[found.limit][1]))
    if found.given or found.identified:  # estimates without uncertainties tell neither
        lines.append(parameters_line(found.given, found.identified, found.deviations))
    return lines


def bandwidth_lines(found: Mapping[str, Any]) -> list[str]:
    """Return the verdict of a study of bandwidths."""
    gain = "" if found["over_pi"] is None else f", {found['over_pi']:.3g} times better than pi at its best"
    gain += "" if found["over_pi_loaded"] is None else f" and {found['over_pi_loaded']:.3g} times after a load"
    worth = "" if found["worth"] else ": nothing that ran is worth it on this joint, keep pi"
    limit = limit_line(found["limit"], IN_THE_BEST_LOOP[found["limit"]])
    return [f"Verdict: {found['best']} at {found['bandwidth']:.3g} Hz{gain}{worth}.", limit]


def limit_line(limit: str, step: str) -> str:
    """Return what most of the error that is left is due to, by its code, and what to do about it."""
    return f"Error due to {LIMITS[limit][0]}: {step}."


def matrix_lines(found: Mapping[str, Any]) -> list[str]:
    """Return the verdict of the matrix."""
    below = f"below pi on {', '.join(found['below_pi'])}" if found["below_pi"] else "nowhere below pi"
    return [
        f"Verdict: {found['best']}, {found['over_pi']:.3g} times better than pi in the geometric mean of "
        f"{found['scenarios']} scenarios, {found['worst_over_pi']:.3g} times on {found['worst']}; {below}. "
        f"Next: adaptive-ff compare {found['worst']}."
    ]


def parameters_line(
    given: Sequence[str], identified: Sequence[str], deviations: Mapping[str, float | None] | None = None
) -> str:
    """Return which parameters are given, or stay as assumed, and the one of the others that is least certain."""
    if not identified:
        return f"Identified parameters: none; given: {', '.join(given)}."
    first = f"Not identified: {', '.join(given)}" if given else "Identified parameters: all"
    widest = max(identified, key=lambda name: (deviations or {}).get(name) or 0.0)
    wide = (deviations or {}).get(widest)
    if wide is None:
        return f"{first}."
    spread = DEVIATIONS * wide
    return f"{first}; {widest} {f'± {shown(100.0 * spread, 2)} %' if spread < 1.0 else 'is not told from zero'}."
