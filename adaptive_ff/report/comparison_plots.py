"""Pictures of a run and of a comparison.

No ``pyplot``: figures open no window and leave no state behind. A curve that leaves its panel is named above it.
"""

from collections.abc import Iterable, Mapping
from itertools import cycle, product
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from adaptive_ff.comparison.comparison import BASELINE, Comparison
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.comparison.run import Run
from adaptive_ff.friction.model import TorqueModel, model_friction
from adaptive_ff.report.drawing import (
    INK,
    QUIET,
    STYLE,
    Look,
    Series,
    draw_series,
    explain_looks,
    label_above,
    make_panels,
    stamp,
    write_asked,
    write_into,
)
from adaptive_ff.report.estimates_picture import draw_estimates
from adaptive_ff.report.framing import frame, make_logarithmic, peak_of, plain_name, typical_peak
from adaptive_ff.report.friction_map_picture import draw_friction_map
from adaptive_ff.report.marks import TRUTH, mark_changes
from adaptive_ff.report.supervision_picture import SUPERVISED, draw_supervision
from adaptive_ff.scenario.axis_units import axis_label
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.simulation.loop import joint_in_phase
from adaptive_ff.simulation.metrics import settled_start
from plant import sliding_friction

CLOSE_UP = 6.0  # s, length of a close-up
RMS_WINDOW = 2.0  # s, length of the running rms error; at least a hundredth of the run
RMS_BLOCKS = 600  # that a run is divided into for the running rms error
NEAR = 0.95  # of the torque limit


LOOKS: dict[str, Look] = {
    "pi": {"color": "#a6a6a6", "linewidth": 2.0},
    "pi_inertia": {"color": "#56b4e9"},
    "fixed": {"color": "#009e73"},
    "oracle": {"color": "#000000", "linestyle": (0, (3, 2)), "zorder": 2.5},
    "adaptive_paper": {"color": "#7b5aa6"},
    "adaptive": {"color": "#d55e00", "linewidth": 1.5, "zorder": 2.4},
}
"""Looks of the controllers of the main job, for colour-blind eyes too; others take the next of a cycle."""

OTHER_COLOURS = ("#0072b2", "#cc79a7", "#b89b00", "#882255", "#332288", "#44aa99")
OTHER_DASHES = ("-", "-.", ":")

OWN: Look = {"linewidth": 1.8, "zorder": 2.45}
"""What a user's own controllers have beside a colour of their own: they stand out."""

REFERENCE: Look = {"color": INK, "linewidth": 0.7, "zorder": 2.6, "label": "reference"}
TORQUE: Look = {"linewidth": 0.7, "alpha": 0.5, "drawstyle": "steps-post", "label": "torque"}
FEEDFORWARD: Look = {"linewidth": 1.2, "drawstyle": "steps-post", "label": "feedforward in it"}
LIMIT: Look = {"color": INK, "linewidth": 0.8, "linestyle": (0, (6, 2, 1, 2)), "label": "torque limit"}

PICTURES = ("tracking", "torque", "estimates", "stribeck", "supervision", "friction_map")
"""Names of the pictures of a comparison, of which it has those that it can."""

FRICTION = {"coulomb", "stiction", "viscous"}  # make a friction curve


def plot_run(run: Run, path: str | Path | None = None) -> Figure:
    """Draw one run: tracking, error, with a position loop that of the position, torque with the feedforward in it.

    Parameters
    ----------
    run : Run
        The run.
    path : str or Path, optional
        Where to write the picture: PNG, or what the ending of the name says.

    Returns
    -------
    Figure
        Three or four panels over the whole run.
    """
    look = {**looks_of([run.name])[run.name], "linestyle": "-"}
    keys = [REFERENCE, {**look, "label": f"velocity with {look['label']}"}]
    axis = run.scenario.joint.axis
    with rc_context(STYLE):
        several = 3 if run.position_error is None else 4
        figure, panels = make_panels(several, 2.0 * several)
        tracking, error, torque = panels[0], panels[1], panels[-1]
        draw_series(tracking, run.solver_time, run.reference, REFERENCE)
        draw_series(tracking, run.solver_time, run.velocity, look)
        draw_series(error, run.solver_time, 1e3 * (run.reference - run.velocity), {**look, "linewidth": 0.8})
        if run.position_error is not None:
            draw_series(panels[2], run.solver_time, 1e3 * run.position_error, {**look, "linewidth": 0.8})
            label_above(panels[2], axis_label(axis, "position error (mrad)"))
        keys += _draw_torques(torque, run, slice(None), look)
        keys += mark_changes(panels, run.scenario)
        label_above(tracking, axis_label(axis, "velocity (rad/s)"))
        label_above(error, axis_label(axis, "error (mrad/s)"))
        label_above(torque, axis_label(axis, "torque (N m)"))
        torque.set(xlabel="time (s)", xlim=(0.0, run.solver_time[-1]))
        explain_looks(figure, keys)
        stamp([figure], origin(run.scenario))
        write_asked(figure, path)
    return figure


