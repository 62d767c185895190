"""Figs 3, 4, 5 and 8: what is drawn of the open loop and of the Stribeck curve."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from adaptive_ff.friction.model import ESTIMATED, model_friction
from adaptive_ff.learning.batch import Identification
from adaptive_ff.learning.stribeck import StribeckFit
from adaptive_ff.learning.support_points import SupportPoints
from adaptive_ff.report.style import INK, STYLE, Panel, explain_looks, picture
from benchmarks.paper.data import PERIOD, SYMBOLS, TRUE, Array, Data
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
from benchmarks.paper.identification import Online, model_free_run, series_free_run

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


def figure_04(data: Data, plain: Identification, sliding: Identification, form: Identification) -> Figure:
    """Draw the response of the fits, their error, and the parameters they stand for.

    The fits are those by (4) from all samples and from sliding ones, with the torque over (k-1, k], and by the torque
    form.
    """
    part = (data.time >= RESPONSE[0]) & (data.time <= RESPONSE[1])
    time, velocity = data.time[part], data.velocity[part]
    series = [series_free_run(fit.regression.values, data.velocity, data.acting)[part] for fit in (plain, sliding)]
    responses = [*series, model_free_run(form.model, data)[part]]
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


def figure_05(data: Data, online: Online) -> Figure:
    """Draw the online prediction, its error and the worst parameter of both estimators over time."""
    part = data.time <= SHOWN[1]
    time, true = data.time[part], np.array([getattr(TRUE, name) for name in ESTIMATED])

    def error(values: Array, look: Look) -> tuple[Array, Array, Look]:
        return time, 1e3 * running_rms(values, WINDOW)[part], look

    def worst(estimates: Array, look: Look) -> tuple[Array, Array, Look]:
        return time, 100.0 * np.max(np.abs(estimates / true - 1.0), axis=1)[part], look

    moment = f"rms of {WINDOW * PERIOD:g} s: one step ahead, and free run of the last estimate (dashed)"
    predicted = (data.velocity - online.series_errors)[part]
    errors = [
        error(np.append(0.0, np.diff(data.velocity)), NAIVE),
        error(online.series_errors, RLS),
        error(online.form_errors, ONLINE),
        error(online.series_free, {**RLS, **FREE}),
        error(online.form_free, {**ONLINE, **FREE}),
    ]
    panels = [
        Panel(
            "velocity (rad/s): simulated, and predicted one sample ahead",
            [(time, data.velocity[part], TRUTH), (time, predicted, RLS)],
            span=SHOWN,
        ),
        Panel(f"error (mrad/s), {moment}", errors, limits=(0.02, 300.0)),
        Panel(
            "deviation of the worst of the five parameters (%)",
            [worst(online.series, RLS), worst(online.form, ONLINE)],
            limits=(0.5, 1000.0),
        ),
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
