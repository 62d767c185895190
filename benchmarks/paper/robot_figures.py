"""Figs 7 and 9 to 12: what is drawn of the robot's record, and of what each way of identification makes of it."""

from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from adaptive_ff.friction.model import ESTIMATED, UNITS
from adaptive_ff.learning.series import COEFFICIENTS, series_coefficients
from adaptive_ff.report.style import INK, QUIET, STYLE, Panel, explain_looks, picture
from benchmarks.paper.data import SYMBOLS, TRUE, TRUTH_VALUES, Array
from benchmarks.paper.drawing import (
    GUIDE,
    SERIES,
    TORQUE_FORM,
    TRUE_LOOK,
    TRUTH,
    Look,
    canvas,
    label,
    plain_numbers,
    running_rms,
)
from benchmarks.paper.robot import CURRENT_STEP, CYCLE, LATE, NOISE, PERIOD, TORQUE_CONSTANT, Drive
from benchmarks.paper.watching import FORGETTING, Form, Series, is_possible, physical_series

CLOSE_UPS = {"wide": 6.0, "close": 0.6}  # s
FIRST_SECONDS = 6.0  # s, of Fig. 10
SHOWN = (60.0, 75.0)  # s, of Figs 9 and 11
ONLINE_SHOWN = 60.0  # s, of Fig. 12
WINDOW = 90  # samples of the running rms, about 2 s
LARGEST = 0.5  # rad/s, of what is drawn
QUANTILES = (0.05, 0.95)
"""Between these the coefficients decide what is drawn."""

SHADE: Look = {"color": "#f0f0f0", "zorder": 0.4}
TORQUE: Look = {"color": "#0072b2", "linewidth": 0.9, "drawstyle": "steps-post"}
LATE_COLOUR = "#d55e00"
MEASURED: Look = {**TRUTH, "label": "measured"}
OFFLINE: Look = {**SERIES, "label": "series (4), offline LS"}
FORM: Look = {**TORQUE_FORM, "label": "torque form, simulated"}
LATE_LOOK: Look = {"color": INK, "marker": "v", "markersize": 3.5, "linestyle": "", "label": "late sample"}
PRIOR: Look = {"color": "#cc79a7", "linewidth": 1.0, "label": f"RLS, lambda {FORGETTING:g}, a-priori"}
POSTERIOR: Look = {"color": "#0072b2", "linewidth": 1.0, "label": "RLS, a-posteriori"}
FLOOR: Look = {**TRUE_LOOK, "label": "noise of the sensor"}
RLS: Look = {**SERIES, "linewidth": 0.6, "label": f"series (4), RLS, lambda {FORGETTING:g}"}
LEVEL: Look = {"color": "#0072b2", "linewidth": 1.2, "linestyle": (0, (5, 2)), "label": "series (4), offline LS"}
ONLINE: Look = {**TORQUE_FORM, "linewidth": 1.4, "label": "torque form, online"}
COEFFICIENT_UNITS = {"b0": " (rad/s per N m)", "b1": " (rad/s per N m)", "c1": " (rad/s)", "d1": " (rad/s)"}


@rc_context(STYLE)
def figure_07(record: Drive) -> Figure:
    """Draw the torque over the whole record, and two close-ups around the reversal nearest to its middle."""
    reversals = record.time[1:][np.diff(np.sign(record.reference)) != 0.0]
    middle = float(reversals[np.argmin(np.abs(reversals - 0.5 * record.time[-1]))])
    figure, axes = canvas([["wide", "close"], ["whole", "whole"]], 4.6)
    for name, length in CLOSE_UPS.items():
        part = np.abs(record.time - middle) <= 0.5 * length + 0.05
        axes[name].plot(record.time[part], record.commanded[part], **TORQUE)
        axes[name].set_xlim(middle - 0.5 * length, middle + 0.5 * length)
        label(axes[name], f"torque (N m), {length:g} s of it", "time (s)")
    part = np.abs(record.time - middle) <= 0.5 * CLOSE_UPS["close"]
    axes["close"].plot(record.time[part], record.commanded[part], ".", color=QUIET, markersize=5.0)
    steps = f"steps of {TORQUE_CONSTANT * CURRENT_STEP:g} N m = {TORQUE_CONSTANT:g} N m/A × {1e3 * CURRENT_STEP:g} mA"
    axes["close"].annotate(steps, (0.03, 0.9), xycoords="axes fraction", color=QUIET, fontsize=8.0)
    axes["whole"].plot(record.time, record.commanded, **{**TORQUE, "linewidth": 0.6})
    for outer, inner in (("whole", "wide"), ("wide", "close")):
        axes[outer].axvspan(middle - 0.5 * CLOSE_UPS[inner], middle + 0.5 * CLOSE_UPS[inner], **SHADE)
    axes["whole"].set_xlim(0.0, record.time[-1])
    label(axes["whole"], "torque (N m), whole record; the close-ups are shaded", "time (s)")
    return figure