def origin(scenario: Scenario) -> str:
    """Return what a picture says of where it comes from."""
    return f"{scenario.name}, seed {scenario.seed}"


def plot_comparison(comparison: Comparison, folder: str | Path | None = None) -> dict[str, Figure]:
    """Draw the pictures of a comparison.

    Parameters
    ----------
    comparison : Comparison
        The comparison.
    folder : str or Path, optional
        Where to write each picture as ``NAME.png``; it is made where it is missing.

    Returns
    -------
    dict of Figure
        ``tracking`` and ``torque``; ``estimates`` where a controller estimates, ``stribeck`` where its estimates make a
        friction curve, ``supervision`` where a controller is supervised, and ``friction_map`` where one learns friction
        over position.

    Raises
    ------
    ValueError
        The comparison has no runs.
    """
    runs = comparison.runs
    if not runs:
        raise ValueError("comparison.runs is empty; there is nothing to draw")
    looks = looks_of(runs)
    estimating = {name: run for name, run in runs.items() if run.estimates}
    with rc_context(STYLE):
        figures = {"tracking": _tracking(runs, looks), "torque": _torque(runs, looks)}
        if estimating:
            figures["estimates"] = draw_estimates(estimating, looks)
        if any(run.estimates.keys() >= FRICTION for run in estimating.values()):
            figures["stribeck"] = _stribeck(comparison, looks)
        supervised = [run for run in runs.values() if run.monitors.keys() >= SUPERVISED]
        if supervised:
            figures["supervision"] = draw_supervision(supervised[-1])
        maps = {name: run.friction_map for name, run in runs.items() if run.friction_map is not None}
        maps = {name: learnt for name, learnt in maps.items() if learnt.position.size}
        if maps:
            figures["friction_map"] = draw_friction_map(maps, looks, comparison.scenario)
        stamp(figures.values(), origin(comparison.scenario))
        write_into(figures, folder)
    return figures


def _tracking(runs: Mapping[str, Run], looks: Mapping[str, Look]) -> Figure:
    first = next(iter(runs.values()))
    positions = {name: 1e3 * run.position_error for name, run in runs.items() if run.position_error is not None}
    several = 4 if positions else 3
    figure, panels = make_panels(several, 2.4 * several, shared=False)
    tracking, error, rms = panels[0], panels[1], panels[-1]
    axis = first.scenario.joint.axis
    part = _close_up(first)
    time, reference = first.solver_time[part], first.reference[part]
    shown = {name: runs[name].velocity[part] for name in _most_different(runs)}
    near, window = {}, 0.0
    draw_series(tracking, time, reference, REFERENCE)
    for name, velocity in shown.items():
        draw_series(tracking, time, velocity, looks[name])
    for name, run in runs.items():
        whole = 1e3 * (run.reference - run.velocity)
        near[name] = whole[part]
        draw_series(error, time, near[name], looks[name])
        *curve, window = _running_rms(first.solver_time, whole)
        rms.plot(*curve, **looks[name])
    frame([tracking], {"": reference, **shown}, 3.0 * peak_of(reference) or 20.0 * typical_peak(shown))
    frame([error], near, 20.0 * typical_peak(near))
    if positions:
        _draw_close_up(panels[2], time, {name: series[part] for name, series in positions.items()}, looks)
        label_above(panels[2], axis_label(axis, "position error (mrad), same close-up"))
    make_logarithmic(rms, min(window, 0.1 * float(first.solver_time[-1])))
    label_above(tracking, axis_label(axis, "velocity (rad/s), close-up"))
    label_above(error, axis_label(axis, "error (mrad/s), same close-up"))
    unit = axis_label(axis, "mrad/s")
    label_above(rms, f"rms error over the last {window:.3g} s ({unit}), whole run, close-up shaded")
    tracking.set(xlim=(time[0], time[-1]))
    tracking.tick_params(labelbottom=False)
    error.set(xlim=(time[0], time[-1]))
    error.tick_params(labelbottom=not positions)
    panels[-2].set(xlim=(time[0], time[-1]), xlabel="time (s)")
    rms.set(xlim=(0.0, first.solver_time[-1]), xlabel="time (s)")
    rms.axvspan(time[0], time[-1], color="#f0f0f0", zorder=0.4)
    explain_looks(figure, [REFERENCE, *looks.values(), *mark_changes(panels, first.scenario)])
    return figure


