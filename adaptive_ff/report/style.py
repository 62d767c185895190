"""One style for all pictures: panels with their labels above them, one legend, limits that show what matters, files.

No ``pyplot``: figures open no window and leave no state behind. A long series is drawn as the smallest and largest
value of each column of the picture, so no peak is lost. A curve that leaves its panel is named above it.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.layout_engine import LayoutEngine
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullLocator
from matplotlib.transforms import ScaledTranslation
from numpy.typing import NDArray

from adaptive_ff import __version__
from adaptive_ff.errors import InputError, checked_path
from adaptive_ff.files import staged

Series = NDArray[np.float64]
Look = Mapping[str, Any]

COLUMNS = 2000  # that a long series is thinned to: more than a picture has pixels across

WIDTH = 8.0  # inches of a figure
MOST = 110  # characters of the line below, of the end of a longer one
SIZE, SMALL = 9.0, 6.5  # points of letters, and of those of the line below
LINE = 1.25 * SIZE  # points of a line of text
LIFT = 5.0  # points between a panel and its label
TICK = 3.5  # points of a tick, and between it and its label
INK, QUIET = "#222222", "#8a8a8a"

STYLE: Any = {
    **dict.fromkeys(("axes.edgecolor", "xtick.color", "ytick.color"), QUIET),
    **dict.fromkeys(("axes.labelcolor", "xtick.labelcolor", "ytick.labelcolor", "text.color"), INK),
    **dict.fromkeys(("axes.spines.top", "axes.spines.right", "legend.frameon"), False),
    **dict.fromkeys(("axes.grid", "axes.axisbelow"), True),
    **{"grid.color": "#e6e6e6", "grid.linewidth": 0.6, "lines.linewidth": 1.0, "font.size": SIZE},
    **{"axes.labelsize": SIZE, "xtick.labelsize": SIZE, "ytick.labelsize": SIZE, "legend.fontsize": SIZE},
}

MEASURED: Look = {"color": "#a6a6a6", "linewidth": 2.0, "label": "measured"}
TRUTH: Look = {"color": "#000000", "linestyle": (0, (3, 2)), "zorder": 2.6, "label": "true"}
LIMIT: Look = {"color": INK, "linewidth": 0.8, "linestyle": (0, (6, 2, 1, 2)), "label": "limit"}

UNBOUNDED = "adaptive_paper"
"""Its estimates and torques leave all bounds at times; the limits are set by the others where there are any."""


@dataclass
class Panel:
    """A panel of a picture."""

    label: str  # what stands above it: quantity and unit
    curves: Sequence[tuple[Series, Series, Look]]  # what is drawn
    lines: Sequence[tuple[float, Look]] = ()  # horizontal lines
    # limits of the horizontal and the vertical axis
    span: tuple[float, float] | None = None
    limits: tuple[float, float] | None = None
    # what the vertical limits, fitted to the curves, do not exceed; curves that leave them are named
    cap: float | None = None
    inside: Sequence[float] | Series = ()  # what they hold beside the curves
    since: float | None = None  # makes it logarithmic, down to the least that is drawn since a time
    bands: Sequence[tuple[Series, Series, Series, str]] = ()  # times, lower and upper ends, colour
    shaded: tuple[float, float] | None = None  # part of the horizontal axis

    @property
    def looks(self) -> list[Look]:
        """Looks of curves and lines."""
        return [*(look for *_, look in self.curves), *(look for _, look in self.lines)]


def picture(
    panels: Sequence[Panel],
    height: float,
    xlabel: str = "time (s)",
    *,
    source: str = "",
    keys: Iterable[Look] | None = None,
    marks: Sequence[tuple[float, Look]] = (),
    shared: bool = True,
) -> tuple[Figure, list[Axes]]:
    """Draw panels below each other, in a height (inches), with one legend of the keys, by default of all looks.

    They share one horizontal axis where that is said, else those below each other that have one span. ``marks`` are
    vertical lines through all of them; ``source`` is what the picture is of, for the line below it.
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, height), layout=Rows())
        drawn = list(figure.subplots(len(panels), 1, sharex=shared, squeeze=False)[:, 0])
        for axes, panel in zip(drawn, panels, strict=True):
            axes.yaxis.set_major_locator(MaxNLocator(5 if len(panels) > 1 else 8, steps=[1, 2, 2.5, 5, 10]))
            axes.ticklabel_format(style="plain", useOffset=False)
            _draw(axes, panel)
            for place, look in marks:
                axes.axvline(place, **look)
        for axes, panel, below in zip(drawn, panels, [*panels[1:], None], strict=True):
            last = below is None or not (shared or (below.span is not None and below.span == panel.span))
            axes.tick_params(labelbottom=last)
            axes.set_xlabel(xlabel if last else "")
        explain_looks(figure, [look for panel in panels for look in panel.looks] if keys is None else keys)
        if source:
            stamp([figure], source)
    return figure, drawn


