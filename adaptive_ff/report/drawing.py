"""What all pictures have in common: panels with their labels above them, one legend, and files written whole.

A long series is drawn as the smallest and largest value of each column of the picture, so no peak is lost.
"""

import math
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import ScaledTranslation
from numpy.typing import NDArray

from adaptive_ff import __version__
from adaptive_ff.errors import InputError, checked_path
from adaptive_ff.files import make_folder

Series = NDArray[np.float64]
Look = Mapping[str, Any]

COLUMNS = 2000  # that a long series is thinned to: more than a picture has pixels across

WIDTH = 8.0  # inches of a figure
LIFT = 5.0  # points between a panel and its label
INK, QUIET = "#222222", "#8a8a8a"

STYLE: Any = {
    **dict.fromkeys(("axes.edgecolor", "xtick.color", "ytick.color"), QUIET),
    **dict.fromkeys(("axes.labelcolor", "xtick.labelcolor", "ytick.labelcolor", "text.color"), INK),
    **dict.fromkeys(("axes.spines.top", "axes.spines.right", "legend.frameon"), False),
    **dict.fromkeys(("axes.grid", "axes.axisbelow"), True),
    **{"grid.color": "#e6e6e6", "grid.linewidth": 0.6, "lines.linewidth": 1.0, "font.size": 9.0},
    **{"axes.labelsize": 9.0, "xtick.labelsize": 9.0, "ytick.labelsize": 9.0, "legend.fontsize": 9.0},
}


def draw_series(axes: Axes, time: Series, values: Series, look: Look) -> Series:
    """Draw a series, a long one as the extremes of each column in their order; return the values drawn."""
    width = values.size // COLUMNS
    if width > 3:
        whole = values.size // width * width
        columns = values[:whole].reshape(-1, width)
        extremes = np.sort([columns.argmin(axis=1), columns.argmax(axis=1)], axis=0) + np.arange(0, whole, width)
        kept = np.concatenate([extremes.T.ravel(), np.arange(whole, values.size)])
        time, values = time[kept], values[kept]
    axes.plot(time, values, **look)
    return values


def label_above(axes: Axes, text: str) -> None:
    """Label the vertical axis, above it, where it is read without turning the head."""
    axes.set_ylabel(text, rotation=0.0, horizontalalignment="left", verticalalignment="baseline")
    lift = ScaledTranslation(0.0, LIFT / 72.0, axes.figure.dpi_scale_trans)
    axes.yaxis.set_label_coords(0.0, 1.0, transform=axes.transAxes + lift)


def explain_looks(figure: Figure, looks: Iterable[Look]) -> None:
    """Explain looks above all panels, where no data are, in as many rows as it takes."""
    handles = [Line2D([], [], **look) for look in looks]
    widths = [0.5 + 0.075 * len(str(handle.get_label())) for handle in handles]  # roughly, in inches
    rows = math.ceil(sum(widths) / WIDTH)
    columns = len(handles) if rows == 1 else min(math.ceil(len(handles) / rows), int(WIDTH / max(widths)))
    figure.legend(handles=handles, loc="outside upper center", ncols=max(1, columns), handlelength=1.7)


def make_panels(rows: int, height: float, *, shared: bool = True) -> tuple[Figure, list[Axes]]:
    """Make a figure of panels below each other; the height is in inches."""
    figure = Figure(figsize=(WIDTH, height), layout="constrained")
    panels = list(figure.subplots(rows, 1, sharex=shared, squeeze=False)[:, 0])
    for axes in panels:
        axes.yaxis.set_major_locator(MaxNLocator(5 if rows > 1 else 8, steps=[1, 2, 2.5, 5, 10]))
        axes.ticklabel_format(style="plain", useOffset=False)
    return figure, panels


def stamp(figures: Iterable[Figure], source: str) -> None:
    """Say below each picture where it comes from (scenario and seed, or the log) and which version drew it."""
    for figure in figures:
        figure.supxlabel(f"{_plain(source)}, adaptive-ff {__version__}", x=0.99, ha="right", size=6.5, color=QUIET)


def write_figures(figures: Mapping[str, Figure], folder: Path, formats: Sequence[str]) -> None:
    """Write pictures in several formats.

    Parameters
    ----------
    figures : mapping
        Pictures by name.
    folder : Path
        Where to write each as ``NAME.FORMAT``.
    formats : sequence of str
        Endings, such as png.
    """
    for name, figure in figures.items():
        for ending in formats:
            write_figure(figure, folder / f"{name}.{ending}")


def write_stamped(figures: Mapping[str, Figure], folder: Path, formats: Sequence[str], source: str) -> None:
    """Write pictures as :func:`write_figures` does, each with a line that says where it comes from."""
    stamp(figures.values(), source)
    write_figures(figures, folder, formats)


def write_asked(figure: Figure, path: str | Path | None) -> None:
    """Write a picture where a path is given.

    Parameters
    ----------
    figure : Figure
        The picture.
    path : str or Path, or None
        Where to write it: PNG, or what its ending says.

    Raises
    ------
    InputError
        There are no pictures of that ending, or the file cannot be written.
    TypeError
        The path is none.
    """
    if path is None:
        return
    place = checked_path("path", path)
    known = figure.canvas.get_supported_filetypes()
    if place.suffix and place.suffix[1:].lower() not in known:
        raise InputError(f"path = {str(path)!r} is not allowed: it must end in one of {', '.join(known)}")
    try:
        write_figure(figure, place)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}") from error


def write_into(figures: Mapping[str, Figure], folder: str | Path | None) -> None:
    """Write pictures as ``NAME.png`` into a folder, where one is given; it raises what :func:`write_asked` does."""
    if folder is None:
        return
    place = checked_path("folder", folder)
    for name, figure in figures.items():
        write_asked(figure, place / f"{name}.png")


def _plain(text: str) -> str:
    """Return a text in which matplotlib sees no mathematics."""
    return text.replace("$", r"\$")


def write_figure(figure: Figure, path: Path) -> None:
    """Write a picture, whole or not at all."""
    make_folder(path.parent)
    unfinished = path.with_name(f".{path.name}.{os.getpid()}.unfinished")
    engine = figure.get_layout_engine()
    assert engine is not None
    engine.execute(figure)
    figure.set_layout_engine("none")  # saving would lay out again, which takes twice the time
    try:
        ending = path.suffix[1:].lower() or "png"
        program = {"png": "Software"}.get(ending, "Creator")
        figure.savefig(unfinished, format=ending, dpi=150, metadata={program: f"adaptive-ff {__version__}"})
        os.replace(unfinished, path)
    finally:
        figure.set_layout_engine(engine)
        unfinished.unlink(missing_ok=True)