def _draw_close_up(axes: Axes, time: Series, curves: Mapping[str, Series], looks: Mapping[str, Look]) -> None:
    """Draw a curve a controller and fit the limits to them."""
    for name, curve in curves.items():
        draw_series(axes, time, curve, looks[name])
    frame([axes], curves, 20.0 * typical_peak(curves))


def _torque(runs: Mapping[str, Run], looks: Mapping[str, Look]) -> Figure:
    feeding = {name for name, run in runs.items() if np.any(run.feedforward)}
    shown = {name: run for name, run in runs.items() if not feeding or name in feeding or name not in CONTROLLERS}
    figure, panels = make_panels(len(shown), 0.8 + 1.2 * len(shown))
    first = next(iter(runs.values()))
    start, end = first.solver_time[_close_up(first)][[0, -1]]
    begin, stop = np.searchsorted(first.time, (start, end), side="right")
    part = slice(begin - 1, stop)  # the torque at the start is held from the sample before
    keys: dict[str, Look] = {}
    torque = axis_label(first.scenario.joint.axis, "torque (N m)")
    for axes, (name, run) in zip(panels, shown.items(), strict=True):
        for key in _draw_torques(axes, run, part, looks[name]):
            keys[key["label"]] = {**key, "color": QUIET}  # what they have in common
        label_above(axes, f"{torque} with {looks[name]['label']}")
    torques = {name: run.torque[part] for name, run in shown.items()}
    parts = {f"feedforward of {name}": run.feedforward[part] for name, run in shown.items()}
    frame(panels, {**torques, **parts}, 3.0 * typical_peak(torques))
    panels[-1].set(xlim=(start, end), xlabel="time (s)")
    explain_looks(figure, keys.values())
    return figure


def _stribeck(comparison: Comparison, looks: Mapping[str, Look]) -> Figure:
    figure, (axes,) = make_panels(1, 3.8)
    scenario, runs = comparison.scenario, comparison.runs
    first = next(iter(runs.values()))
    peak = peak_of(first.reference) or 5.0 * scenario.joint.stribeck_velocity
    speeds = peak * np.linspace(0.0, 1.0, 200) ** 2  # denser where the curve bends
    models = {name: _identified(run) for name, run in runs.items() if run.estimates.keys() >= FRICTION}
    if "fixed" in runs:
        models = {"fixed": scenario.fixed.model, **models}
    curves = {name: np.array([model_friction(model, speed) for speed in speeds]) for name, model in models.items()}
    friction = joint_in_phase(scenario.joint.parameters, scenario.plan, -1).friction
    truth = np.array([sliding_friction(friction, speed) for speed in speeds])
    for name, curve in curves.items():
        axes.plot(speeds, curve, **looks[name])
    axes.plot(speeds, truth, **TRUTH)
    frame([axes], {"": truth, **curves}, 2.0 * (peak_of(truth) or typical_peak(curves)))
    axis = scenario.joint.axis
    friction = axis_label(axis, "friction torque while sliding (N m)")
    label_above(axes, f"{friction}, as identified after {first.solver_time[-1]:.4g} s")
    axes.set(xlabel=axis_label(axis, "speed (rad/s)"), xlim=(0.0, peak))
    explain_looks(figure, [TRUTH, *(looks[name] for name in curves)])
    return figure


