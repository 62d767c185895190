"""Pictures of an identified log."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from adaptive_ff.identify.fitting.prediction import Prediction
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.identify.terms import BENT, GRAVITY, SATURATIONS, bent_friction, is_mapped
from adaptive_ff.report.drawing import (
    INK,
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
from adaptive_ff.report.framing import name_those_beyond
from adaptive_ff.report.identified_map_picture import draw_identified_map

MEASURED: Look = {"color": "#a6a6a6", "linewidth": 2.0, "label": "measured"}
MODEL: Look = {"color": "#d55e00", "linewidth": 1.0, "label": "inertia and friction as identified"}
LEFT: Look = {"color": "#0072b2", "linewidth": 0.8, "label": "measured − identified"}
HELD_OUT: Look = {"color": "#d9d9d9", "linewidth": 6.0, "label": "held out"}
ROWS: Look = {"color": "#9ec5e0", "marker": ".", "markersize": 2.5, "linestyle": "", "label": "rows of the log"}
MEANS: Look = {"color": "#0072b2", "marker": "o", "markersize": 3.5, "linestyle": "", "label": "mean in a bin"}
POINTS: Look = {"color": INK, "marker": "D", "markersize": 4.0, "linestyle": "", "label": "constant speed"}
PROFILE: Look = {"color": "#7b5aa6", "linewidth": 1.3, "label": "torque left unexplained"}
INTERVAL: Look = {"color": "#d55e00", "linewidth": 1.0, "linestyle": (0, (3, 2)), "label": "lag and its interval"}

PICTURES = ("identified_torque", "friction", "lag", "identified_map")
"""Names of the pictures of an identified log; without a map of friction or force it has not the last one."""

CLOSE_UP = 0.08
"""Length of the close-up, over that of all pieces of the log; around the row of the fastest reversal."""

BINS, FEWEST = 40, 5
"""Bins of the velocity, and rows that one must have to be shown."""


def plot_identification(found: LogIdentification, folder: str | Path | None = None) -> dict[str, Figure]:
    """Draw the report of an identified log.

    Parameters
    ----------
    found : LogIdentification
        The joint.
    folder : str or Path, optional
        Where to write each picture as ``NAME.png``; it is made where it is missing.

    Returns
    -------
    dict of Figure
        ``identified_torque``: torque over time, measured and identified, with what is held out; ``friction``: friction
        and residual over the velocity; ``lag``: what each friction lag would leave unexplained; ``identified_map``:
        friction and force over position, where the model has a map of them.
    """
    with rc_context(STYLE):
        figures = {"identified_torque": _torque(found), "friction": _friction(found), "lag": _lag(found)}
        learnt = draw_identified_map(found)
        if learnt is not None:
            figures["identified_map"] = learnt
        stamp(figures.values(), found.name)
        write_into(figures, folder)
    return figures


def _torque(found: LogIdentification) -> Figure:
    figure, (whole, near, left) = make_panels(3, 7.0, shared=False)
    parts = _in_order(found)
    for rows, start in parts:
        for axes in (whole, near):
            draw_series(axes, start, rows.torque, MEASURED)
            draw_series(axes, start, np.where(rows.slides, rows.fitted, np.nan), MODEL)
        draw_series(left, start, np.where(rows.slides, rows.torque - rows.fitted, np.nan), LEFT)
    keys = [MEASURED, MODEL, LEFT]
    end = float(parts[-1][1][-1])
    if found.held_out:
        first = float(parts[len(found.rows)][1][0])
        for axes in (whole, left):
            axes.axvspan(first, end, color="#ececec", zorder=0.4)
        keys.append(HELD_OUT)
    unit = found.units["torque"]
    near.set_xlim(*_close_up(found, parts))
    label_above(whole, f"{Path(found.name).name}: torque ({unit}) in a band of {found.bandwidth:.3g} Hz")
    label_above(near, f"torque ({unit}), close-up around a reversal; rows at rest are without model")
    label_above(left, f"residual ({unit})")
    for axes in (whole, left):
        axes.set_xlim(float(parts[0][1][0]), end)
    left.set_xlabel(_time_label(found))
    explain_looks(figure, keys)
    return figure


def _time_label(found: LogIdentification) -> str:
    return "time (s)" if found.validated_on == "the end of the log" else "time (s), the other log after the first"


def _in_order(found: LogIdentification) -> list[tuple[Prediction, Series]]:
    """Return all pieces with times that ascend: where a clock jumps back, or another log follows, it is shifted."""
    parts: list[tuple[Prediction, Series]] = []
    last = -np.inf
    for rows in [*found.rows, *found.held_out]:
        time = rows.time if rows.time[0] > last else rows.time - rows.time[0] + last + rows.period
        parts.append((rows, time))
        last = float(time[-1])
    return parts


def _close_up(found: LogIdentification, parts: Sequence[tuple[Prediction, Series]]) -> tuple[float, float]:
    """Return a stretch around the reversal of the fitted rows where the torque changes most, in the piece it is in."""
    length = CLOSE_UP * sum(float(np.ptp(time)) for _, time in parts)
    piece = parts[0][1]
    best, centre = -1.0, float(piece[piece.size // 2])
    for rows, time in parts[: len(found.rows)]:
        turns = np.flatnonzero(np.diff(np.sign(rows.velocity)) != 0.0)
        for turn in turns[rows.slides[turns]]:
            around = rows.torque[max(0, turn - 5) : turn + 6]
            if np.ptp(around) > best:
                best, centre, piece = float(np.ptp(around)), float(time[turn]), time
    first, last = float(piece[0]), float(piece[-1])
    start = max(first, min(centre - 0.5 * length, last - length))
    return start, min(start + length, last)


def _friction(found: LogIdentification) -> Figure:
    figure, (curve, left) = make_panels(2, 6.4)
    velocity = np.concatenate([rows.velocity[rows.slides] for rows in found.rows])
    friction = np.concatenate([rows.friction[rows.slides] for rows in found.rows])
    residual = np.concatenate([(rows.torque - rows.fitted)[rows.slides] for rows in found.rows])
    without = "inertia"
    if any(term in GRAVITY or is_mapped(term) for term in found.selection.chosen.terms):
        friction = _curve(found, np.abs(velocity), np.sign(velocity)) + residual
        without = "inertia and what depends on the position"
    every = max(1, velocity.size // 5000)
    for axes, values in ((curve, friction), (left, residual)):
        axes.plot(velocity[::every], values[::every], **ROWS)
        _draw_means(axes, velocity, values)
    drawn = _draw_curve(curve, found, velocity)
    keys = [ROWS, MEANS, MODEL]
    points = found.curve.points
    if points is not None:
        curve.errorbar(
            points.velocity, points.torque, 2.0 * points.standard_error, **POINTS, elinewidth=0.8, zorder=3.0
        )
        keys.append(POINTS)
    left.axhline(0.0, **MODEL)
    low, high = np.quantile(friction, (0.002, 0.998))
    margin = 0.15 * (high - low)
    curve.set_ylim(low - margin, high + margin)
    name_those_beyond(curve, {"the identified curve": drawn}, max(abs(low - margin), abs(high + margin)))
    label_above(
        curve,
        f"{Path(found.name).name}: torque without {without} ({found.units['torque']}), while sliding, offset included",
    )
    label_above(left, f"measured − identified ({found.units['torque']})")
    left.set_xlabel(f"velocity ({found.units['velocity']})")
    explain_looks(figure, keys)
    return figure


def _draw_means(axes: Axes, velocity: Series, values: Series) -> None:
    """Draw the mean in each bin of the velocity."""
    edges = np.linspace(velocity.min(), velocity.max(), BINS + 1)
    place = np.clip(np.digitize(velocity, edges) - 1, 0, BINS - 1)
    count = np.bincount(place, minlength=BINS)
    shown = count >= FEWEST
    centre = np.bincount(place, velocity, BINS)[shown] / count[shown]
    axes.plot(centre, np.bincount(place, values, BINS)[shown] / count[shown], **MEANS)


def _draw_curve(axes: Axes, found: LogIdentification, velocity: Series) -> Series:
    """Draw the friction curve of the model over the velocities of the log, in each direction; return its values."""
    drawn = []
    for side in (-1.0, 1.0):
        seen = side * velocity[side * velocity > 0.0]
        if seen.size:
            slowest, fastest = float(np.min(seen)), float(np.max(seen))
            speeds = slowest + (fastest - slowest) * np.linspace(0.0, 1.0, 400) ** 2
            drawn.append(_curve(found, speeds, side))
            axes.plot(side * speeds, drawn[-1], **{**MODEL, "zorder": 2.6})
    return np.concatenate(drawn)


def _curve(found: LogIdentification, speeds: Series, side: float | Series) -> Series:
    """Return the friction of the model over the speed in one direction, with the offset."""
    values = found.selection.chosen.values
    excess = values.get("stiction_excess", 0.0)
    saturated = np.zeros_like(speeds)
    for shape in SATURATIONS:
        if shape in values:
            saturated += values[shape] * bent_friction(shape, speeds, values[BENT[shape]])
    share = np.exp(-speeds / values.get("stribeck_velocity", np.inf))
    friction = values["coulomb"] + values["viscous"] * speeds + excess * share + saturated
    level = values.get("offset", 0.0) + values.get("viscous_asymmetry", 0.0) * speeds
    curve: Series = level + side * friction
    return curve


def _lag(found: LogIdentification) -> Figure:
    figure, (axes,) = make_panels(1, 3.2)
    axes.plot(1e3 * found.lags, 100.0 * found.lag_errors, **PROFILE)
    keys = [PROFILE]
    if "friction_lag" in found.parameters:
        estimate = found.parameters["friction_lag"].estimate
        axes.axvline(1e3 * estimate.value, **INTERVAL)
        axes.axvspan(1e3 * estimate.lower, 1e3 * estimate.upper, color="#f6ddcc", zorder=0.4)
        keys.append(INTERVAL)
    axes.set_xlim(1e3 * float(found.lags[0]), 1e3 * float(found.lags[-1]))
    label_above(axes, f"{Path(found.name).name}: torque left unexplained (%), everything else fitted anew at each lag")
    axes.set_xlabel("friction lag (ms); negative: friction leads the motion")
    explain_looks(figure, keys)
    return figure
