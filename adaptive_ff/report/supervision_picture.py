"""Picture of who gives the torque: model, observer or feedback; and of the probability that the joint has changed."""

from matplotlib.figure import Figure

from adaptive_ff.comparison.run import Run
from adaptive_ff.report.drawing import INK, QUIET, Look, draw_series, explain_looks, label_above, make_panels
from adaptive_ff.scenario.axis_units import axis_label

MODEL: Look = {"color": "#0072b2", "label": "model: probability of a change, torque fed forward"}
OBSERVER: Look = {"color": "#d55e00", "label": "observer: gain, torque fed back"}
FEEDBACK: Look = {"color": QUIET, "label": "PI loop"}
ERROR: Look = {"color": INK, "label": "error"}

SUPERVISED = frozenset({"change_probability", "observer_gain", "observer_torque"})
"""What a run must record of its controller to be drawn."""


def draw_supervision(run: Run) -> Figure:
    """Draw error, probability of a change and gain, and the shares of the torque, over the whole run.

    The caller sets the style.
    """
    figure, (error, share, torque) = make_panels(3, 6.4)
    draw_series(error, run.solver_time, 1e3 * (run.reference - run.velocity), ERROR)
    draw_series(share, run.time, run.monitors["change_probability"], MODEL)
    draw_series(share, run.time, run.monitors["observer_gain"], OBSERVER)
    observed = run.monitors["observer_torque"]
    draw_series(torque, run.time, run.torque - run.feedforward - observed, FEEDBACK)
    draw_series(torque, run.time, run.feedforward, MODEL)
    draw_series(torque, run.time, observed, OBSERVER)
    share.set(ylim=(-0.05, 1.08))
    axis = run.scenario.joint.axis
    label_above(error, axis_label(axis, "velocity error (mrad/s)"))
    label_above(share, "probability of a change and observer gain, from 0 to 1")
    label_above(torque, axis_label(axis, "torque (N m) by source"))
    torque.set(xlim=(0.0, run.solver_time[-1]), xlabel="time (s)")
    for change in run.scenario.change:
        for axes in (error, share, torque):
            axes.axvline(change.time, color=QUIET, linestyle=":", linewidth=1.0)
    explain_looks(figure, [MODEL, OBSERVER, FEEDBACK])
    return figure
