"""Picture of a study of bandwidths: error over bandwidth."""

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from adaptive_ff.report.comparison_plots import looks_of
from adaptive_ff.report.drawing import INK, STYLE, Look, explain_looks, label_above, make_panels
from adaptive_ff.report.scaling import scale_for
from adaptive_ff.scenario.axis_units import axis_unit
from adaptive_ff.studies.bandwidth_study import BandwidthStudy

NOISE: Look = {"color": INK, "linewidth": 0.9, "linestyle": (0, (1, 2)), "label": "noise alone"}
COMMON: Look = {"color": INK, "linewidth": 0.8, "linestyle": (0, (6, 2, 1, 2)), "label": "bandwidth of the scenario"}


def plot_bandwidths(study: BandwidthStudy) -> Figure:
    """Draw the settled error of each controller over the bandwidth of its loop, the best marked, and the margin.

    Parameters
    ----------
    study : BandwidthStudy
        The study; its errors on the seeds that bandwidths are chosen on are drawn.
    """
    unit = axis_unit(study.scenario.joint.axis, "rad/s")
    factor, speed = scale_for([error for one in study.own.values() for error in one.errors], unit)
    bandwidths = np.array([loop.bandwidth for loop in study.loops])
    looks = looks_of(list(study.own))
    with rc_context(STYLE):
        figure, (errors, margin) = make_panels(2, 6.0)
        for name, one in study.own.items():
            values = np.array([value if np.isfinite(value) else np.nan for value in one.errors])
            errors.plot(one.bandwidths, factor * values, **looks[name])
            errors.plot(one.best, factor * one.error, "o", color=looks[name]["color"], markersize=6.0, zorder=3.0)
        noise = np.array([loop.noise_velocity for loop in study.loops])
        if np.any(noise > 0.0):
            errors.plot(bandwidths, factor * noise, **NOISE)
        margin.plot(bandwidths, [loop.maximum_sensitivity for loop in study.loops], color=INK, linewidth=1.2)
        keys = [*looks.values(), *([NOISE] if np.any(noise > 0.0) else [])]
        feedback = study.scenario.feedback
        if not feedback.is_auto and np.isfinite(feedback.hertz):
            for axes in (errors, margin):
                axes.axvline(feedback.hertz, **{key: value for key, value in COMMON.items() if key != "label"})
            keys.append(COMMON)
        errors.set_yscale("log")
        margin.set_xscale("log")
        for axis in (errors.yaxis, margin.xaxis):
            axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            axis.set_minor_locator(NullLocator())
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        label_above(errors, f"settled rms error ({speed}); dots: the best")
        label_above(margin, "maximum sensitivity")
        margin.set_xlabel("bandwidth of the PI loop (Hz)")
        explain_looks(figure, keys)
    return figure
