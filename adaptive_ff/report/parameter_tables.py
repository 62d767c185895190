"""An identified log in words: a table, a verdict, and what to do next; at most 25 lines of 80 columns."""

import shlex

from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff.identify.identification import SAYS
from adaptive_ff.identify.result import CARE, GOOD, LEFT, WIDE, LogIdentification, Parameter
from adaptive_ff.identify.units import unit_of

NAMES = {"viscous_asymmetry": "by direction", "stiction_excess": "stiction − coulomb", "torque_delay": "torque delay"}


def parameters_table(found: LogIdentification) -> Table:
    """Return parameters with half widths of their intervals: the textbook's model, and what refinements make of it."""
    table = Table(box=SIMPLE, title=_title(found), title_style="bold", title_justify="left", padding=(0, 1))
    table.add_column("", no_wrap=True)
    table.add_column("textbook", justify="right", no_wrap=True)
    if found.refined is not None:
        table.add_column("refined", justify="right", no_wrap=True)
    table.add_column("", no_wrap=True)
    textbook, refined = found.textbook.parameters, {} if found.refined is None else found.refined.parameters
    for name in dict.fromkeys([*textbook, *_named(refined)]):
        cells = [_cell(textbook.get(name))]
        if found.refined is not None:
            cells.append(_cell(refined.get(name)))
        table.add_row(NAMES.get(name, name.replace("_", " ")), *cells, unit_of(found.units, name))
    left = [_percent(found.textbook.left), *([] if found.refined is None else [_percent(found.refined.left)])]
    table.add_row("torque left", *left, "of blocks left out")
    return table


def map_table(found: LogIdentification) -> Table | None:
    """Return friction and force over position with their intervals; None where the model has none."""
    mapped = {name: one for name, one in found.best.parameters.items() if _is_mapped(name)}
    if not mapped:
        return None
    table = Table(title="Over position", box=SIMPLE, title_style="bold", title_justify="left")
    for heading in ("part", found.units["torque"]):
        table.add_column(heading, justify="left" if heading == "part" else "right", no_wrap=True)
    for name, one in mapped.items():
        table.add_row(name.replace("_", " "), _cell(one))
    return table


def verdict_lines(found: LogIdentification) -> list[str]:
    """Return the verdict with its reasons, and the next step."""
    reasons = [f"{name}: {SAYS[code]}" for name, code in found.unidentified.items()]
    left = found.best.left
    if found.validation is not None:
        reasons.append(f"{_percent(found.validation)} of the torque of {found.validated_on} are left")
        left = max(left, found.validation)
    if left > LEFT[GOOD]:
        what = "most of the torque is something else" if left > LEFT[CARE] else "part of the torque is something else"
        reasons.append(f"{_percent(left)} of the torque are left: {what} (load, coupling, other axes)")
    if found.vague:
        reasons.append(f"{', '.join(found.vague)}: known to {WIDE:.0%} or worse; a longer log narrows that")
    lines = [f"Verdict: {found.grade}" + (f"; {'; '.join(reasons)}." if reasons else ".")]
    if found.refined is not None:
        lines.append(f"Refined by {', '.join(found.taken)}; {_moved(found)}.")
    return lines


def next_step(found: LogIdentification, folder: str, written: bool) -> str:
    """Return what to do next."""
    if found.unidentified:
        return "Next: record again as said above."
    if not written or found.grade not in (GOOD, CARE):
        return "Next: give what is known of the load (--known-torque), or another column of the torque."
    return f"Next: adaptive-ff compare {shlex.quote(folder)}/scenario.toml, or --write mjcf,urdf,isaac,drake."


def details(found: LogIdentification) -> list[str]:
    """Return how the numbers came about."""
    percent = f"{100.0 * found.confidence:g} %"
    lines = [
        f"Least squares of torque and unit torques behind one zero-phase low-pass of {found.bandwidth:.3g} Hz; "
        "inertia, Coulomb and viscous friction not negative.",
        f"± is half of the {percent} interval: the spread that leaving out blocks of the log shows, by Student's t, "
        "half a sample of the torque's time unless --torque-delay is given, and, on its side, what better models move.",
        "Refinements are taken where they leave at least 10 % less (rms) of blocks that were left out, by one and a "
        "half standard errors.",
    ]
    ends = [
        f"{name.replace('_', ' ')} {one.lower:.4g} to {one.upper:.4g} {unit_of(found.units, name)}"
        for name, one in found.parameters.items()
    ]
    return [*lines, f"Intervals of the textbook's model: {'; '.join(ends)}."]


def _title(found: LogIdentification) -> str:
    return f"{found.used} of {found.samples} samples, band {found.bandwidth:.3g} Hz"


def _named(refined: dict[str, Parameter]) -> list[str]:
    return [name for name in refined if not _is_mapped(name)]


def _is_mapped(name: str) -> bool:
    return name.startswith(("force_", "friction_")) and name != "friction_lag"


def _cell(one: Parameter | None) -> str:
    if one is None:
        return ""
    half = 0.5 * (one.upper - one.lower)
    return f"{one.value:.4g} ± {half:.2g}"


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %"


def _moved(found: LogIdentification) -> str:
    """Say how far the refinements move the textbook's parameters."""
    assert found.refined is not None
    parts = []
    for name in ("inertia", "coulomb", "viscous"):
        before, after = found.textbook.values.get(name), found.refined.values.get(name)
        if before and after is not None:
            parts.append(f"{name} {100.0 * (after / before - 1.0):+.2g} %")
    return "against the textbook " + ", ".join(parts)
