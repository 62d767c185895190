"""Pictures of what was made of a recorded log: identification, replay, open-loop score."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from adaptive_ff.identify.columns import is_mapped
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.identify.score import Score
from adaptive_ff.replay.replay import COLD, FIXED, RECORDED, SAVED, Replay
from adaptive_ff.report.style import INK, MEASURED, Look, Panel, Series, peak_of, picture, write_into

MODEL: Look = {"color": "#d55e00", "linewidth": 1.0, "label": "inertia and friction as identified"}
LEFT: Look = {"color": "#0072b2", "linewidth": 0.8, "label": "measured − identified"}
ROWS: Look = {"color": "#9ec5e0", "marker": ".", "markersize": 2.5, "linestyle": "", "label": "rows of the log"}
MEANS: Look = {"color": "#0072b2", "marker": "o", "markersize": 3.5, "linestyle": "", "label": "mean in a bin"}
TEXTBOOK: Look = {"color": INK, "linewidth": 0.8, "linestyle": (0, (3, 2)), "label": "textbook"}
SIMULATED: Look = {"color": "#d55e00", "linewidth": 1.0, "label": "simulated from the torque alone"}
ERROR: Look = {"color": "#0072b2", "linewidth": 1.0, "label": "simulated − measured"}
NEEDED: Look = {**MEASURED, "label": "torque that was needed"}
LOOKS: dict[str, Look] = {
    RECORDED: {"color": "#009e73", "linewidth": 1.0, "label": "the machine's own feedforward"},
    FIXED: {"color": "#0072b2", "linewidth": 1.0, "label": "fixed model of the first half"},
    COLD: {"color": "#d55e00", "linewidth": 1.0, "label": "adaptive, cold start"},
    SAVED: {"color": "#7b5aa6", "linewidth": 1.0, "label": "adaptive, from a saved state"},
}

PICTURES = ("identified_torque", "friction", "identified_map")
"""Names of the pictures of an identification; without friction or force over position there is no map."""

CLOSE_UP = 0.1  # length of a close-up over that of the log


def plot_identification(found: LogIdentification, folder: str | Path | None = None) -> dict[str, Figure]:
    """Draw the pictures of an identified log by name; write each as ``NAME.png`` where a folder is given.

    ``identified_torque``: torque over time, measured and identified; ``friction``: friction and residual over the
    velocity; ``identified_map``: friction and force over position, where the model has them.
    """
    figures = {"identified_torque": _torque(found), "friction": _friction(found)}
    if any(map(is_mapped, found.best.values)):
        figures["identified_map"] = _map(found)
    return write_into(figures, folder)


def _torque(found: LogIdentification) -> Figure:
    rows, unit = found.data, found.units["torque"]
    gaps = np.diff(rows.time, prepend=rows.time[0]) > 3.0 * float(np.median(np.diff(rows.time)))
    measured, fitted = (np.where(gaps, np.nan, one) for one in (rows.torque, found.fitted))
    curves = [(rows.time, measured, MEASURED), (rows.time, fitted, MODEL)]
    panels = [
        Panel(f"torque ({unit}) in a band of {rows.band:.3g} Hz, while sliding", curves),
        Panel(f"torque ({unit}), close-up", curves, span=_close_up(rows.time, rows.torque)),
        Panel(f"residual ({unit})", [(rows.time, measured - fitted, LEFT)]),
    ]
    return picture(panels, 7.0, source=found.name, shared=False)[0]


def _friction(found: LogIdentification) -> Figure:
    rows, unit = found.data, found.units["torque"]
    residual = rows.torque - found.fitted
    friction = residual + found.friction(rows.velocity)
    part, points = slice(None, None, max(1, rows.velocity.size // 5000)), found.friction_points()
    left = points["torque"] - found.friction(points["velocity"])
    curves = [(rows.velocity[part], friction[part], ROWS), (points["velocity"], points["torque"], MEANS)]
    below = [(rows.velocity[part], residual[part], ROWS), (points["velocity"], left, MEANS)]
    values = found.textbook.values
    for side in (-1.0, 1.0):
        fastest = float(np.max(side * rows.velocity, initial=0.0))
        if fastest > 0.0:
            speeds = side * (1e-3 * fastest + 0.999 * fastest * np.linspace(0.0, 1.0, 400) ** 2)
            curves.append((speeds, found.friction(speeds), {**MODEL, "zorder": 2.6}))
            if found.refined is not None:
                line = side * values.get("coulomb", 0.0) + values.get("viscous", 0.0) * speeds
                curves.append((speeds, line + values.get("offset", 0.0), TEXTBOOK))
    panels = [
        Panel(f"friction ({unit}), offset included", curves, limits=_around(friction)),
        Panel(f"measured − identified ({unit})", below, [(0.0, MODEL)], limits=_around(residual)),
    ]
    return picture(panels, 6.4, f"velocity ({found.units['velocity']})", source=found.name)[0]


def _around(values: Series) -> tuple[float, float]:
    """Return limits about nearly all values."""
    low, high = (float(end) for end in np.quantile(values, (0.002, 0.998)))
    return low - 0.15 * (high - low), high + 0.15 * (high - low)


def _map(found: LogIdentification) -> Figure:
    place, rows = found.data.place, found.data.position
    position = np.linspace(float(rows.min()), float(rows.max()), 400)
    curves: list[tuple[Series, Series, Look]] = []
    for kind, look in (("friction", MODEL), ("force", LEFT)):
        parts = [found.value(f"{kind}_{name}") * place.fraction(name, position) for name in place.names]
        if np.any(parts):
            curves.append((position, np.sum(parts, axis=0), {**look, "label": f"{kind} over position"}))
    panel = Panel(f"torque beside its mean ({found.units['torque']})", curves)
    xlabel = f"position ({found.units['velocity'].removesuffix('/s')})"
    return picture([panel], 3.2, xlabel, source=found.name)[0]


def plot_score(score: Score, folder: str | Path | None = None) -> dict[str, Figure]:
    """Draw measured and simulated position of the other log, and their difference below; ``score.png`` in a folder."""
    unit, time = "m" if score.found.linear else "rad", score.time
    error = [(time, 1e3 * (score.simulated - score.measured), ERROR)]
    panels = [
        Panel(f"position ({unit})", [(time, score.measured, MEASURED), (time, score.simulated, SIMULATED)]),
        Panel(f"error (m{unit}), {1e3 * score.rms:.3g} rms", error, span=_ends(time)),
    ]
    source = f"{Path(score.tested).name}, trained on {Path(score.found.name).name}"
    return write_into({"score": picture(panels, 5.2, source=source)[0]}, folder)


def plot_replay(replay: Replay, folder: str | Path | None = None) -> dict[str, Figure]:
    """Draw the pictures of a replay by name; write each as ``NAME.png`` where a folder is given.

    ``replay``: the torque that was needed over time; each feedforward beside it in a panel of its own, in a close-up
    around the fastest change; what each leaves, in panels of one scale; ``estimates``: the parameters over time.
    """
    return write_into({"replay": _torques(replay), "estimates": _estimates(replay)}, folder)


def _torques(replay: Replay) -> Figure:
    series, time, unit = replay.series, replay.series.time, replay.unit
    looks = {name: look for name, look in LOOKS.items() if name in series.feedforward}
    needed, near, whole = (time, series.needed, NEEDED), _close_up(time, series.needed), _ends(time)
    left = {name: series.needed - series.feedforward[name] for name in looks}
    most = 1.3 * float(np.quantile(np.abs(list(left.values())), 0.998))  # a few peaks do not press the rest flat
    high, low = ((-end, end) if end > 0.0 else None for end in (1.3 * peak_of(series.needed), most))
    title = f"torque that was needed ({unit}), band {replay.data.band:.3g} Hz; shaded: the close-up"
    panels = [Panel(title, [needed], span=whole, shaded=near)]
    for name, look in looks.items():
        beside = [needed, (time, series.feedforward[name], look)]
        panels.append(Panel(f"close-up ({unit}): {look['label']}", beside, span=near, limits=high))
    for name, look in looks.items():
        label = f"torque left to the feedback ({unit}): {look['label']}"
        panels.append(Panel(label, [(time, left[name], look)], span=whole, limits=low))
    return picture(panels, 2.2 + 2.2 * len(looks), source=replay.data.log.name, shared=False)[0]


def _ends(time: Series) -> tuple[float, float]:
    return float(time[0]), float(time[-1])


def _close_up(time: Series, torque: Series) -> tuple[float, float]:
    """Return a stretch around the place where the torque changes most, s."""
    reach = max(1, torque.size // 400)
    place = int(np.argmax(np.abs(torque[reach:] - torque[:-reach]))) + reach // 2
    length = CLOSE_UP * float(time[-1] - time[0])
    start = float(np.clip(time[place] - 0.5 * length, time[0], time[-1] - length))
    return start, start + length


def _estimates(replay: Replay) -> Figure:
    time, histories = replay.series.time, replay.series.estimates
    panels = [
        Panel(
            f"{name.replace('_', ' ')} ({replay.units[name]})",
            [(time, history[name], LOOKS[which]) for which, history in histories.items()],
            span=_ends(time),
        )
        for name in next(iter(histories.values()))
    ]
    return picture(panels, 1.1 * len(panels) + 0.8, source=replay.data.log.name)[0]
