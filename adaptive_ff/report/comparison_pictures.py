"""Pictures of a run and of a comparison."""

from collections.abc import Iterable, Mapping
from itertools import cycle, product
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from adaptive_ff.comparison.comparison import BASELINE, Comparison
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.comparison.run import Run
from adaptive_ff.friction.model import TorqueModel, model_friction, unit_of
from adaptive_ff.report.style import (
    INK,
    LIMIT,
    QUIET,
    STYLE,
    TRUTH,
    Look,
    Panel,
    Series,
    frame,
    peak_of,
    picture,
    plain_name,
    stamp,
    typical_peak,
    write_into,
    write_to,
)
from adaptive_ff.report.table import DEVIATIONS
from adaptive_ff.scenario.axis_units import axis_label, axis_unit
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.scenario.truth import true_waves
from adaptive_ff.simulation.loop import joint_in_phase
from adaptive_ff.simulation.metrics import settled_start
from plant import sliding_friction

CLOSE_UP = 6.0  # s, length of a close-up
RMS_WINDOW = 2.0  # s, length of the running rms error; at least a hundredth of the run
RMS_PARTS = 600  # that a run is divided into for the running rms error
NEAR = 0.95  # of the torque limit
ROOM = 1.3  # a panel of estimates goes to this multiple of the truth at least

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
TORQUE_LIMIT: Look = {**LIMIT, "label": "torque limit"}
CHANGE: Look = {"color": INK, "linewidth": 0.9, "linestyle": (0, (1, 2)), "zorder": 1.5}
BAND: Look = {"color": "#999999", "linewidth": 6.0, "alpha": 0.5, "label": f"± {DEVIATIONS:g} standard deviations"}
MODEL: Look = {"color": "#0072b2", "label": "model: probability of a change, torque fed forward"}
OBSERVER: Look = {"color": "#d55e00", "label": "observer: gain, torque fed back"}
FEEDBACK: Look = {"color": QUIET, "label": "PI loop"}
ERROR: Look = {"color": INK, "label": "error"}

PICTURES = ("tracking", "torque", "estimates", "stribeck", "supervision", "friction_map")
"""Names of the pictures of a comparison, of which it has those that it can."""

FRICTION = {"coulomb", "stiction", "viscous"}  # make a friction curve
SUPERVISED = frozenset({"change_probability", "observer_gain", "observer_torque"})
"""What a run must record of its controller for a picture of its supervision."""


def looks_of(names: Iterable[str]) -> dict[str, Look]:
    """Give each controller its look: its own if it is known, else the next of a cycle."""
    spare = cycle({"color": colour, "linestyle": dashes} for dashes, colour in product(OTHER_DASHES, OTHER_COLOURS))
    looks: dict[str, Look] = {}
    for name in names:
        highlight = {} if name in CONTROLLERS else OWN
        looks[name] = {**(LOOKS.get(name) or {**next(spare), **highlight}), "label": plain_name(name)}
    return looks


def origin(scenario: Scenario) -> str:
    """Return what a picture says of where it comes from."""
    return f"{scenario.name}, seed {scenario.seed}"


def changes_of(scenario: Scenario) -> tuple[list[tuple[float, Look]], list[Look]]:
    """Return the changes of the joint, as marks of a picture, and what the legend shall explain."""
    marks = [(change.time, CHANGE) for change in scenario.change]
    kinds = {name for change in scenario.change for name in change.model_fields_set}
    several = "friction changes" if kinds <= {"time", "friction_scale"} else "the joint changes"
    label = axis_unit(scenario.joint.axis, scenario.change[0].text) if len(marks) == 1 else several
    explained: Look = {**CHANGE, "label": label}
    return marks, [explained] if marks else []


