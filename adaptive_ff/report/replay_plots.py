"""Pictures of a replay."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from adaptive_ff.replay.replay import COLD, FIXED, RECORDED, SAVED, Replay
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
    series, time = replay.series, replay.series.time
    names = [name for name in LOOKS if name in series.feedforward]
    figure, panels = make_panels(1 + 2 * len(names), 2.2 + 2.2 * len(names), shared=False)
    whole, near, left = panels[0], panels[1 : 1 + len(names)], panels[1 + len(names) :]
    draw_series(whole, time, series.needed, NEEDED)
    start, stop = _close_up(time, series.needed)
    whole.axvspan(start, stop, color="#ececec", zorder=0.4)
    label_above(
        whole,
        f"{Path(replay.name).name}: torque that was needed ({replay.unit}), band {replay.band:.3g} Hz; "
        "shaded: the close-up",
    )
    for name, axes in zip(names, near, strict=True):
        draw_series(axes, time, series.needed, NEEDED)
        draw_series(axes, time, series.feedforward[name], LOOKS[name])
        axes.set_xlim(start, stop)
        label_above(axes, f"close-up ({replay.unit}): {LOOKS[name]['label']}")
    rest = {name: series.needed - series.feedforward[name] for name in names}
    for name, axes in zip(names, left, strict=True):
        draw_series(axes, time, rest[name], LOOKS[name])
        label_above(axes, f"torque left to the feedback ({replay.unit}): {LOOKS[name]['label']}")
        _limit(axes, list(rest.values()))
    for axes in (whole, *left):
        axes.set_xlim(float(time[0]), float(time[-1]))
    panels[-1].set_xlabel("time (s)")
    explain_looks(figure, [NEEDED, *(LOOKS[name] for name in names)])
    return figure


def _close_up(time: Series, needed: Series) -> tuple[float, float]:
    """Return a stretch around the place where the torque changes most."""
    reach = max(1, needed.size // 400)
    place = int(np.argmax(np.abs(needed[reach:] - needed[:-reach]))) + reach // 2
    half = 0.5 * CLOSE_UP * float(time[-1] - time[0])
    start = min(max(float(time[place]) - half, float(time[0])), float(time[-1]) - 2.0 * half)
    return start, start + 2.0 * half


def _limit(axes: Axes, series: Sequence[Series]) -> None:
    """Keep a few peaks from pressing the rest flat."""
    limit = 1.3 * float(np.quantile(np.abs(np.concatenate(series)), 0.998))
    if limit > 0.0:
        axes.set_ylim(-limit, limit)


def _estimates(replay: Replay) -> Figure:
    time, histories = replay.series.time, replay.series.estimates
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
