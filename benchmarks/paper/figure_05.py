"""Fig. 5: simulated velocity and its online prediction, and how both recursive estimators converge."""

from typing import NamedTuple

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from adaptive_ff.friction.model import ESTIMATED
from adaptive_ff.learning.batch_least_squares import Array
from adaptive_ff.report.style import QUIET, STYLE
from benchmarks.paper.drawing import GUIDE, NAIVE, SERIES, TORQUE_FORM, TRUTH, Look, label, legend, panels
from benchmarks.paper.identification_data import PERIOD, TRUE, Data

SHOWN = 10.0  # s
PAPER_TRANSIENT = 4.0  # s
WINDOW = 50  # samples of the running rms error
SERIES_LOOK: Look = {**SERIES, "label": "series (4), RLS"}
FORM_LOOK: Look = {**TORQUE_FORM, "label": "torque form, online"}
FREE: Look = {"linestyle": (0, (4, 2)), "linewidth": 0.9}


class Online(NamedTuple):
    """What the recursive estimators did.

    Attributes
    ----------
    series_errors : ndarray, shape (n,)
        One-step prediction errors of RLS, rad/s.
    series : ndarray, shape (n, 5)
        Physical parameters that the coefficients stand for; not a number where they stand for none.
    series_free : ndarray, shape (n,)
        Errors of the free run of the last estimate of RLS, rad/s.
    form_errors : ndarray, shape (n,)
        One-step prediction errors of the torque form, simulated, rad/s.
    form_free : ndarray, shape (n,)
        Errors of the free run of the last estimate of the torque form, rad/s.
    form : ndarray, shape (n, 5)
        Physical parameters by the torque form.
    """

    series_errors: Array
    series_free: Array
    series: Array
    form_errors: Array
    form_free: Array
    form: Array


def draw(data: Data, online: Online) -> Figure:
    """Draw the online prediction, its error and the worst parameter of both estimators over time."""
    part = data.time <= SHOWN
    time = data.time[part]
    with rc_context(STYLE):
        figure, (velocity, error, parameters) = panels((1.0, 1.0, 0.9), 7.4)
        velocity.plot(time, data.velocity[part], **TRUTH)
        velocity.plot(time, (data.velocity - online.series_errors)[part], **SERIES_LOOK)
        label(velocity, "velocity (rad/s): simulated, and predicted one sample ahead")
        naive = np.append(0.0, np.diff(data.velocity))
        for errors, look in ((naive, NAIVE), (online.series_errors, SERIES_LOOK), (online.form_errors, FORM_LOOK)):
            error.plot(time, 1e3 * running_rms(errors)[part], **look)
        for errors, look in ((online.series_free, SERIES_LOOK), (online.form_free, FORM_LOOK)):
            error.plot(time, 1e3 * running_rms(errors)[part], **{**look, **FREE})
        error.set_yscale("log")
        error.set_ylim(0.02, 300.0)
        label(
            error,
            f"error (mrad/s), rms of {WINDOW * PERIOD:g} s: one step ahead, and free run of the last estimate (dashed)",
        )
        true = np.array([getattr(TRUE, name) for name in ESTIMATED])
        for estimates, look in ((online.series, SERIES_LOOK), (online.form, FORM_LOOK)):
            worst = 100.0 * np.max(np.abs(estimates / true - 1.0), axis=1)
            parameters.plot(time, worst[part], **look)
        parameters.set_yscale("log")
        parameters.set_ylim(0.5, 1000.0)
        label(parameters, "deviation of the worst of the five parameters (%)", "time (s)")
        _finish((velocity, error, parameters))
        note = {"xytext": (4.0, -8.0), "textcoords": "offset points", "fontsize": 8.0, "color": QUIET}
        top = 1.3 * velocity.get_ylim()[1]
        velocity.set_ylim(top=top)
        velocity.annotate("the paper's transients have vanished", (PAPER_TRANSIENT, top), **note)
        legend(figure, [TRUTH, SERIES_LOOK, FORM_LOOK, NAIVE])
    return figure


def running_rms(errors: Array) -> Array:
    """Return the rms over the last samples before each."""
    sums = np.convolve(errors**2, np.ones(WINDOW))[: errors.size]
    counts = np.minimum(np.arange(errors.size) + 1, WINDOW)
    smoothed: Array = np.sqrt(sums / counts)
    return smoothed


def _finish(axes: tuple[Axes, ...]) -> None:
    for panel in axes:
        panel.set_xlim(0.0, SHOWN)
        panel.axvline(PAPER_TRANSIENT, **GUIDE)
        if panel.get_yscale() == "log":
            panel.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    for panel in axes[:-1]:
        panel.tick_params(labelbottom=False)
