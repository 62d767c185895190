"""Fig. 9: measured velocity and the offline fit, one step ahead and on its own."""

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from adaptive_ff.report.style import STYLE
from benchmarks.paper.drawing import GUIDE, SERIES, TORQUE_FORM, TRUTH, Look, label, legend, panels
from benchmarks.paper.robot import Drive
from benchmarks.paper.watching import Form, Series

SHOWN = (60.0, 75.0)  # s
LATE = 0.025  # s
MEASURED: Look = {**TRUTH, "label": "measured"}
OFFLINE: Look = {**SERIES, "label": "series (4), offline LS"}
FORM: Look = {**TORQUE_FORM, "label": "torque form, simulated"}
LATE_LOOK: Look = {"color": "#222222", "marker": "v", "markersize": 3.5, "linestyle": "", "label": "late sample"}


def draw(record: Drive, series: Series, form: Form) -> Figure:
    """Draw the prediction one sample ahead, its error, and the free run of the offline fit."""
    part = (record.time >= SHOWN[0]) & (record.time <= SHOWN[1])
    time, velocity = record.time[part], record.velocity[part]
    late = np.diff(record.time, prepend=0.0)[part] > LATE
    with rc_context(STYLE):
        figure, (ahead, error, free) = panels((1.0, 0.9, 1.0), 7.2)
        for axes, errors in ((ahead, series.errors["offline"]), (free, series.errors["free"])):
            axes.plot(time, velocity, **MEASURED)
            axes.plot(time, velocity - errors[part], **OFFLINE)
        free.plot(time, velocity - form.errors["free"][part], **FORM)
        for errors, look in ((series.errors["offline"], OFFLINE), (form.errors["online"], FORM)):
            error.plot(time, 1e3 * errors[part], **{**look, "linewidth": 0.9})
        bottom = 1e3 * float(np.min(series.errors["offline"][part])) - 4.0
        error.plot(time[late], np.full(np.count_nonzero(late), bottom), **LATE_LOOK)
        for axes in (ahead, error, free):
            axes.axhline(0.0, **{**GUIDE, "linestyle": "-", "linewidth": 0.6})
            axes.set_xlim(*SHOWN)
        for axes in (ahead, error):
            axes.tick_params(labelbottom=False)
        label(ahead, "velocity (rad/s): measured, and predicted one sample ahead by the offline fit")
        label(error, "error of the prediction one sample ahead (mrad/s)")
        label(free, "velocity (rad/s): measured, and free run from the recorded torque", "time (s)")
        legend(figure, [MEASURED, OFFLINE, FORM, LATE_LOOK])
    return figure
