"""Pictures of a replay."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from adaptive_ff.logs.derivatives import Array
from adaptive_ff.replay.result import COLD, FIXED, RECORDED, SAVED, Replay
from adaptive_ff.report.drawing import (
    STYLE,
    Look,
    Series,
    draw_series,
    explain_looks,
    label_above,
    make_panels,
    stamp,
    write_into,
)

NEEDED: Look = {"color": "#a6a6a6", "linewidth": 2.0, "label": "torque that was needed"}
LOOKS: dict[str, Look] = {
    RECORDED: {"color": "#009e73", "linewidth": 1.0, "label": "the machine's own feedforward"},
    FIXED: {"color": "#0072b2", "linewidth": 1.0, "label": "fixed model of the first half"},
    COLD: {"color": "#d55e00", "linewidth": 1.0, "label": "adaptive, cold start"},
    SAVED: {"color": "#7b5aa6", "linewidth": 1.0, "label": "adaptive, from a saved state"},
}

CLOSE_UP = 0.1
"""Length of the close-up, over that of the log."""


def plot_replay(replay: Replay, folder: str | Path | None = None) -> dict[str, Figure]:
    """Draw a replay.

    Parameters
    ----------
    replay : Replay
        The log replayed.
    folder : str or Path, optional
        Where to write each picture as ``NAME.png``; it is made where it is missing.

    Returns
    -------
    dict of Figure
        ``replay``: the torque that was needed over time; each feedforward beside it in a panel of its own, in a
        close-up around the fastest change; what each leaves, in panels of one scale; ``estimates``: the parameters over
        time.
    """
    with rc_context(STYLE):
        figures = {"replay": _torques(replay), "estimates": _estimates(replay)}
        stamp(figures.values(), replay.name)
        write_into(figures, folder)
    return figures


def _torques(replay: Replay) -> Figure:
    series, time = replay.series, elapsed(replay.series.time)
    names = [name for name in LOOKS if name in series.feedforward]
    figure, panels = make_panels(1 + 2 * len(names), 2.2 + 2.2 * len(names), shared=False)
    whole, near, left = panels[0], panels[1 : 1 + len(names)], panels[1 + len(names) :]
    _draw(whole, time, series.needed, NEEDED)
    start, stop = _close_up(time, series.needed)
    whole.axvspan(start, stop, color="#ececec", zorder=0.4)
    band = "" if replay.band is None else f", band {replay.band:.3g} Hz"
    label_above(whole, f"{Path(replay.name).name}: torque that was needed ({replay.unit}){band}; shaded: the close-up")
    for name, axes in zip(names, near, strict=True):
        _draw(axes, time, series.needed, NEEDED)
        _draw(axes, time, series.feedforward[name], LOOKS[name])
        axes.set_xlim(start, stop)
        label_above(axes, f"close-up ({replay.unit}): {LOOKS[name]['label']}")
    for name, axes in zip(names, left, strict=True):
        _draw(axes, time, series.left[name], LOOKS[name])
        label_above(axes, f"torque left to the feedback ({replay.unit}): {LOOKS[name]['label']}")
        _limit(axes, [series.left[other] for other in names])
    for axes in (whole, *left):
        axes.set_xlim(float(time[0]), float(time[-1]))
    panels[-1].set_xlabel("time (s)")
    explain_looks(figure, [NEEDED, *(LOOKS[name] for name in names)])
    return figure


def elapsed(time: Series) -> Series:
    """Return times that ascend: where a clock jumps back or is unknown, it goes on by its usual step."""
    with np.errstate(invalid="ignore"):
        steps = np.diff(time)
    forward = steps[np.isfinite(steps) & (steps > 0.0)]
    usual = float(np.median(forward)) if forward.size else 1.0
    start = float(time[0]) if np.isfinite(time[0]) else 0.0
    return np.concatenate([[start], start + np.cumsum(np.where((steps > 0.0) & np.isfinite(steps), steps, usual))])


def _draw(axes: Axes, time: Series, extremes: Array, look: Look) -> None:
    """Draw both ends of each bin in turn; of bins of one sample they are the same."""
    low, high = extremes
    if np.array_equal(low, high, equal_nan=True):
        draw_series(axes, time, low, look)
    else:
        draw_series(axes, np.repeat(time, 2), extremes.T.ravel(), look)


def _close_up(time: Series, needed: Array) -> tuple[float, float]:
    """Return a stretch around the place where the torque changes most."""
    mean = np.mean(needed, axis=0)
    reach = max(1, mean.size // 400)
    change = np.abs(mean[reach:] - mean[:-reach])
    place = int(np.nanargmax(change)) + reach // 2 if np.any(np.isfinite(change)) else mean.size // 2
    half = 0.5 * CLOSE_UP * float(time[-1] - time[0])
    start = min(max(float(time[place]) - half, float(time[0])), float(time[-1]) - 2.0 * half)
    return start, start + 2.0 * half


def _limit(axes: Axes, series: Sequence[Array]) -> None:
    """Keep a few peaks from pressing the rest flat."""
    values = np.concatenate([np.abs(part).ravel() for part in series])
    values = values[np.isfinite(values)]
    if values.size:
        limit = 1.3 * float(np.quantile(values, 0.998))
        if limit > 0.0:
            axes.set_ylim(-limit, limit)


def _estimates(replay: Replay) -> Figure:
    time = elapsed(replay.series.time)
    histories = replay.series.estimates
    names = list(next(iter(histories.values())))
    figure, panels = make_panels(len(names), 1.1 * len(names) + 0.8)
    for axes, name in zip(panels, names, strict=True):
        for which, history in histories.items():
            draw_series(axes, time, history[name], LOOKS[which])
        log = f"{Path(replay.name).name}: " if axes is panels[0] else ""
        label_above(axes, f"{log}{name.replace('_', ' ')} ({replay.units[name]})")
    panels[-1].set_xlim(float(time[0]), float(time[-1]))
    panels[-1].set_xlabel("time (s)")
    explain_looks(figure, [LOOKS[which] for which in histories])
    return figure