def _draw(axes: Axes, panel: Panel) -> None:
    for time, values, look in panel.curves:
        kept = thinned(values)
        axes.plot(time[kept], values[kept], **look)
    for level, look in panel.lines:
        axes.axhline(level, **look)
    for time, low, high, colour in panel.bands:
        axes.fill_between(time, low, high, color=colour, alpha=0.25, lw=0.0)
    if panel.shaded is not None:
        axes.axvspan(*panel.shaded, color="#ececec", zorder=0.4)
    if panel.cap is not None:
        curves = {str(look.get("label", "")): values for _, values, look in panel.curves}
        frame([axes], {"": np.asarray(panel.inside), **curves}, panel.cap)
    if panel.since is not None:
        _make_logarithmic(axes, panel, panel.since)
    if panel.limits is not None:
        axes.set_ylim(panel.limits)
    if panel.span is not None:
        axes.set_xlim(panel.span)
    label_above(axes, panel.label)


def thinned(values: Series) -> slice | NDArray[np.intp]:
    """Return which values of a series are drawn, of a long one the extremes of each column in their order."""
    width = values.size // COLUMNS
    if width <= 3:
        return slice(None)
    whole = values.size // width * width
    columns = values[:whole].reshape(-1, width)
    extremes = np.sort([columns.argmin(axis=1), columns.argmax(axis=1)], axis=0) + np.arange(0, whole, width)
    return np.concatenate([extremes.T.ravel(), np.arange(whole, values.size)])


def label_above(axes: Axes, text: str) -> None:
    """Label the vertical axis, above it, where it is read without turning the head."""
    axes.set_ylabel(text, rotation=0.0, horizontalalignment="left", verticalalignment="baseline")
    lift = ScaledTranslation(0.0, LIFT / 72.0, axes.figure.dpi_scale_trans)
    axes.yaxis.set_label_coords(0.0, 1.0, transform=axes.transAxes + lift)


def explain_looks(figure: Figure, looks: Iterable[Look]) -> None:
    """Explain looks by their labels above all panels, where no data are, in as many rows as it takes."""
    named = {str(look["label"]): look for look in looks if look.get("label")}
    handles = [Line2D([], [], **look) for look in named.values()]
    widths = [0.5 + 0.075 * len(str(handle.get_label())) for handle in handles]  # roughly, in inches
    rows = math.ceil(sum(widths) / WIDTH)
    columns = len(handles) if rows == 1 else min(math.ceil(len(handles) / rows), int(WIDTH / max(widths)))
    figure.legend(handles=handles, loc="outside upper center", ncols=max(1, columns), handlelength=1.7)


class Rows(LayoutEngine):
    """Margins of panels below each other, by the letters in them: a constrained layout draws all twice to measure."""

    _adjust_compatible = _colorbar_gridspec = False

    def execute(self, fig: Figure) -> None:
        """Place the panels of a figure, all of one height."""
        width, height = (72.0 * float(side) for side in fig.get_size_inches())
        left = max(_width_of(axes.yaxis) for axes in fig.axes) + 3.0 * TICK
        right = 0.5 * max(_width_of(axes.xaxis) for axes in fig.axes) + TICK
        below = [_height_below(axes) for axes in fig.axes]
        end = height - TICK - sum(72.0 / fig.dpi * one.get_window_extent().height for one in fig.legends)
        high = (end - sum(below) - 2.0 * SMALL) / len(below) - LIFT - LINE
        for axes, under in zip(fig.axes, below, strict=True):
            end -= LIFT + LINE + high
            axes.set_position((left / width, end / height, 1.0 - (left + right) / width, high / height))
            end -= under


def _width_of(axis: Axis) -> float:
    """Return the width of the widest label of an axis, roughly, in points."""
    labels = axis.get_major_formatter().format_ticks(list(axis.get_majorticklocs()))
    return 0.65 * SIZE * max(map(len, labels), default=0)


def _height_below(axes: Axes) -> float:
    """Return the height of ticks, their labels and the axis label below a panel, in points."""
    labels = LINE + TICK if axes.xaxis.get_tick_params().get("labelbottom", True) else 0.0
    return 1.5 * TICK + labels + (LINE + TICK if axes.get_xlabel() else 0.0)


def plain_name(name: str) -> str:
    """Return a name in which matplotlib sees no mathematics, and which it does not hide for a leading underscore."""
    return (f" {name}" if name.startswith("_") else name).replace("$", r"\$")


def peak_of(values: Series) -> float:
    """Return the largest magnitude of what is finite."""
    return float(np.max(np.abs(values), where=np.isfinite(values), initial=0.0))