def _identified(run: Run) -> TorqueModel:
    """Return the model at the end of a run; what is not estimated is as the controller assumes it."""
    assumed = run.scenario.adaptation
    known = {name: value for name, value in run.final_estimates.items() if name in TorqueModel._fields}
    return TorqueModel(0.0, 0.0, 0.0, 0.0, 0.0, assumed.stribeck_velocity, assumed.stribeck_shape)._replace(**known)


def _most_different(runs: Mapping[str, Run]) -> list[str]:
    """Choose controllers whose velocities differ most: baseline, two of the user's own, adaptive; or best and worst."""
    own = [name for name in runs if name not in CONTROLLERS][:2]
    chosen = [name for name in (BASELINE, *own, "adaptive") if name in runs]
    ranked = sorted(runs, key=lambda name: runs[name].metrics.rms_error_settled)
    return chosen if len(chosen) > 1 else list(dict.fromkeys([*chosen, ranked[0], ranked[-1]]))


def _close_up(run: Run) -> slice:
    """Choose the stretch of the solver's grid with most reversals in the settled part."""
    time, reference = run.solver_time, run.reference
    settled, latest = settled_start(run.scenario.last_change, time[-1]), time[-1] - CLOSE_UP
    begin = latest  # where the settled part is too short; the start where the run is
    if latest > settled:
        moving = np.flatnonzero(reference)
        turns = time[moving[1:][np.diff(np.sign(reference[moving])) != 0.0]]
        turns = turns[turns >= settled]
        begins = np.clip([*(turns - 0.1 * CLOSE_UP), latest], settled, latest)
        count = np.searchsorted(turns, begins + CLOSE_UP) - np.searchsorted(turns, begins)
        begin = begins[np.argmax(count)]
    start = int(np.searchsorted(time, begin))
    return slice(start, int(np.searchsorted(time, time[start] + CLOSE_UP, side="right")))


def _running_rms(time: Series, error: Series) -> tuple[Series, Series, float]:
    """Return times, the rms error over the last seconds before each, and how many; at the start over what there is."""
    count = min(RMS_BLOCKS, time.size)
    edges = np.linspace(0, time.size, count + 1).astype(np.intp)
    blocks = count if time[-1] < RMS_WINDOW else max(1, round(RMS_WINDOW * count / time[-1]), count // 100)
    squares = np.convolve(np.add.reduceat(np.square(error), edges[:-1]), np.ones(blocks))[:count]
    sizes = np.convolve(np.diff(edges), np.ones(blocks))[:count]
    return time[edges[1:] - 1], np.sqrt(squares / sizes), float(blocks * time[-1] / count)


def _draw_torques(axes: Axes, run: Run, part: slice, look: Look) -> list[Look]:
    """Draw the torque, the feedforward in it and the limit that it comes near; return what the legend shall explain."""
    keys: list[Look] = [{"color": look["color"], **TORQUE}]
    draw_series(axes, run.time[part], run.torque[part], keys[0])
    if np.any(run.feedforward):
        keys.append({"color": look["color"], **FEEDFORWARD})
        draw_series(axes, run.time[part], run.feedforward[part], keys[1])
    limit = run.scenario.actuator.torque_limit
    if limit is not None and peak_of(run.torque[part]) > NEAR * limit:
        keys.append(LIMIT)
        axes.axhline(limit, **LIMIT)
        axes.axhline(-limit, **LIMIT)
    return keys


def looks_of(names: Iterable[str]) -> dict[str, Look]:
    """Give each controller its look: its own if it is known, else the next of a cycle."""
    spare = cycle({"color": colour, "linestyle": dashes} for dashes, colour in product(OTHER_DASHES, OTHER_COLOURS))
    looks: dict[str, Look] = {}
    for name in names:
        highlight = {} if name in CONTROLLERS else OWN
        looks[name] = {**(LOOKS.get(name) or {**next(spare), **highlight}), "label": plain_name(name)}
    return looks