def figure_09(record: Drive, series: Series, form: Form) -> Figure:
    """Draw the prediction of the offline fit one sample ahead, its error, and its free run."""
    part = (record.time >= SHOWN[0]) & (record.time <= SHOWN[1])
    time, velocity, offline = record.time[part], record.velocity[part], series.errors["offline"][part]
    late = np.diff(record.time, prepend=0.0)[part] > LATE
    below = np.full(np.count_nonzero(late), 1e3 * float(np.min(offline)) - 4.0)
    free, simulated = series.errors["free"][part], form.errors["free"][part]
    ahead: list[Any] = [(time, velocity, MEASURED), (time, velocity - offline, OFFLINE)]
    errors: list[Any] = [(time, 1e3 * offline, OFFLINE), (time, 1e3 * form.errors["online"][part], FORM)]
    run: list[Any] = [(time, velocity, MEASURED), (time, velocity - free, OFFLINE), (time, velocity - simulated, FORM)]
    titles = {
        "velocity (rad/s): measured, and predicted one sample ahead by the offline fit": ahead,
        "error of the prediction one sample ahead (mrad/s)": [*errors, (time[late], below, LATE_LOOK)],
        "velocity (rad/s): measured, and free run from the recorded torque": run,
    }
    return picture([Panel(name, curves, [(0.0, GUIDE)], SHOWN) for name, curves in titles.items()], 7.2)[0]


@rc_context(STYLE)
def figure_10(record: Drive) -> Figure:
    """Draw the sampling times of the first seconds, and how often each occurs in the whole record."""
    durations, ends = 1e3 * np.diff(record.time), record.time[1:]
    mean = float(np.mean(durations))
    figure, axes = canvas([["course", "counts"]], 2.9, sharey=True, width_ratios=(3.2, 1.0))
    course, counts = axes["course"], axes["counts"]
    part, late = ends <= FIRST_SECONDS, durations > 1.2 * mean
    for chosen, colour in ((part & ~late, QUIET), (part & late, LATE_COLOUR)):
        course.vlines(ends[chosen], 0.0, durations[chosen], color=colour, linewidth=0.9)
        course.plot(ends[chosen], durations[chosen], ".", color=colour, markersize=4.0)
    course.axhline(mean, **TRUE_LOOK)
    course.set(xlim=(0.0, FIRST_SECONDS), ylim=(0.0, 1.12 * float(durations.max())))
    label(course, f"sampling time (ms), mean {mean:.2f} dashed; repeats every {CYCLE} samples", "time (s)")
    lengths, numbers = np.unique(np.round(durations), return_counts=True)
    shares = 100.0 * numbers / durations.size
    counts.barh(lengths, shares, height=1.6, color=np.where(lengths > 1.2 * mean, LATE_COLOUR, QUIET))
    for length, share in zip(lengths, shares, strict=True):
        counts.annotate(f" {length:.0f} ms: {share:.1f} %", (0.0, length + 1.2), fontsize=8.0)
    counts.set(xlim=(0.0, 100.0))
    counts.grid(axis="y", visible=False)
    label(counts, "how often", "share of samples (%)")
    return figure