def plot_run(run: Run, path: str | Path | None = None) -> Figure:
    """Draw one run: tracking, error, with a position loop that of the position, torque with the feedforward in it."""
    look = {**looks_of([run.name])[run.name], "linestyle": "-"}
    thin, axis, time = {**look, "linewidth": 0.8}, run.scenario.joint.axis, run.solver_time
    velocity = {**look, "label": f"velocity with {look['label']}"}
    panels = [
        Panel(axis_label(axis, "velocity (rad/s)"), [(time, run.reference, REFERENCE), (time, run.velocity, look)]),
        Panel(axis_label(axis, "error (mrad/s)"), [(time, 1e3 * (run.reference - run.velocity), thin)]),
    ]
    if run.position_error is not None:
        panels.append(Panel(axis_label(axis, "position error (mrad)"), [(time, 1e3 * run.position_error, thin)]))
    panels.append(_torques(run, slice(None), look, axis_label(axis, "torque (N m)")))
    keys = [REFERENCE, velocity, *panels[-1].looks]
    panels[-1].span = (0.0, float(time[-1]))
    marks, changes = changes_of(run.scenario)
    source = origin(run.scenario)
    figure, _ = picture(panels, 2.0 * len(panels), source=source, keys=[*keys, *changes], marks=marks)
    write_to(figure, path)
    return figure


def plot_comparison(comparison: Comparison, folder: str | Path | None = None) -> dict[str, Figure]:
    """Draw the pictures of a comparison by name; write each as ``NAME.png`` where a folder is given.

    ``tracking`` and ``torque``; ``estimates`` where a controller estimates, ``stribeck`` where its estimates make a
    friction curve, ``supervision`` where a controller is supervised, and ``friction_map`` where one learns friction
    over position.
    """
    runs = comparison.runs
    if not runs:
        raise ValueError("comparison.runs is empty; there is nothing to draw")
    looks = looks_of(runs)
    estimating = {name: run for name, run in runs.items() if run.estimates}
    with rc_context(STYLE):
        figures = {"tracking": _tracking(runs, looks), "torque": _torque(runs, looks)}
        if estimating:
            figures["estimates"] = _estimates(estimating, looks)
        if any(run.estimates.keys() >= FRICTION for run in estimating.values()):
            figures["stribeck"] = _stribeck(comparison, looks)
        supervised = [run for run in runs.values() if run.monitors.keys() >= SUPERVISED]
        if supervised:
            figures["supervision"] = _supervision(supervised[-1])
        if any(run.friction_map is not None and run.friction_map.position.size for run in runs.values()):
            figures["friction_map"] = _friction_map(comparison, looks)
        stamp(figures.values(), origin(comparison.scenario))
    return write_into(figures, folder)


def _tracking(runs: Mapping[str, Run], looks: Mapping[str, Look]) -> Figure:
    first = next(iter(runs.values()))
    axis, part, end = first.scenario.joint.axis, _close_up(first), float(first.solver_time[-1])
    time, reference = first.solver_time[part], first.reference[part]
    errors = {name: 1e3 * (run.reference - run.velocity) for name, run in runs.items()}
    positions = {name: 1e3 * run.position_error for name, run in runs.items() if run.position_error is not None}
    velocities = {name: runs[name].velocity for name in _most_different(runs)}

    def close_up(label: str, series: Mapping[str, Series], cap: float | None = None) -> Panel:
        near = {name: whole[part] for name, whole in series.items()}
        curves = [(time, curve, looks[name]) for name, curve in near.items()]
        limit = cap or 20.0 * typical_peak(near)
        return Panel(axis_label(axis, label), curves, span=(float(time[0]), float(time[-1])), cap=limit)

    tracking = close_up("velocity (rad/s), close-up", velocities, 3.0 * peak_of(reference))
    tracking.curves = [(time, reference, REFERENCE), *tracking.curves]
    panels = [tracking, close_up("error (mrad/s), same close-up", errors)]
    if positions:
        panels.append(close_up("position error (mrad), same close-up", positions))
    running = {name: _running_rms(first.solver_time, whole) for name, whole in errors.items()}
    window = next(iter(running.values()))[2]
    label = f"rms error over the last {window:.3g} s ({axis_label(axis, 'mrad/s')}), whole run, close-up shaded"
    curves = [(ends, rms, looks[name]) for name, (ends, rms, _) in running.items()]
    near, since = (float(time[0]), float(time[-1])), min(window, 0.1 * end)
    panels.append(Panel(label, curves, span=(0.0, end), since=since, shaded=near))
    marks, changes = changes_of(first.scenario)
    keys = [REFERENCE, *looks.values(), *changes]
    return picture(panels, 2.4 * len(panels), shared=False, keys=keys, marks=marks)[0]


