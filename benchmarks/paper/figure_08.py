"""Fig. 8: the Stribeck curve over its support points, and the estimates of Vs and delta on many seeds."""

from collections.abc import Sequence

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MultipleLocator

from adaptive_ff.friction.model import model_friction
from adaptive_ff.learning.stribeck import StribeckFit
from adaptive_ff.learning.support_points import SupportPoints
from adaptive_ff.report.style import INK, STYLE, WIDTH
from benchmarks.paper.drawing import TORQUE_FORM, Look, label, legend
from benchmarks.paper.identification_data import TRUE

NAMES = {
    "coulomb": ("Fc", ", N m"),
    "stiction": ("Fs", ", N m"),
    "viscous": ("sigma", ", N m s/rad"),
    "stribeck_velocity": ("Vs", ", rad/s"),
    "stribeck_shape": ("delta", ""),
}
"""Symbols and units of the fitted parameters."""

SPREAD: Look = {"color": "#9ec5e0", "linewidth": 3.0, "label": "spread of the readings"}
MEAN: Look = {"color": "#0072b2", "marker": "o", "markersize": 2.6, "linestyle": "", "label": "mean of the readings"}
FITTED: Look = {**TORQUE_FORM, "linewidth": 1.3, "label": "fitted curve"}
TRUE_LOOK: Look = {"color": INK, "linewidth": 1.0, "linestyle": (0, (2, 2)), "zorder": 3.0, "label": "true"}


def draw(points: SupportPoints, fit: StribeckFit, fits: Sequence[StribeckFit]) -> Figure:
    """Draw the points of the drives with their curve, what it leaves of them, and the estimates of the study."""
    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 6.6), layout="constrained")
        figure.get_layout_engine().set(h_pad=0.08)
        axes = figure.subplot_mosaic([["backward", "forward"], ["rest", "study"]], height_ratios=(1.15, 1.0))
        for name, side in (("backward", -1.0), ("forward", 1.0)):
            _draw_curve(axes[name], name, side, points, fit)
        _draw_rest(axes["rest"], points, fit)
        _draw_study(axes["study"], fits)
        legend(figure, [SPREAD, MEAN, FITTED, TRUE_LOOK])
    return figure


def _draw_curve(axes: Axes, name: str, side: float, points: SupportPoints, fit: StribeckFit) -> None:
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
    label(axes, f"friction torque (N m), drives {name}", "velocity (rad/s)")


def _draw_rest(axes: Axes, points: SupportPoints, fit: StribeckFit) -> None:
    """Draw what the fit leaves of the points, over the speed."""
    speeds = np.abs(points.velocity)
    axes.axhline(0.0, **FITTED)
    axes.errorbar(speeds, fit.residuals, 2.0 * points.standard_error, **MEAN, elinewidth=0.8)
    axes.set_xscale("log")
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    label(axes, "mean − fitted torque (N m), ± 2 standard errors", "speed (rad/s)")


def _draw_study(axes: Axes, fits: Sequence[StribeckFit]) -> None:
    """Draw the estimates of Vs and delta, and the range within 10 % of the truth."""
    speeds, shapes = np.array([(one.stribeck_velocity, one.stribeck_shape) for one in fits]).T
    axes.plot(1e3 * speeds, shapes, ".", color="#7b5aa6", markersize=3.0, alpha=0.5)
    centre = (1e3 * TRUE.stribeck_velocity, TRUE.stribeck_shape)
    axes.axvline(centre[0], **TRUE_LOOK)
    axes.axhline(centre[1], **TRUE_LOOK)
    box = [(centre[0] * across, centre[1] * up) for across, up in ((0.9, 0.9), (1.1, 0.9), (1.1, 1.1), (0.9, 1.1))]
    axes.plot(*np.array([*box, box[0]]).T, color=INK, linewidth=0.9)
    label(axes, f"delta over Vs, {len(fits)} seeds; box: 10 % of the truth", "Vs (mrad/s)")
