"""Fig. 4: simulated velocity and the response of the offline fit, and what the fit says of the joint."""

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from adaptive_ff.learning.batch import Identification
from adaptive_ff.report.style import STYLE
from benchmarks.paper.drawing import GUIDE, SERIES, TORQUE_FORM, TRUTH, Look, label, legend, panels
from benchmarks.paper.identification_data import SYMBOLS, TRUE, Data
from benchmarks.paper.prediction import model_free_run, series_free_run

SHOWN = (10.0, 22.0)  # s
PLAIN_LOOK: Look = {**SERIES, "label": "series (4), all samples, as in the paper"}
SLIDING_LOOK: Look = {**SERIES, "color": "#0072b2", "label": "series (4), sliding samples only"}
FORM_LOOK: Look = {**TORQUE_FORM, "label": "torque form with gate"}


def draw(data: Data, plain: Identification, sliding: Identification, form: Identification) -> Figure:
    """Draw the response of the fits, their error, and the parameters they stand for.

    Parameters
    ----------
    data : Data
        The record.
    plain, sliding, form : Identification
        Fits by (4) from all samples and from sliding ones, with the torque over (k-1, k], and by the torque form.
    """
    responses = {
        "plain": series_free_run(plain.regression.values, data.velocity, data.acting),
        "sliding": series_free_run(sliding.regression.values, data.velocity, data.acting),
        "form": model_free_run(form.model, data),
    }
    looks = {"plain": PLAIN_LOOK, "sliding": SLIDING_LOOK, "form": FORM_LOOK}
    part = (data.time >= SHOWN[0]) & (data.time <= SHOWN[1])
    with rc_context(STYLE):
        figure, (velocity, error, parameters) = panels((1.0, 0.8, 1.1), 7.4)
        velocity.plot(data.time[part], data.velocity[part], **TRUTH)
        velocity.plot(data.time[part], responses["plain"][part], **PLAIN_LOOK)
        for name, response in responses.items():
            error.plot(data.time[part], 1e3 * (response - data.velocity)[part], **looks[name])
        label(velocity, "velocity (rad/s): simulated, and free run of the paper's fit")
        label(error, "error of the free run (mrad/s)", "time (s)")
        for axes in (velocity, error):
            axes.set_xlim(*SHOWN)
        velocity.tick_params(labelbottom=False)
        _draw_parameters(parameters, ((plain, PLAIN_LOOK), (sliding, SLIDING_LOOK), (form, FORM_LOOK)))
        legend(figure, [TRUTH, *looks.values()])
    return figure


def _draw_parameters(axes: Axes, fits: tuple[tuple[Identification, Look], ...]) -> None:
    """Draw the deviation of each parameter from the truth, with its interval."""
    axes.axvline(0.0, **GUIDE)
    for shift, (fit, look) in zip((-0.25, 0.03, 0.31), fits, strict=True):
        for place, (name, estimate) in enumerate(fit.physical.items()):
            true = getattr(TRUE, name)
            low, value, high = (100.0 * (end / true - 1.0) for end in (estimate.lower, estimate.value, estimate.upper))
            axes.plot([low, high], [place + shift] * 2, color=look["color"], linewidth=2.0)
            axes.plot([value], [place + shift], "o", color=look["color"], markersize=4.0)
            side, end = ("right", low) if value < 0.0 else ("left", high)
            axes.annotate(
                f"{value:+.1f}",
                (end, place + shift),
                xytext=(-5.0 if side == "right" else 5.0, 0.0),
                textcoords="offset points",
                horizontalalignment=side,
                verticalalignment="center",
                color=look["color"],
                fontsize=7.5,
            )
    axes.set_xscale("symlog", linthresh=1.0, linscale=0.7)
    axes.set_xlim(-70.0, 22.0)
    axes.set_yticks(range(len(SYMBOLS)), list(SYMBOLS.values()))
    axes.set_ylim(len(SYMBOLS) - 0.5, -0.5)
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.set_xticks([-30, -10, -3, -1, 0, 1, 3, 10])
    axes.grid(axis="y", visible=False)
    label(axes, "identified parameter", "deviation from the truth (%), with the fit's own 95 % interval")
