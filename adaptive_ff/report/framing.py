"""Limits of panels that show what matters: one controller that runs away neither sets them nor is hidden."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from adaptive_ff.report.drawing import LIFT, QUIET, Series

RUNS_AWAY = "adaptive_paper"
"""Its estimates and torques leave all bounds at times; the limits are set by the others where there are any."""


def peak_of(values: Series) -> float:
    """Return the largest magnitude of what is finite."""
    return float(np.max(np.abs(values), where=np.isfinite(values), initial=0.0))


def typical_peak(curves: Mapping[str, Series]) -> float:
    """Return the median peak of some curves, of two the smaller."""
    return sorted(map(peak_of, curves.values()))[(len(curves) - 1) // 2]


def leading(curves: Mapping[str, Series]) -> dict[str, Series]:
    """Return the curves that set limits."""
    calm = {name: curve for name, curve in curves.items() if not name.endswith(RUNS_AWAY)}
    return calm if any(calm) else dict(curves)


def frame(panels: Sequence[Axes], curves: Mapping[str, Series], cap: float) -> None:
    """Fit the limits of panels to curves, but not beyond a cap; name the curves that leave them."""
    cap = cap or math.inf
    values = np.concatenate(list(leading(curves).values()))
    values = np.clip(values[np.isfinite(values)], -cap, cap)
    low, high = float(np.min(values)), float(np.max(values))
    margin = 0.06 * (high - low) or 0.1 * abs(high) or 1.0
    for axes in panels:
        axes.set_ylim(low - margin, high + margin)
    beyond = max(abs(low), abs(high)) + margin
    name_those_beyond(panels[0], curves, beyond)


def name_those_beyond(axes: Axes, curves: Mapping[str, Series], limit: float) -> None:
    """Name above a panel the curves that leave it, and how far they go."""
    peaks = {name: peak_of(curve) for name, curve in curves.items() if peak_of(curve) > limit}
    gone = [f"{plain_name(name)} reaches {_number(peak)}" for name, peak in peaks.items()]
    more = f" and {len(gone) - 2} more" if len(gone) > 2 else ""
    place: Any = {"xycoords": "axes fraction", "xytext": (0.0, LIFT), "textcoords": "offset points"}
    axes.annotate(", ".join(gone[:2]) + more, (1.0, 1.0), **place, ha="right", fontsize=8.0, color=QUIET)


def _number(value: float) -> str:
    return f"{value:,.0f}" if 1e3 <= value < 1e6 else f"{value:.3g}"


def make_logarithmic(axes: Axes, since: float) -> None:
    """Make a panel logarithmic, one to four decades, down to what it shows since a time; leave it where all is zero."""
    lines = {str(line.get_label()): line for line in axes.lines}
    calm = [line for name, line in lines.items() if name != RUNS_AWAY] or list(lines.values())
    curves = [(np.asarray(line.get_xdata()), np.asarray(line.get_ydata())) for line in calm]
    top = max(float(np.max(values)) for _, values in curves)
    if top == 0.0:
        return
    if RUNS_AWAY in lines:
        name_those_beyond(axes, {RUNS_AWAY: np.asarray(lines[RUNS_AWAY].get_ydata())}, 1.3 * top)
    low = min(float(np.min(values, where=(time >= since) & (values > 0.0), initial=top)) for time, values in curves)
    low = min(max(low, 1e-4 * top) / 1.3, top / 5.0)
    axes.set_yscale("log", nonpositive="mask")
    axes.set_ylim(low, 1.3 * top)
    axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if top < 200.0 * low else (1.0,)))
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def plain_name(name: str) -> str:
    """Return a name in which matplotlib sees no mathematics, and which it does not hide for a leading underscore."""
    return (f" {name}" if name.startswith("_") else name).replace("$", r"\$")
