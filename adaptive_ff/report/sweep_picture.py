"""Picture of a sweep: how the figures are distributed over the drawn joints, and where the worst ones are."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from adaptive_ff.report.drawing import INK, QUIET, STYLE, Look, explain_looks, label_above, stamp, write_figure
from adaptive_ff.report.framing import plain_name
from adaptive_ff.studies.drawn_joints import CONTROLLERS, HUNTING
from adaptive_ff.studies.sweep import Outcome

ADAPTIVE: Look = {"color": "#d55e00", "label": "adaptive"}
OWN_COLOURS = ("#0072b2", "#cc79a7", "#009e73", "#b89b00")
SAME: Look = {"color": INK, "linewidth": 1.0, "linestyle": (0, (3, 2)), "label": "the same as pi"}
NAME_ABOVE, NAME_WIDTH, NAME_HEIGHT = 6.0, 44.0, 9.0
"""How far above its place the name of a worst case begins, and the room for it, points."""

WORST: Look = {"marker": "o", "linestyle": "", "markersize": 8.0, "markerfacecolor": "none", "color": INK}


def plot_sweep(outcomes: Sequence[Outcome], source: str, worst: int = 3, path: Path | None = None) -> Figure | None:
    """Draw the distributions of a sweep and its worst cases.

    Parameters
    ----------
    outcomes : sequence of Outcome
        The outcomes; refused ones are left out.
    source : str
        Scenario and seed, for the line below the picture.
    worst : int, optional
        How many of the worst cases are marked with the number of their draw.
    path : Path, optional
        Where to write the picture.

    Returns
    -------
    Figure or None
        Settled improvement and whole-run error against ``pi``, each as a share of the joints that is at most so good or
        so bad; the whole-run error over the fall of the friction. None where no joint ran.
    """
    run = [outcome for outcome in outcomes if not outcome.refused]
    if not run:
        return None
    own = dict.fromkeys(name for outcome in run for name in outcome.metrics if name not in CONTROLLERS)
    looks: dict[str, Look] = {"adaptive": ADAPTIVE}
    for place, name in enumerate(own):
        looks[name] = {"color": OWN_COLOURS[place % len(OWN_COLOURS)], "label": plain_name(name)}
    with rc_context(STYLE):
        figure = Figure(figsize=(8.0, 6.4), layout="constrained")
        grid = figure.add_gridspec(2, 2)
        settled, whole = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[0, 1])
        cases = figure.add_subplot(grid[1, :])
        for name, look in looks.items():
            ran = [outcome for outcome in run if name in outcome.metrics]
            _share(settled, [outcome.ratio("rms_error_settled", "pi", name) for outcome in ran], look)
            ratios = [outcome.ratio("rms_error", name, "pi") for outcome in ran]
            _share(whole, ratios, look)
            cases.plot([outcome.fall for outcome in ran], ratios, ".", color=look["color"], alpha=0.6, zorder=2.2)
        marked = sorted(run, key=lambda outcome: -outcome.ratio("rms_error", "adaptive", "pi"))[:worst]
        places = {f"draw {one.draw}": (one.fall, one.ratio("rms_error", "adaptive", "pi")) for one in marked}
        for case in places.values():
            cases.plot(*([number] for number in case), **WORST)
        for axes, line in ((settled, settled.axvline), (whole, whole.axvline), (cases, cases.axhline)):
            line(1.0, **SAME)
            _ratios(axes, "y" if axes is cases else "x")
        _make_room(cases, places)
        cases.axvline(HUNTING, color=QUIET, linewidth=1.0, linestyle=":")
        cases.set_xscale("symlog", linthresh=HUNTING)
        cases.set_xlim(-0.1, 2.0 * max(HUNTING, *(outcome.fall for outcome in run)))
        cases.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        _name(cases, places)
        label_above(settled, f"share of {len(run)} joints (%)")
        label_above(whole, "share of the joints (%)")
        label_above(cases, "whole run: error over that of pi; worst cases of adaptive marked")
        settled.set_xlabel("settled: error of pi over own (more is better)")
        whole.set_xlabel("whole run: error over that of pi (less is better)")
        cases.set_xlabel("steepest fall of friction over Kp; right of the dotted line pi itself hunts")
        key: Look = {**WORST, "label": f"the {len(marked)} worst: worst-1.toml and on"}
        explain_looks(figure, [*looks.values(), SAME, key])
        stamp([figure], source)
        if path is not None:
            write_figure(figure, path)
    return figure


def _make_room(axes: Axes, places: Mapping[str, tuple[float, float]]) -> None:
    """Raise the upper limit so far that the names of the places, one above the other, stay below it."""
    low, high = axes.get_ylim()
    room = (NAME_ABOVE + NAME_HEIGHT * (len(places) + 1)) * axes.figure.dpi / 72.0 / axes.get_window_extent().height
    axes.set_ylim(
        top=max(high, max((up for _, up in places.values()), default=low) * (high / low) ** (room / (1.0 - room)))
    )


def _name(axes: Axes, places: Mapping[str, tuple[float, float]]) -> None:
    """Write names above their places, given in data; where two would overlap, the later one goes further up."""
    written: list[tuple[float, float]] = []
    for name, place in places.items():
        across, up = axes.transData.transform(place) * 72.0 / axes.figure.dpi
        above = NAME_ABOVE
        while any(abs(across - x) < NAME_WIDTH and abs(up + above - y) < NAME_HEIGHT for x, y in written):
            above += 1.0
        written.append((across, up + above))
        text = axes.annotate(name, place, (0.0, above), textcoords="offset points", size=8.0, ha="center")
        text.set_path_effects([withStroke(linewidth=2.5, foreground="white")])


def _share(axes: Axes, values: Sequence[float], look: Look) -> None:
    """Draw the share of joints whose value is at most so large."""
    ordered = np.sort(np.asarray(values, dtype=float))
    if ordered.size:
        shares = 100.0 * np.arange(ordered.size + 1) / ordered.size
        axes.plot([ordered[0], *ordered], shares, drawstyle="steps-post", linewidth=1.5, color=look["color"])
        axes.set_ylim(0.0, 102.0)


def _ratios(axes: Axes, which: Literal["x", "y"]) -> None:
    """Make an axis of ratios logarithmic, at least from a half to two."""
    axes.set(**{f"{which}scale": "log"})
    low, high = axes.get_ylim() if which == "y" else axes.get_xlim()
    low, high = min(low, 0.5), max(high, 2.0)
    axes.set(**{f"{which}lim": (low, high)})
    axis = axes.yaxis if which == "y" else axes.xaxis
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if math.log10(high / low) < 2.5 else (1.0,)))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
