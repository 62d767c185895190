"""Fig. 11: measured velocity and RLS with a short memory, before and after it has seen the sample."""

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from adaptive_ff.learning.batch import Array
from adaptive_ff.report.style import STYLE
from benchmarks.paper.drawing import SERIES, TORQUE_FORM, TRUTH, Look, label, legend, panels
from benchmarks.paper.robot import NOISE, Drive
from benchmarks.paper.watching import FORGETTING, Form, Series

SHOWN = (60.0, 75.0)  # s
WINDOW = 90  # samples of the running rms, about 2 s
LARGEST = 0.5  # rad/s, of what is drawn

MEASURED: Look = {**TRUTH, "label": "measured"}
PRIOR: Look = {"color": "#cc79a7", "linewidth": 1.0, "label": f"RLS, lambda {FORGETTING:g}, a-priori"}
POSTERIOR: Look = {"color": "#0072b2", "linewidth": 1.0, "label": "RLS, a-posteriori"}
OFFLINE: Look = {**SERIES, "label": "series (4), offline LS"}
FORM: Look = {**TORQUE_FORM, "label": "torque form, simulated"}
FLOOR: Look = {"color": "#222222", "linewidth": 0.9, "linestyle": (0, (2, 2)), "label": "noise of the sensor"}


def draw(record: Drive, series: Series, form: Form) -> Figure:
    """Draw both "predictions" of RLS in a close-up, and running errors of everything over the whole record."""
    part = (record.time >= SHOWN[0]) & (record.time <= SHOWN[1])
    time, velocity = record.time[part], record.velocity[part]
    with rc_context(STYLE):
        figure, (before, after, errors) = panels((1.0, 1.0, 1.1), 7.6)
        for axes, name, look in ((before, "prior", PRIOR), (after, "posterior", POSTERIOR)):
            axes.plot(time, velocity, **MEASURED)
            axes.plot(time, velocity - series.errors[name][part], **look)
            axes.set(xlim=SHOWN, ylim=limits(velocity, velocity - series.errors["prior"][part]))
        beyond = float(np.max(np.abs(velocity - series.errors["prior"][part])))
        more = f"; largest {beyond:.2f}" if beyond > LARGEST else ""
        label(before, f"velocity (rad/s): with the coefficients of the sample before, (10){more}")
        label(after, "velocity (rad/s): with coefficients that have already seen the sample", "time (s)")
        for values, look in (
            (series.errors["prior"], PRIOR),
            (series.errors["offline"], OFFLINE),
            (form.errors["online"], FORM),
            (series.errors["posterior"], POSTERIOR),
        ):
            errors.plot(record.time, 1e3 * running_rms(values), **look)
        errors.axhline(1e3 * NOISE, **FLOOR)
        errors.axvspan(*SHOWN, color="#f0f0f0", zorder=0.4)
        errors.set_yscale("log")
        errors.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        errors.set(xlim=(0.0, record.time[-1]), ylim=(0.5, 1.5e3 * float(running_rms(series.errors["prior"]).max())))
        label(errors, "error (mrad/s), rms of about 2 s; the close-up is shaded", "time (s)")
        before.tick_params(labelbottom=False)
        legend(figure, [MEASURED, PRIOR, POSTERIOR, OFFLINE, FORM, FLOOR])
    return figure


def limits(*values: Array) -> tuple[float, float]:
    """Return limits of an axis that shows values, but none beyond the largest that is drawn."""
    every = np.clip(np.concatenate(values), -LARGEST, LARGEST)
    margin = 0.06 * float(np.ptp(every))
    return float(every.min()) - margin, float(every.max()) + margin


def running_rms(errors: Array) -> Array:
    """Return the rms over the last samples before each."""
    sums = np.convolve(errors**2, np.ones(WINDOW))[: errors.size]
    counts = np.minimum(np.arange(errors.size) + 1, WINDOW)
    smoothed: Array = np.sqrt(sums / counts)
    return smoothed
