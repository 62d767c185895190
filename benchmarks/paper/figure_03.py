"""Fig. 3: motion reversal as (4) sees it, and what the spurious sign of friction costs."""

from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullLocator

from adaptive_ff.learning.batch_least_squares import Array
from adaptive_ff.report.style import INK, QUIET, STYLE, WIDTH
from benchmarks.paper.drawing import SERIES, TORQUE_FORM, TRUTH, Look, label, legend
from benchmarks.paper.identification_data import PERIOD, SOLVER_PERIOD, TRUE, Data
from benchmarks.paper.prediction import FIRST
from benchmarks.paper.reversal_errors import KINDS, Reversals, kinds_of

CLEAR = 6  # samples
SHORTEST_REST, LONGEST_REST = 4, 8  # samples
CREEP = 1e-3  # rad/s; between two samples that are slower, friction is not drawn: it is what the torque makes it
FAST, SLOW = (5, 8), (7, 13)  # samples shown before and after the reversal was sampled
SPURIOUS, REST = "#e8d9f2", "#ececec"
SHADES = dict(zip(KINDS, (SERIES["color"], "#b79fd0", "#cfcfcf", "#f0f0f0"), strict=True))
NAMES = {
    "reversal": "spurious sign",
    "next": "next sample",
    "rest": "at rest",
    "sliding": "sliding",
}
PLACES = {"reversal": (4.9, 18.0, "#ffffff"), "next": (4.75, 64.5, INK), "rest": (1.9, 70.0, INK)}
TILTS = {"next": 43.0}  # degrees, along its band
CENTRED: Any = {"horizontalalignment": "center", "verticalalignment": "center"}
SAMPLES: Look = {**SERIES, "marker": "o", "markersize": 4.0, "linestyle": "none", "label": "samples"}
CHARGED: Look = {**SERIES, "linewidth": 1.4, "label": "friction that (4) charges, F(w(k-1))"}
TRUE_FRICTION: Look = {**TRUTH, "label": "simulated joint: w, F(w)"}
TORQUE: Look = {"color": INK, "linewidth": 0.9, "label": "torque u"}
BAND: Look = {"marker": "s", "markersize": 9.0, "linestyle": "none"}
SPURIOUS_LOOK: Look = {**BAND, "color": SPURIOUS, "label": "(4) has the wrong sign"}
REST_LOOK: Look = {**BAND, "color": REST, "label": "(4) has none: w(k-1) = 0"}
CURRENT: Look = {**SERIES, "linestyle": (0, (4, 2)), "label": "(4) with the sign of w(k)"}