def figure_11(record: Drive, series: Series, form: Form) -> Figure:
    """Draw both "predictions" of RLS in a close-up, and running errors of everything over the whole record."""
    part = (record.time >= SHOWN[0]) & (record.time <= SHOWN[1])
    time, velocity = record.time[part], record.velocity[part]
    prior, posterior = (velocity - series.errors[name][part] for name in ("prior", "posterior"))
    every = np.clip(np.concatenate([velocity, prior]), -LARGEST, LARGEST)
    margin = 0.06 * float(np.ptp(every))
    limits = float(every.min()) - margin, float(every.max()) + margin
    beyond = float(np.max(np.abs(prior)))
    more = f"; largest {beyond:.2f}" if beyond > LARGEST else ""
    named = (
        (series.errors["prior"], PRIOR),
        (series.errors["offline"], OFFLINE),
        (form.errors["online"], FORM),
        (series.errors["posterior"], POSTERIOR),
    )
    running = [(record.time, 1e3 * running_rms(values, WINDOW), look) for values, look in named]
    panels = [
        Panel(
            f"velocity (rad/s): with the coefficients of the sample before, (10){more}",
            [(time, velocity, MEASURED), (time, prior, PRIOR)],
            span=SHOWN,
            limits=limits,
        ),
        Panel(
            "velocity (rad/s): with coefficients that have already seen the sample",
            [(time, velocity, MEASURED), (time, posterior, POSTERIOR)],
            span=SHOWN,
            limits=limits,
        ),
        Panel(
            "error (mrad/s), rms of about 2 s; the close-up is shaded",
            running,
            [(1e3 * NOISE, FLOOR)],
            (0.0, float(record.time[-1])),
            (0.5, 1.5 * float(running[0][1].max())),
        ),
    ]
    figure, axes = picture(panels, 7.6, shared=False)
    axes[2].axvspan(*SHOWN, **SHADE)
    axes[2].set_yscale("log")
    plain_numbers(axes[2].yaxis)
    return figure


@rc_context(STYLE)
def figure_12(record: Drive, series: Series, form: Form) -> Figure:
    """Draw the six coefficients on the left, the five physical parameters on the right."""
    part = record.time <= ONLINE_SHOWN
    time, coefficients = record.time[part], series.coefficients[part]
    physical, true = physical_series(coefficients), np.array(series_coefficients(TRUE, PERIOD))
    rows = [[name, other] for name, other in zip(COEFFICIENTS, (*ESTIMATED, "possible"), strict=True)]
    figure, panels = canvas(rows, 8.6, sharex=True)
    for place, name in enumerate(COEFFICIENTS):
        axes, offline = panels[name], float(series.offline.values[place])
        axes.plot(time, coefficients[:, place], **RLS)
        axes.axhline(offline, **LEVEL)
        axes.axhline(true[place], **TRUE_LOOK)
        axes.set_ylim(_limits(coefficients[time > 0.1 * ONLINE_SHOWN, place], true[place], offline))
        label(axes, name + COEFFICIENT_UNITS.get(name, ""))
    for place, name in enumerate(ESTIMATED):
        axes = panels[name]
        axes.plot(time, physical[:, place], **RLS)
        axes.plot(time, form.estimates[part][:, place], **ONLINE)
        axes.axhline(TRUTH_VALUES[place], **TRUE_LOOK)
        axes.set_ylim(TRUTH_VALUES[place] * np.array([-1.0, 3.0]))
        label(axes, f"{SYMBOLS[name]} ({UNITS[name]})")
    last, possible = panels["possible"], is_possible(physical)
    last.vlines(time[possible], 0.0, 1.0, color=RLS["color"], linewidth=0.6)
    last.set(ylim=(0.0, 1.0), yticks=[], xlim=(0.0, ONLINE_SHOWN))
    label(last, f"RLS stands for a possible joint ({100.0 * np.mean(possible):.1f} % of the time)", "time (s)")
    panels[COEFFICIENTS[-1]].set_xlabel("time (s)")
    explain_looks(figure, [RLS, LEVEL, ONLINE, TRUE_LOOK])
    return figure


def _limits(values: Array, *shown: float) -> tuple[float, float]:
    """Return limits of an axis that shows most of the values, and what must be seen."""
    low, high = np.quantile(values, QUANTILES)
    low, high = min(low, *shown), max(high, *shown)
    return low - 0.15 * (high - low), high + 0.15 * (high - low)
