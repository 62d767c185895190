"""Fig. 12: the parameters over time: coefficients of (4) by RLS, and the joint that they stand for."""

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from adaptive_ff.friction.model import ESTIMATED, UNITS
from adaptive_ff.learning.batch import Array
from adaptive_ff.learning.series import COEFFICIENTS, series_coefficients
from adaptive_ff.report.style import INK, STYLE, WIDTH
from benchmarks.paper.closed_loop_online import is_possible, physical_series
from benchmarks.paper.drawing import SERIES, TORQUE_FORM, Look, label, legend
from benchmarks.paper.identification_data import SYMBOLS, TRUE
from benchmarks.paper.robot import PERIOD, Drive
from benchmarks.paper.summaries import TRUTH
from benchmarks.paper.watching import FORGETTING, Form, Series

SHOWN = 60.0  # s
QUANTILES = (0.05, 0.95)
"""Between these the coefficients decide what is drawn."""

COEFFICIENT_UNITS = {"b0": " (rad/s per N m)", "b1": " (rad/s per N m)", "c1": " (rad/s)", "d1": " (rad/s)"}

RLS: Look = {**SERIES, "linewidth": 0.6, "label": f"series (4), RLS, lambda {FORGETTING:g}"}
OFFLINE: Look = {"color": "#0072b2", "linewidth": 1.2, "linestyle": (0, (5, 2)), "label": "series (4), offline LS"}
FORM: Look = {**TORQUE_FORM, "linewidth": 1.4, "label": "torque form, online"}
TRUE_LOOK: Look = {"color": INK, "linewidth": 1.1, "linestyle": (0, (2, 2)), "zorder": 3.0, "label": "true"}


def draw(record: Drive, series: Series, form: Form) -> Figure:
    """Draw the six coefficients on the left, the five physical parameters on the right."""
    part = record.time <= SHOWN
    time = record.time[part]
    coefficients = series.coefficients[part]
    physical = physical_series(coefficients)
    true = np.array(series_coefficients(TRUE, PERIOD))
    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 8.6), layout="constrained")
        figure.get_layout_engine().set(h_pad=0.05)
        grid = figure.subplots(len(COEFFICIENTS), 2, sharex=True)
        for axes, name, values, truth, offline in zip(
            grid[:, 0], COEFFICIENTS, coefficients.T, true, series.offline.values, strict=True
        ):
            axes.plot(time, values, **RLS)
            axes.axhline(offline, **OFFLINE)
            axes.axhline(truth, **TRUE_LOOK)
            frame(axes, values[time > 0.1 * SHOWN], (truth, float(offline)))
            label(axes, name + COEFFICIENT_UNITS.get(name, ""))
        for axes, name, values, estimates, truth in zip(
            grid[:-1, 1], ESTIMATED, physical.T, form.estimates[part].T, TRUTH, strict=True
        ):
            axes.plot(time, values, **RLS)
            axes.plot(time, estimates, **FORM)
            axes.axhline(truth, **TRUE_LOOK)
            axes.set_ylim(truth * np.array([-1.0, 3.0]))
            label(axes, f"{SYMBOLS[name]} ({UNITS[name]})")
        possible = is_possible(physical)
        grid[-1, 1].vlines(time[possible], 0.0, 1.0, color=RLS["color"], linewidth=0.6)
        grid[-1, 1].set(ylim=(0.0, 1.0), yticks=[])
        label(grid[-1, 1], f"RLS stands for a possible joint ({100.0 * np.mean(possible):.1f} % of the time)")
        for axes in grid[-1]:
            axes.set_xlabel("time (s)")
        grid[0, 0].set_xlim(0.0, SHOWN)
        legend(figure, [RLS, OFFLINE, FORM, TRUE_LOOK])
    return figure


def frame(axes: Axes, values: Array, shown: tuple[float, float]) -> None:
    """Limit an axis to most of the values and to what must be seen."""
    low, high = np.quantile(values, QUANTILES)
    low, high = min(low, *shown), max(high, *shown)
    margin = 0.15 * (high - low)
    axes.set_ylim(low - margin, high + margin)
