"""Figs 7 and 9 to 12: what is drawn of the robot's record, and of what each way of identification makes of it."""

from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from adaptive_ff.friction.model import ESTIMATED, UNITS
from adaptive_ff.learning.series import COEFFICIENTS, series_coefficients
from adaptive_ff.report.style import QUIET, STYLE, Panel, explain_looks, picture
from benchmarks.paper.data import SYMBOLS, TRUE, TRUTH_VALUES
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
from benchmarks.paper.robot import CYCLE, NOISE, PERIOD, Drive
from benchmarks.paper.watching import FORGETTING, Form, Series, is_possible, physical_series

CLOSE_UP = 6.0  # s
FIRST_SECONDS = 6.0  # s, of Fig. 10
SHOWN = (60.0, 75.0)  # s, of Figs 9 and 11
ONLINE_SHOWN = 60.0  # s, of Fig. 12
WINDOW = 90  # samples of the running rms, about 2 s
LARGEST = 0.5  # rad/s, of what is drawn
QUANTILES = (0.05, 0.95)  # between these the coefficients decide what is drawn

TORQUE: Look = {"color": "#0072b2", "linewidth": 0.9, "drawstyle": "steps-post", "label": "torque"}
MEASURED: Look = {**TRUTH, "label": "measured"}
OFFLINE: Look = {**SERIES, "label": "series (4), offline LS"}
FORM: Look = {**TORQUE_FORM, "label": "torque form, simulated"}
PRIOR: Look = {"color": "#cc79a7", "linewidth": 1.0, "label": f"RLS, lambda {FORGETTING:g}, a-priori"}
POSTERIOR: Look = {"color": "#0072b2", "linewidth": 1.0, "label": "RLS, a-posteriori"}
FLOOR: Look = {**TRUE_LOOK, "label": "noise of the sensor"}
RLS: Look = {**SERIES, "linewidth": 0.6, "label": f"series (4), RLS, lambda {FORGETTING:g}"}
LEVEL: Look = {"color": "#0072b2", "linewidth": 1.2, "linestyle": (0, (5, 2)), "label": "series (4), offline LS"}
ONLINE: Look = {**TORQUE_FORM, "linewidth": 1.4, "label": "torque form, online"}


def figure_07(record: Drive) -> Figure:
    """Draw the torque around the reversal nearest to the middle of the record, and over the whole record."""
    reversals = record.time[1:][np.diff(np.sign(record.reference)) != 0.0]
    middle = float(reversals[np.argmin(np.abs(reversals - 0.5 * record.time[-1]))])
    curves: list[Any] = [(record.time, record.commanded, TORQUE)]
    panels = [
        Panel("torque (N m) around a reversal", curves, span=(middle - 0.5 * CLOSE_UP, middle + 0.5 * CLOSE_UP)),
        Panel("torque (N m), whole record", curves, span=(0.0, float(record.time[-1]))),
    ]
    return picture(panels, 4.6, shared=False)[0]


def figure_09(record: Drive, series: Series, form: Form) -> Figure:
    """Draw the prediction of the offline fit one sample ahead, its error, and its free run."""
    part = (record.time >= SHOWN[0]) & (record.time <= SHOWN[1])
    time, velocity, offline = record.time[part], record.velocity[part], series.errors["offline"][part]
    free, simulated = series.errors["free"][part], form.errors["free"][part]
    titles: dict[str, list[Any]] = {
        "velocity (rad/s): measured, and predicted one sample ahead by the offline fit": [
            (time, velocity, MEASURED),
            (time, velocity - offline, OFFLINE),
        ],
        "error of the prediction one sample ahead (mrad/s)": [
            (time, 1e3 * offline, OFFLINE),
            (time, 1e3 * form.errors["online"][part], FORM),
        ],
        "velocity (rad/s): measured, and free run from the recorded torque": [
            (time, velocity, MEASURED),
            (time, velocity - free, OFFLINE),
            (time, velocity - simulated, FORM),
        ],
    }
    return picture([Panel(name, curves, [(0.0, GUIDE)], SHOWN) for name, curves in titles.items()], 7.2)[0]


@rc_context(STYLE)
def figure_10(record: Drive) -> Figure:
    """Draw the sampling times of the first seconds, and how often each occurs in the whole record."""
    durations, ends = 1e3 * np.diff(record.time), record.time[1:]
    figure, axes = canvas([["times", "counts"]], 2.9, sharey=True, width_ratios=(3.2, 1.0))
    axes["times"].plot(ends[ends <= FIRST_SECONDS], durations[ends <= FIRST_SECONDS], ".", color=QUIET, markersize=4.0)
    axes["times"].axhline(float(np.mean(durations)), **TRUE_LOOK)
    axes["times"].set(xlim=(0.0, FIRST_SECONDS), ylim=(0.0, 1.12 * float(durations.max())))
    label(axes["times"], f"sampling time (ms), mean dashed; repeats every {CYCLE} samples", "time (s)")
    lengths, numbers = np.unique(np.round(durations), return_counts=True)
    axes["counts"].barh(lengths, 100.0 * numbers / durations.size, height=1.6, color=QUIET)
    label(axes["counts"], "how often", "fraction of samples (%)")
    return figure


def figure_11(record: Drive, series: Series, form: Form) -> Figure:
    """Draw both "predictions" of RLS in a close-up, and running errors of everything over the whole record."""
    part = (record.time >= SHOWN[0]) & (record.time <= SHOWN[1])
    time, velocity = record.time[part], record.velocity[part]
    titles = {
        "velocity (rad/s): with the coefficients of the sample before, (10)": ("prior", PRIOR),
        "velocity (rad/s): with coefficients that know the sample": ("posterior", POSTERIOR),
    }
    named = (
        (series.errors["prior"], PRIOR),
        (series.errors["offline"], OFFLINE),
        (form.errors["online"], FORM),
        (series.errors["posterior"], POSTERIOR),
    )
    running = [(record.time, 1e3 * running_rms(values, WINDOW), look) for values, look in named]
    panels = [
        Panel(
            title,
            [(time, velocity, MEASURED), (time, velocity - series.errors[name][part], look)],
            span=SHOWN,
            limits=(-LARGEST, LARGEST),
        )
        for title, (name, look) in titles.items()
    ]
    span, limits = (0.0, float(record.time[-1])), (0.5, 1.5 * float(running[0][1].max()))
    panels.append(Panel("error (mrad/s), rms of about 2 s", running, [(1e3 * NOISE, FLOOR)], span, limits))
    figure, axes = picture(panels, 7.6, shared=False)
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
        shown = np.append(
            np.quantile(coefficients[time > 0.1 * ONLINE_SHOWN, place], QUANTILES), (true[place], offline)
        )
        axes.set_ylim(np.min(shown) - 0.15 * np.ptp(shown), np.max(shown) + 0.15 * np.ptp(shown))
        label(axes, f"{name} (SI units)")
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