def draw(data: Data, found: list[Reversals]) -> Figure:
    """Draw two reversals, and how the error depends on reversal speed.

    Parameters
    ----------
    data : Data
        A record with fast and slow reversals.
    found : list of Reversals
        Errors for several reversal speeds.
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 7.6), layout="constrained")
        figure.get_layout_engine().set(h_pad=0.08, w_pad=0.08)
        grid = figure.subplots(3, 2, gridspec_kw={"height_ratios": (0.8, 0.8, 1.1)})
        _draw_reversal(grid[:2, 0], data, fast_reversal(data.velocity), FAST, "fast reversal")
        _draw_reversal(grid[:2, 1], data, slow_reversal(data.velocity), SLOW, "reversal through rest")
        _draw_shares(grid[2, 0], found)
        _draw_sizes(grid[2, 1], found)
        legend(figure, [TRUE_FRICTION, SAMPLES, CHARGED, TORQUE, SPURIOUS_LOOK, REST_LOOK])
    return figure


def friction(velocity: Array) -> Array:
    """Return the static friction torque (N m) of the true joint, zero at rest as (4) has it."""
    share = np.exp(-((np.abs(velocity) / TRUE.stribeck_velocity) ** TRUE.stribeck_shape))
    level: Array = np.sign(velocity) * (TRUE.coulomb + (TRUE.stiction - TRUE.coulomb) * share) + TRUE.viscous * velocity
    return level


def fast_reversal(velocity: Array) -> int:
    """Return the sample after the fastest reversal around which the velocity keeps its sign for some samples."""
    best, fastest = 0, 0.0
    for k in np.flatnonzero(kinds_of(velocity)["reversal"]) + FIRST:
        before, after = velocity[k - CLEAR : k], velocity[k : k + CLEAR]
        speed = abs(velocity[k] - velocity[k - 1])
        if k > CLEAR and np.all(before * before[-1] > 0.0) and np.all(after * after[0] > 0.0) and speed > fastest:
            best, fastest = int(k), float(speed)
    return best


def slow_reversal(velocity: Array) -> int:
    """Return the first sample at rest of the first reversal through a short rest."""
    resting = np.concatenate([[False], velocity == 0.0, [False]])
    starts, ends = (np.flatnonzero(np.diff(resting.astype(int)) == sign) for sign in (1, -1))
    for start, end in zip(starts, ends, strict=True):
        if start > 2 * CLEAR and SHORTEST_REST <= end - start <= LONGEST_REST and end + CLEAR < velocity.size:
            before, after = velocity[start - CLEAR], velocity[end + CLEAR - 1]
            if before * after < 0.0 and min(abs(before), abs(after)) > TRUE.stribeck_velocity:
                return int(start)
    return fast_reversal(velocity)


def _draw_reversal(panels: Any, data: Data, sample: int, shown: tuple[int, int], title: str) -> None:
    upper, lower = panels
    parts = round(PERIOD / SOLVER_PERIOD)
    first, last = sample - shown[0], sample + shown[1]
    fine = data.fine_velocity[first * parts : last * parts + 1]
    fine_time = 1e3 * SOLVER_PERIOD * (np.arange(fine.size) - (sample - first) * parts)
    time = 1e3 * PERIOD * (np.arange(first, last + 1) - sample)
    velocity = data.velocity[first : last + 1]
    charged = friction(data.velocity[first - 1 : last])
    still = np.abs(velocity) < CREEP
    resting = np.append(np.repeat(still[:-1] & still[1:], parts), False) | (fine == 0.0)
    upper.plot(fine_time, fine, **TRUTH)
    upper.plot(time, velocity, **SAMPLES)
    lower.plot(fine_time, np.where(resting, np.nan, friction(fine)), **TRUTH)
    lower.step(time, charged, where="pre", **CHARGED)
    lower.step(time, data.acting[first : last + 1], where="pre", **TORQUE)
    for axes in (upper, lower):
        axes.axhline(0.0, color=QUIET, linewidth=0.8)
        axes.set_xlim(time[0], time[-1])
        for start, end, old, new in zip(time[:-1], time[1:], charged[1:], friction(velocity)[1:], strict=True):
            if old * new < 0.0 or old == 0.0:
                axes.axvspan(start, end, color=SPURIOUS if old else REST, linewidth=0.0)
    upper.tick_params(labelbottom=False)
    label(upper, f"{title}: velocity (rad/s)")
    label(lower, "torque (N m)", "time (ms)")


def _draw_shares(axes: Axes, found: list[Reversals]) -> None:
    speeds = [reversals.speed for reversals in found]
    base = np.zeros(len(found))
    for kind in KINDS:
        share = 100.0 * np.array([reversals.shares[kind] for reversals in found])
        axes.fill_between(speeds, base, base + share, color=SHADES[kind], linewidth=0.0)
        if kind in PLACES:
            x, y, colour = PLACES[kind]
            axes.text(x, y, NAMES[kind], color=colour, fontsize=8.0, **CENTRED, rotation=TILTS.get(kind, 0.0))
        base = base + share
    axes.set_ylim(0.0, 100.0)
    _speed_axis(axes, speeds)
    label(axes, "share of the squared one-step error of (4) (%)", "reversal speed (rad/s²)")


def _draw_sizes(axes: Axes, found: list[Reversals]) -> None:
    speeds = [reversals.speed for reversals in found]
    curves = (
        ([reversals.current_sign for reversals in found], CURRENT),
        ([reversals.sizes["reversal"] for reversals in found], {**SERIES, "label": "(4), sign of w(k-1)"}),
        ([reversals.form for reversals in found], {**TORQUE_FORM, "label": "torque form, simulated"}),
    )
    for values, look in curves:
        axes.plot(speeds, 1e3 * np.array(values), **{**look, "marker": "o", "markersize": 3.5})
    axes.set_yscale("log")
    axes.set_ylim(0.1, 300.0)
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    _speed_axis(axes, speeds)
    label(axes, "one-step error on reversals (mrad/s rms)", "reversal speed (rad/s²)")
    legend(axes, [look for _, look in curves], loc="upper right", fontsize=8.0)


def _speed_axis(axes: Axes, speeds: list[float]) -> None:
    axes.set_xscale("log")
    axes.set_xlim(speeds[0], speeds[-1])
    axes.set_xticks([1, 2, 3, 4, 5, 6, 7], ["1", "2", "3", "4", "5", "6", "7"])
    axes.xaxis.set_minor_locator(NullLocator())
