"""Fig. 7: the torque ``K i`` that was applied, with close-ups of its steps."""

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from adaptive_ff.report.style import QUIET, STYLE, WIDTH
from benchmarks.paper.drawing import Look, label
from benchmarks.paper.robot import CURRENT_STEP, TORQUE_CONSTANT, Drive

LENGTHS = (6.0, 0.6)  # s, of the close-ups
TORQUE: Look = {"color": "#0072b2", "linewidth": 0.9, "drawstyle": "steps-post"}
SHADE = "#f0f0f0"


def draw(record: Drive) -> Figure:
    """Draw the torque over the whole record, and two close-ups around the reversal nearest to its middle."""
    reversals = record.time[1:][np.diff(np.sign(record.reference)) != 0.0]
    middle = float(reversals[np.argmin(np.abs(reversals - 0.5 * record.time[-1]))])
    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 4.6), layout="constrained")
        figure.get_layout_engine().set(h_pad=0.08)
        axes = figure.subplot_mosaic([["wide", "close"], ["whole", "whole"]])
        for name, length in zip(("wide", "close"), LENGTHS, strict=True):
            start, end = middle - 0.5 * length, middle + 0.5 * length
            part = (record.time >= start - 0.05) & (record.time <= end + 0.05)
            axes[name].plot(record.time[part], record.commanded[part], **TORQUE)
            axes[name].set_xlim(start, end)
            label(axes[name], f"torque (N m), {length:g} s of it", "time (s)")
        close = axes["close"]
        part = np.abs(record.time - middle) <= 0.5 * LENGTHS[1]
        close.plot(record.time[part], record.commanded[part], ".", color=QUIET, markersize=5.0)
        close.annotate(
            f"steps of {TORQUE_CONSTANT * CURRENT_STEP:g} N m = {TORQUE_CONSTANT:g} N m/A × {1e3 * CURRENT_STEP:g} mA",
            (0.03, 0.9),
            xycoords="axes fraction",
            color=QUIET,
            fontsize=8.0,
        )
        axes["whole"].plot(record.time, record.commanded, **{**TORQUE, "linewidth": 0.6})
        axes["whole"].axvspan(middle - 0.5 * LENGTHS[0], middle + 0.5 * LENGTHS[0], color=SHADE, zorder=0.4)
        axes["wide"].axvspan(middle - 0.5 * LENGTHS[1], middle + 0.5 * LENGTHS[1], color=SHADE, zorder=0.4)
        axes["whole"].set_xlim(0.0, record.time[-1])
        label(axes["whole"], "torque (N m), whole record; the close-ups are shaded", "time (s)")
    return figure