def _torque(runs: Mapping[str, Run], looks: Mapping[str, Look]) -> Figure:
    feeding = {name for name, run in runs.items() if np.any(run.feedforward)}
    drawn = {name: run for name, run in runs.items() if not feeding or name in feeding or name not in CONTROLLERS}
    first = next(iter(runs.values()))
    start, end = first.solver_time[_close_up(first)][[0, -1]]
    begin, stop = np.searchsorted(first.time, (start, end), side="right")
    part = slice(begin - 1, stop)  # the torque at the start is held from the sample before
    label = axis_label(first.scenario.joint.axis, "torque (N m)")
    panels = [_torques(run, part, looks[name], f"{label} with {looks[name]['label']}") for name, run in drawn.items()]
    keys = [{**look, "color": QUIET} for panel in panels for look in panel.looks]
    figure, axes = picture(panels, 0.8 + 1.2 * len(panels), keys=keys)
    torques = {plain_name(name): run.torque[part] for name, run in drawn.items()}
    parts = {f"feedforward of {plain_name(name)}": run.feedforward[part] for name, run in drawn.items()}
    frame(axes, {**torques, **parts}, 3.0 * typical_peak(torques))
    axes[-1].set_xlim(start, end)
    return figure


def _torques(run: Run, part: slice, look: Look, label: str) -> Panel:
    """Return a panel of the torque, the feedforward in it and the limit that it comes near."""
    time, color, lines = run.time[part], look["color"], []
    curves = [(time, run.torque[part], {"color": color, **TORQUE})]
    if np.any(run.feedforward):
        curves.append((time, run.feedforward[part], {"color": color, **FEEDFORWARD}))
    limit = run.scenario.actuator.torque_limit
    if limit is not None and peak_of(run.torque[part]) > NEAR * limit:
        lines = [(limit, TORQUE_LIMIT), (-limit, TORQUE_LIMIT)]
    return Panel(label, curves, lines)


def _estimates(runs: Mapping[str, Run], looks: Mapping[str, Look]) -> Figure:
    """Draw the estimates beside the truth, in bands of their uncertainty, a panel a parameter."""
    names = list(dict.fromkeys(name for run in runs.values() for name in run.estimates))
    first = next(iter(runs.values()))
    plan, end = first.scenario.plan, float(first.solver_time[-1])
    joints = [joint_in_phase(first.scenario.joint.parameters, plan, phase) for phase in range(plan.starts.size)]
    starts = np.array([*(plan.starts * first.scenario.joint.solver_period), end])
    truths = [
        {**true_waves(first.scenario), **one.friction._asdict(), **one._asdict(), "friction": None} for one in joints
    ]
    panels = []
    for name in names:
        known = {key: run for key, run in runs.items() if name in run.estimates}
        curves = {key: run.estimates[name] for key, run in known.items()}
        drawn = [(run.time, run.estimates[name], looks[key]) for key, run in known.items()]
        bands, last_bands = [], [0.0]
        for key, run in known.items():
            if name in run.uncertainties:
                time, spread = run.uncertainty_time, DEVIATIONS * run.uncertainties[name]
                middle = np.interp(time, run.time, run.estimates[name])
                bands.append((time, middle - spread, middle + spread, looks[key]["color"]))
                last_bands += [-spread[-1], spread[-1]]
        truth = np.array([one[name] for one in truths if one.get(name) is not None])
        if truth.size:
            drawn.append((starts, np.append(truth, truth[-1]), {**TRUTH, "drawstyle": "steps-post"}))
        inside = [*truth, *(ROOM * truth), *(last_bands if not any(map(np.any, curves.values())) else [0.0])]
        unit = axis_unit(first.scenario.joint.axis, unit_of(name))
        label = plain_name(name.replace("_", " ")) + (f" ({unit})" if unit else "")
        cap = 2.0 * (peak_of(truth) or typical_peak(curves))
        panels.append(Panel(label, drawn, span=(0.0, end), cap=cap, inside=inside, bands=bands))
    band = [BAND] if any(run.uncertainties for run in runs.values()) else []
    marks, changes = changes_of(first.scenario)
    keys = [TRUTH, *(looks[name] for name in runs), *band, *changes]
    return picture(panels, 0.8 + 1.2 * len(panels), keys=keys, marks=marks)[0]