def typical_peak(curves: Mapping[str, Series]) -> float:
    """Return the median peak of some curves, of two the smaller."""
    return sorted(map(peak_of, curves.values()))[(len(curves) - 1) // 2]


def frame(panels: Sequence[Axes], curves: Mapping[str, Series], cap: float) -> None:
    """Fit the limits of panels to curves, but not beyond a cap; name the curves that leave them."""
    cap = cap or math.inf
    bounded = {name: curve for name, curve in curves.items() if not name.endswith(UNBOUNDED)}
    values = np.concatenate(list((bounded if any(bounded) else curves).values()))
    values = np.clip(values[np.isfinite(values)], -cap, cap)
    low, high = float(np.min(values)), float(np.max(values))
    margin = 0.06 * (high - low) or 0.1 * abs(high) or 1.0
    for axes in panels:
        axes.set_ylim(low - margin, high + margin)
    name_those_beyond(panels[0], curves, max(abs(low), abs(high)) + margin)


def name_those_beyond(axes: Axes, curves: Mapping[str, Series], limit: float) -> None:
    """Name above a panel the curves that leave it, and how far they go."""
    peaks = {name: peak_of(curve) for name, curve in curves.items() if peak_of(curve) > limit}
    gone = [f"{name} reaches {f'{peak:,.0f}' if 1e3 <= peak < 1e6 else f'{peak:.3g}'}" for name, peak in peaks.items()]
    more = f" and {len(gone) - 2} more" if len(gone) > 2 else ""
    place: Any = {"xycoords": "axes fraction", "xytext": (0.0, LIFT), "textcoords": "offset points"}
    axes.annotate(", ".join(gone[:2]) + more, (1.0, 1.0), **place, ha="right", fontsize=8.0, color=QUIET)


def _make_logarithmic(axes: Axes, panel: Panel, since: float) -> None:
    """Make a panel logarithmic, one to four decades, down to what it shows since a time; leave it where all is zero."""
    curves = {str(look["label"]): (time, values) for time, values, look in panel.curves}
    bounded = [curve for name, curve in curves.items() if name != UNBOUNDED] or list(curves.values())
    top = max(float(np.max(values)) for _, values in bounded)
    if top == 0.0:
        return
    if UNBOUNDED in curves:
        name_those_beyond(axes, {UNBOUNDED: curves[UNBOUNDED][1]}, 1.3 * top)
    shown = [values[(time >= since) & (values > 0.0)] for time, values in bounded]
    low = min(float(np.min(values, initial=top)) for values in shown)
    low = min(max(low, 1e-4 * top) / 1.3, top / 5.0)
    axes.set_yscale("log", nonpositive="mask")
    axes.set_ylim(low, 1.3 * top)
    label_decades(axes.yaxis, 1.3 * top / low)


def label_decades(axis: Axis, span: float) -> None:
    """Label a logarithmic axis with plain numbers, one to three a decade by how many it spans."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if span < 300.0 else (1.0,)))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))


def stamp(figures: Iterable[Figure], source: str) -> None:
    """Say below each picture where it comes from (scenario and seed, or the log) and which version drew it."""
    text = (source if len(source) <= MOST else f"…{source[-MOST:]}").replace("$", r"\$")
    for figure in figures:
        figure.supxlabel(f"{text}, adaptive-ff {__version__}", x=0.99, ha="right", size=SMALL, color=QUIET)


def write_figures(figures: Mapping[str, Figure], folder: Path, formats: Sequence[str]) -> None:
    """Write pictures as ``NAME.FORMAT`` into a folder, by name and in several formats, such as png."""
    for name, figure in figures.items():
        for ending in formats:
            write_figure(figure, folder / f"{name}.{ending}")


def write_to(figure: Figure, path: str | Path | None) -> None:
    """Write a picture where a path is given: PNG, or what its ending says."""
    if path is None:
        return
    place = checked_path("path", path)
    known = figure.canvas.get_supported_filetypes()
    if place.suffix and place.suffix[1:].lower() not in known:
        raise InputError(f"path = {str(path)!r} is not allowed: it must end in one of {', '.join(known)}")
    write_figure(figure, place)


def write_into(figures: dict[str, Figure], folder: str | Path | None) -> dict[str, Figure]:
    """Write pictures as ``NAME.png`` into a folder, where one is given, and return them; raises as :func:`write_to`."""
    if folder is not None:
        write_figures(figures, checked_path("folder", folder), ("png",))
    return figures


def write_figure(figure: Figure, path: Path) -> None:
    """Write a picture, whole or not at all; raises as :func:`adaptive_ff.files.staged`."""
    engine, ending = figure.get_layout_engine(), path.suffix[1:].lower() or "png"
    more: Any = {"pil_kwargs": {"compress_level": 1}} if ending == "png" else {}  # a tenth larger, twice as fast
    metadata = {"Software" if ending == "png" else "Creator": f"adaptive-ff {__version__}"}
    if engine is not None:
        engine.execute(figure)
    without: Any = dict.fromkeys(("figure.autolayout", "figure.constrained_layout.use"), False)
    try:
        with staged(path.parent, path) as stage, rc_context(without):
            figure.set_layout_engine(None)  # else saving would draw twice, to lay out again
            figure.savefig(stage / path.name, format=ending, dpi=150, metadata=metadata, **more)
    finally:
        figure.set_layout_engine(engine)
