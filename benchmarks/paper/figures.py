"""What is drawn: Figs 3 to 5 and 8 of the open loop and the Stribeck curve, Figs 7 and 9 to 12 of the robot."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MultipleLocator

from adaptive_ff.friction.model import ESTIMATED, UNITS, model_friction
from adaptive_ff.learning.batch import Identification
from adaptive_ff.learning.series import COEFFICIENTS, series_coefficients
from adaptive_ff.learning.stribeck import StribeckFit
from adaptive_ff.learning.support_points import SupportPoints
from adaptive_ff.report.comparison_pictures import LOOKS
from adaptive_ff.report.style import INK, QUIET, STYLE, WIDTH, Panel, explain_looks, label_above, picture
from benchmarks.paper.estimators import Form, Series, is_possible, physical_series, series_free_run
from benchmarks.paper.experiment import SYMBOLS
from benchmarks.paper.records import (
    CYCLE,
    FORGETTING,
    NOISE,
    PERIOD,
    ROBOT_PERIOD,
    TRUE,
    TRUTH_VALUES,
    Array,
    Record,
    predict,
)

Look = Mapping[str, Any]

TRUTH: Look = {"color": "#b5b5b5", "linewidth": 2.6, "label": "simulated joint"}
SERIES: Look = {"color": LOOKS["adaptive_paper"]["color"], "linewidth": 1.1, "label": "series (4)"}
TORQUE_FORM: Look = {"color": LOOKS["adaptive"]["color"], "linewidth": 1.1, "label": "torque form"}
TRUE_LOOK: Look = {"color": INK, "linewidth": 1.0, "linestyle": (0, (2, 2)), "zorder": 3.0, "label": "true"}
GUIDE: Look = {"color": QUIET, "linewidth": 0.9, "linestyle": (0, (2, 2)), "zorder": 1.5}


def canvas(layout: list[list[str]], height: float, **more: Any) -> tuple[Figure, dict[str, Axes]]:
    """Return a figure of named panels; the height is in inches."""
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    return figure, figure.subplot_mosaic(layout, **more)


def label(axes: Axes, text: str, xlabel: str = "") -> None:
    """Label the vertical axis above it, and the horizontal one."""
    label_above(axes, text)
    axes.set_xlabel(xlabel)


def plain_numbers(axis: Axis) -> None:
    """Write the numbers of an axis without powers of ten."""
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def running_rms(errors: Array, window: int) -> Array:
    """Return the rms over the last samples before each."""
    sums = np.convolve(errors**2, np.ones(window))[: errors.size]
    return np.asarray(np.sqrt(sums / np.minimum(np.arange(errors.size) + 1, window)))


DOTS: Look = {"marker": "o", "markersize": 3.5}

# Figs 4 and 5
RESPONSE, SHOWN = (10.0, 22.0), (0.0, 10.0)  # s
PAPER_TRANSIENT = 4.0  # s
WINDOW = 50  # samples of the running rms error
PLAIN: Look = {**SERIES, "label": "series (4), all samples, as in the paper"}
SLIDING: Look = {**SERIES, "color": "#0072b2", "label": "series (4), sliding samples only"}
GATED: Look = {**TORQUE_FORM, "label": "torque form with gate"}
RLS: Look = {**SERIES, "label": "series (4), RLS"}
ONLINE: Look = {**TORQUE_FORM, "label": "torque form, online"}
NAIVE: Look = {"color": "#a6a6a6", "linewidth": 1.2, "label": "naive predictor w(k-1)"}
FREE: Look = {"linestyle": (0, (4, 2)), "linewidth": 0.9, "label": ""}

# Fig. 8
SPREAD: Look = {"color": "#9ec5e0", "linewidth": 3.0, "label": "spread of the readings"}
MEAN: Look = {"color": "#0072b2", "marker": "o", "markersize": 2.6, "linestyle": "", "label": "mean of the readings"}
FITTED: Look = {**TORQUE_FORM, "linewidth": 1.3, "label": "fitted curve"}


@rc_context(STYLE)
def figure_03(speeds: list[float], found: Sequence[Any]) -> Figure:
    """Draw how the one-step error of (4) depends on reversal speed (rad/s^2): its parts, and its size on reversals."""
    figure, axes = canvas([["parts", "sizes"]], 3.6)
    for kind in found[0].fractions:
        axes["parts"].plot(speeds, [100.0 * one.fractions[kind] for one in found], **DOTS, label=kind)
    axes["parts"].set_ylim(0.0, 100.0)
    label(axes["parts"], "fraction of the squared one-step error of (4) (%)", "reversal speed (rad/s²)")
    for values, look in (
        ([one.sizes["reversal"] for one in found], {**SERIES, "label": "(4), sign of w(k-1)"}),
        ([one.form for one in found], {**TORQUE_FORM, "label": "torque form, simulated"}),
    ):
        axes["sizes"].plot(speeds, 1e3 * np.array(values), **{**look, **DOTS})
    axes["sizes"].set(yscale="log")
    plain_numbers(axes["sizes"].yaxis)
    label(axes["sizes"], "one-step error on reversals (mrad/s rms)", "reversal speed (rad/s²)")
    for one in axes.values():
        one.legend(fontsize=8.0)
    return figure


def figure_04(data: Record, plain: Identification, sliding: Identification, form: Identification) -> Figure:
    """Draw the response of the fits, their error, and the parameters they stand for.

    The fits are those by (4) from all samples and from sliding ones, with the torque over (k-1, k], and by the torque
    form.
    """
    part = (data.time >= RESPONSE[0]) & (data.time <= RESPONSE[1])
    time, velocity = data.time[part], data.velocity[part]
    series = [series_free_run(fit.regression.values, data.velocity, data.acting)[part] for fit in (plain, sliding)]
    responses = [*series, predict(form.model, data, one_step=False)[part]]
    looks = (PLAIN, SLIDING, GATED)
    errors = [(time, 1e3 * (one - velocity), look) for one, look in zip(responses, looks, strict=True)]
    panels = [
        Panel(
            "velocity (rad/s): simulated, and free run of the paper's fit",
            [(time, velocity, TRUTH), (time, responses[0], PLAIN)],
            span=RESPONSE,
        ),
        Panel("error of the free run (mrad/s)", errors, span=RESPONSE),
        Panel("identified parameter", []),
    ]
    figure, axes = picture(panels, 7.4, "deviation from the truth (%), with the fit's own 95 % interval", shared=False)
    axes[1].set_xlabel("time (s)")
    _draw_parameters(axes[2], list(zip((plain, sliding, form), looks, strict=True)))
    return figure


def _draw_parameters(axes: Axes, fits: Sequence[tuple[Identification, Look]]) -> None:
    """Draw the deviation of each parameter from the truth, with its interval."""
    axes.axvline(0.0, **GUIDE)
    for shift, (fit, look) in zip((-0.25, 0.03, 0.31), fits, strict=True):
        for place, (name, estimate) in enumerate(fit.physical.items()):
            true, height, colour = getattr(TRUE, name), place + shift, {"color": look["color"]}
            low, value, high = (100.0 * (end / true - 1.0) for end in (estimate.lower, estimate.value, estimate.upper))
            axes.plot([low, high], [height] * 2, linewidth=2.0, **colour)
            axes.plot([value], [height], "o", markersize=4.0, **colour)
    axes.set_xscale("symlog", linthresh=1.0, linscale=0.7)
    axes.set(ylim=(len(SYMBOLS) - 0.5, -0.5), xticks=[-30, -10, -3, -1, 0, 1, 3, 10])
    axes.set_yticks(range(len(SYMBOLS)), list(SYMBOLS.values()))
    plain_numbers(axes.xaxis)
    axes.grid(axis="y", visible=False)


def figure_05(data: Record, series: Series, form: Form) -> Figure:
    """Draw the online prediction, its error and the worst parameter of both estimators over time."""
    part = data.time <= SHOWN[1]
    time, (found, formed) = data.time[part], (series.errors, form.errors)
    named = (
        (np.append(0.0, np.diff(data.velocity)), NAIVE),
        (found["prior"], RLS),
        (formed["prior"], ONLINE),
        (found["last"], {**RLS, **FREE}),
        (formed["free"], {**ONLINE, **FREE}),
    )
    errors = [(time, 1e3 * running_rms(values, WINDOW)[part], look) for values, look in named]
    estimates = ((physical_series(series.coefficients, PERIOD), RLS), (form.estimates, ONLINE))
    worst = [
        (time, 100.0 * np.max(np.abs(values / TRUTH_VALUES - 1.0), axis=1)[part], look) for values, look in estimates
    ]
    moment = f"rms of {WINDOW * PERIOD:g} s: one step ahead, and free run of the last estimate (dashed)"
    curves = [(time, data.velocity[part], TRUTH), (time, (data.velocity - found["prior"])[part], RLS)]
    panels = [
        Panel("velocity (rad/s): simulated, and predicted one sample ahead", curves, span=SHOWN),
        Panel(f"error (mrad/s), {moment}", errors, limits=(0.02, 300.0)),
        Panel("deviation of the worst of the five parameters (%)", worst, limits=(0.5, 1000.0)),
    ]
    figure, axes = picture(panels, 7.4)
    for panel in axes:
        panel.axvline(PAPER_TRANSIENT, **GUIDE)
    for panel in axes[1:]:
        panel.set_yscale("log")
        plain_numbers(panel.yaxis)
    return figure


@rc_context(STYLE)
def figure_08(points: SupportPoints, fit: StribeckFit, fits: Sequence[StribeckFit]) -> Figure:
    """Draw the points of the drives with their curve, what it leaves of them, and the estimates of the study."""
    figure, axes = canvas([["backward", "forward"], ["rest", "study"]], 6.6)
    for name, side in (("backward", -1.0), ("forward", 1.0)):
        _draw_curve(axes[name], side, points, fit)
        label(axes[name], f"friction torque (N m), drives {name}", "velocity (rad/s)")
    rest, study = axes["rest"], axes["study"]
    rest.axhline(0.0, **FITTED)
    rest.errorbar(np.abs(points.velocity), fit.residuals, 2.0 * points.standard_error, **MEAN, elinewidth=0.8)
    rest.set_xscale("log")
    plain_numbers(rest.xaxis)
    label(rest, "mean − fitted torque (N m), ± 2 standard errors", "speed (rad/s)")
    speeds, shapes = np.array([(one.stribeck_velocity, one.stribeck_shape) for one in fits]).T
    study.plot(1e3 * speeds, shapes, ".", color="#7b5aa6", markersize=3.0, alpha=0.5)
    centre = np.array([1e3 * TRUE.stribeck_velocity, TRUE.stribeck_shape])
    study.axvline(centre[0], **TRUE_LOOK)
    study.axhline(centre[1], **TRUE_LOOK)
    box = centre * [(0.9, 0.9), (1.1, 0.9), (1.1, 1.1), (0.9, 1.1), (0.9, 0.9)]
    study.plot(*box.T, color=INK, linewidth=0.9)
    label(study, f"delta over Vs, {len(fits)} seeds; box: 10 % of the truth", "Vs (mrad/s)")
    explain_looks(figure, [SPREAD, MEAN, FITTED, TRUE_LOOK])
    return figure


def _draw_curve(axes: Axes, side: float, points: SupportPoints, fit: StribeckFit) -> None:
    """Draw the points of one direction, and the curve that was fitted to both."""
    part = side * points.velocity > 0.0
    velocity, torque, spread = points.velocity[part], points.torque[part], points.spread[part]
    axes.vlines(velocity, torque - spread, torque + spread, colors=SPREAD["color"], linewidth=SPREAD["linewidth"])
    axes.plot(velocity, torque, **MEAN)
    fastest = float(np.max(np.abs(velocity)))
    speeds = fastest * np.linspace(1e-3, 1.03, 400) ** 2
    axes.plot(side * speeds, fit.curve(side * speeds) + fit.estimates["offset"].value, **FITTED)
    axes.plot(side * speeds, [side * model_friction(TRUE, speed) for speed in speeds], **TRUE_LOOK)
    axes.set_xlim(*sorted((0.0, 1.06 * side * fastest)))
    axes.xaxis.set_major_locator(MultipleLocator(0.1))


# Figs 7 and 9 to 12
CLOSE_UP = 6.0  # s
FIRST_SECONDS = 6.0  # s, of Fig. 10
LATER = (60.0, 75.0)  # s, of Figs 9 and 11
ONLINE_SHOWN = 60.0  # s, of Fig. 12
LONG_WINDOW = 90  # samples of the running rms, about 2 s
LARGEST = 0.5  # rad/s, of what is drawn
QUANTILES = (0.05, 0.95)  # between these the coefficients decide what is drawn
TORQUE: Look = {"color": "#0072b2", "linewidth": 0.9, "drawstyle": "steps-post", "label": "torque"}
MEASURED: Look = {**TRUTH, "label": "measured"}
OFFLINE: Look = {**SERIES, "label": "series (4), offline LS"}
FORM: Look = {**TORQUE_FORM, "label": "torque form, simulated"}
PRIOR: Look = {"color": "#cc79a7", "linewidth": 1.0, "label": f"RLS, lambda {FORGETTING:g}, a-priori"}
POSTERIOR: Look = {"color": "#0072b2", "linewidth": 1.0, "label": "RLS, a-posteriori"}
FLOOR: Look = {**TRUE_LOOK, "label": "noise of the sensor"}
THIN: Look = {**RLS, "linewidth": 0.6, "label": f"series (4), RLS, lambda {FORGETTING:g}"}
LEVEL: Look = {"color": "#0072b2", "linewidth": 1.2, "linestyle": (0, (5, 2)), "label": "series (4), offline LS"}
THICK: Look = {**TORQUE_FORM, "linewidth": 1.4, "label": "torque form, online"}


def figure_07(record: Record, *_: Any) -> Figure:
    """Draw the torque around the reversal nearest to the middle of the record, and over the whole record."""
    reversals = record.time[1:][np.diff(np.sign(record.reference[record.steps])) != 0.0]
    middle = float(reversals[np.argmin(np.abs(reversals - 0.5 * record.time[-1]))])
    curves: list[Any] = [(record.time, record.commanded, TORQUE)]
    panels = [
        Panel("torque (N m) around a reversal", curves, span=(middle - 0.5 * CLOSE_UP, middle + 0.5 * CLOSE_UP)),
        Panel("torque (N m), whole record", curves, span=(0.0, float(record.time[-1]))),
    ]
    return picture(panels, 4.6, shared=False)[0]


def figure_09(record: Record, series: Series, form: Form) -> Figure:
    """Draw the prediction of the offline fit one sample ahead, its error, and its free run."""
    part = (record.time >= LATER[0]) & (record.time <= LATER[1])
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
    return picture([Panel(name, curves, [(0.0, GUIDE)], LATER) for name, curves in titles.items()], 7.2)[0]


@rc_context(STYLE)
def figure_10(record: Record, *_: Any) -> Figure:
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


def figure_11(record: Record, series: Series, form: Form) -> Figure:
    """Draw both "predictions" of RLS in a close-up, and running errors of everything over the whole record."""
    part = (record.time >= LATER[0]) & (record.time <= LATER[1])
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
    running = [(record.time, 1e3 * running_rms(values, LONG_WINDOW), look) for values, look in named]
    panels = [
        Panel(
            title,
            [(time, velocity, MEASURED), (time, velocity - series.errors[name][part], look)],
            span=LATER,
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
def figure_12(record: Record, series: Series, form: Form) -> Figure:
    """Draw the six coefficients on the left, the five physical parameters on the right."""
    part = record.time <= ONLINE_SHOWN
    time, coefficients = record.time[part], series.coefficients[part]
    physical, true = physical_series(coefficients, ROBOT_PERIOD), np.array(series_coefficients(TRUE, ROBOT_PERIOD))
    rows = [[name, other] for name, other in zip(COEFFICIENTS, (*ESTIMATED, "possible"), strict=True)]
    figure, panels = canvas(rows, 8.6, sharex=True)
    for place, name in enumerate(COEFFICIENTS):
        axes, offline = panels[name], float(series.offline.values[place])
        axes.plot(time, coefficients[:, place], **THIN)
        axes.axhline(offline, **LEVEL)
        axes.axhline(true[place], **TRUE_LOOK)
        often = np.quantile(coefficients[time > 0.1 * ONLINE_SHOWN, place], QUANTILES)
        shown = np.append(often, (true[place], offline))
        axes.set_ylim(np.min(shown) - 0.15 * np.ptp(shown), np.max(shown) + 0.15 * np.ptp(shown))
        label(axes, f"{name} (SI units)")
    for place, name in enumerate(ESTIMATED):
        axes = panels[name]
        axes.plot(time, physical[:, place], **THIN)
        axes.plot(time, form.estimates[part][:, place], **THICK)
        axes.axhline(TRUTH_VALUES[place], **TRUE_LOOK)
        axes.set_ylim(TRUTH_VALUES[place] * np.array([-1.0, 3.0]))
        label(axes, f"{SYMBOLS[name]} ({UNITS[name]})")
    last, possible = panels["possible"], is_possible(physical)
    last.vlines(time[possible], 0.0, 1.0, color=THIN["color"], linewidth=0.6)
    last.set(ylim=(0.0, 1.0), yticks=[], xlim=(0.0, ONLINE_SHOWN))
    label(last, f"RLS stands for a possible joint ({100.0 * np.mean(possible):.1f} % of the time)", "time (s)")
    panels[COEFFICIENTS[-1]].set_xlabel("time (s)")
    explain_looks(figure, [THIN, LEVEL, THICK, TRUE_LOOK])
    return figure


OF_THE_ROBOT = (figure_07, figure_09, figure_10, figure_11, figure_12)
