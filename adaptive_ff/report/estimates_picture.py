"""Picture of the estimates over time, beside the truth, in bands of their uncertainty."""

from collections.abc import Iterable, Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from adaptive_ff.comparison.run import Run
from adaptive_ff.friction.model import unit_of
from adaptive_ff.report.drawing import Look, Series, draw_series, explain_looks, label_above, make_panels
from adaptive_ff.report.framing import frame, peak_of, plain_name, typical_peak
from adaptive_ff.report.marks import TRUTH, mark_changes
from adaptive_ff.report.scaling import DEVIATIONS
from adaptive_ff.scenario.axis_units import axis_unit
from adaptive_ff.scenario.truth import true_waves
from adaptive_ff.simulation.loop import joint_in_phase

ROOM = 1.3
"""A panel goes to this multiple of the truth at least."""

BAND: Look = {"alpha": 0.25, "linewidth": 0.0}
BAND_KEY: Look = {"color": "#999999", "linewidth": 6.0, "alpha": 0.5, "label": f"± {DEVIATIONS:g} standard deviations"}


def draw_estimates(runs: Mapping[str, Run], looks: Mapping[str, Look]) -> Figure:
    """Draw a panel a parameter, over the whole run; the caller sets the style."""
    names = list(dict.fromkeys(name for run in runs.values() for name in run.estimates))
    figure, panels = make_panels(len(names), 0.8 + 1.2 * len(names))
    first = next(iter(runs.values()))
    plan, end = first.scenario.plan, float(first.solver_time[-1])
    joints = [joint_in_phase(first.scenario.joint.parameters, plan, phase) for phase in range(plan.starts.size)]
    starts = [*(plan.starts * first.scenario.joint.solver_period), end]
    waves = true_waves(first.scenario)
    for axes, name in zip(panels, names, strict=True):
        known = {key: run for key, run in runs.items() if name in run.estimates}
        curves = {key: draw_series(axes, run.time, run.estimates[name], looks[key]) for key, run in known.items()}
        for key, run in known.items():
            _draw_band(axes, run, name, looks[key])
        true = [
            {**waves, **joint.friction._asdict(), **joint._asdict(), "friction": None}.get(name) for joint in joints
        ]
        truth = np.array([value for value in true if value is not None])
        if truth.size:
            axes.plot(starts, [*truth, truth[-1]], drawstyle="steps-post", **TRUTH)
        frame(
            [axes],
            {"": np.concatenate([truth, ROOM * truth, [0.0], *_last_bands(known.values(), name, curves)]), **curves},
            2.0 * (peak_of(truth) or typical_peak(curves)),
        )
        unit = axis_unit(first.scenario.joint.axis, unit_of(name))
        label_above(axes, plain_name(name.replace("_", " ")) + (f" ({unit})" if unit else ""))
    panels[-1].set(xlim=(0.0, end), xlabel="time (s)")
    bands = [BAND_KEY] if any(run.uncertainties for run in runs.values()) else []
    explain_looks(figure, [TRUTH, *(looks[name] for name in runs), *bands, *mark_changes(panels, first.scenario)])
    return figure


def _last_bands(runs: Iterable[Run], name: str, curves: Mapping[str, Series]) -> list[Series]:
    """Return how uncertain an estimate is at the end where all curves are zero, which else have a scale of 1."""
    if any(np.any(curve) for curve in curves.values()):
        return []
    return [
        DEVIATIONS * run.uncertainties[name][-1] * np.array([-1.0, 1.0]) for run in runs if name in run.uncertainties
    ]


def _draw_band(axes: Axes, run: Run, name: str, look: Look) -> None:
    """Draw how uncertain an estimate is; the limits of the panel are not set by it."""
    if name not in run.uncertainties:
        return
    time, spread = run.uncertainty_time, DEVIATIONS * run.uncertainties[name]
    middle: Series = np.interp(time, run.time, run.estimates[name])
    axes.fill_between(time, middle - spread, middle + spread, color=look["color"], **BAND)