def _stribeck(comparison: Comparison, looks: Mapping[str, Look]) -> Figure:
    scenario, runs = comparison.scenario, comparison.runs
    first, axis = next(iter(runs.values())), scenario.joint.axis
    peak = peak_of(first.reference) or 5.0 * scenario.joint.stribeck_velocity
    speeds = peak * np.linspace(0.0, 1.0, 200) ** 2  # denser where the curve bends
    models = {name: _identified(run) for name, run in runs.items() if run.estimates.keys() >= FRICTION}
    if "fixed" in runs:
        models = {"fixed": scenario.fixed.model, **models}
    curves = {name: np.array([model_friction(model, speed) for speed in speeds]) for name, model in models.items()}
    true = joint_in_phase(scenario.joint.parameters, scenario.plan, -1).friction
    truth = np.array([sliding_friction(true, speed) for speed in speeds])
    label = axis_label(axis, "friction torque while sliding (N m)")
    drawn = [(speeds, truth, TRUTH), *((speeds, curve, looks[name]) for name, curve in curves.items())]
    panel = Panel(
        f"{label}, as identified after {first.solver_time[-1]:.4g} s",
        drawn,
        span=(0.0, peak),
        cap=2.0 * (peak_of(truth) or typical_peak(curves)),
    )
    return picture([panel], 3.8, axis_label(axis, "speed (rad/s)"))[0]


def _identified(run: Run) -> TorqueModel:
    """Return the model at the end of a run; what is not estimated is as the controller assumes it."""
    assumed = run.scenario.adaptation
    known = {name: value for name, value in run.final_estimates.items() if name in TorqueModel._fields}
    return TorqueModel(0.0, 0.0, 0.0, 0.0, 0.0, assumed.stribeck_velocity, assumed.stribeck_shape)._replace(**known)


def _supervision(run: Run) -> Figure:
    """Draw error, probability of a change and gain, and the torque by source, over the whole run."""
    axis, time, observed = run.scenario.joint.axis, run.time, run.monitors["observer_torque"]
    error = [(run.solver_time, 1e3 * (run.reference - run.velocity), ERROR)]
    gains = [(time, run.monitors["change_probability"], MODEL), (time, run.monitors["observer_gain"], OBSERVER)]
    feedback = run.torque - run.feedforward - observed
    torques = [(time, feedback, FEEDBACK), (time, run.feedforward, MODEL), (time, observed, OBSERVER)]
    panels = [
        Panel(axis_label(axis, "velocity error (mrad/s)"), error),
        Panel("probability of a change and observer gain, from 0 to 1", gains, limits=(-0.05, 1.08)),
        Panel(axis_label(axis, "torque (N m) by source"), torques, span=(0.0, float(run.solver_time[-1]))),
    ]
    return picture(panels, 6.4, keys=[MODEL, OBSERVER, FEEDBACK], marks=changes_of(run.scenario)[0])[0]


def _friction_map(comparison: Comparison, looks: Mapping[str, Look]) -> Figure:
    """Draw friction over its mean along the position, a curve a controller, and the truth."""
    maps = {name: run.friction_map for name, run in comparison.runs.items() if run.friction_map is not None}
    curves = [(one.position, one.factor, looks[name]) for name, one in maps.items() if one.position.size]
    low, high = min(x[0] for x, *_ in curves), max(x[-1] for x, *_ in curves)
    position, variation = np.linspace(low, high, 1000), comparison.scenario.variation
    truth = 1.0 + variation.position_amplitude * np.sin(2.0 * np.pi * position / variation.position_period)
    label = "friction over its mean, as learnt at the end of the run"
    panel = Panel(label, [*curves, (position, truth, TRUTH)], span=(low, high))
    return picture([panel], 3.8, axis_label(comparison.scenario.joint.axis, "position (rad)"))[0]


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
    count = min(RMS_PARTS, time.size)
    edges = np.linspace(0, time.size, count + 1).astype(np.intp)
    parts = count if time[-1] < RMS_WINDOW else max(1, round(RMS_WINDOW * count / time[-1]), count // 100)
    squares = np.convolve(np.add.reduceat(np.square(error), edges[:-1]), np.ones(parts))[:count]
    sizes = np.convolve(np.diff(edges), np.ones(parts))[:count]
    return time[edges[1:] - 1], np.sqrt(squares / sizes), float(parts * time[-1] / count)
