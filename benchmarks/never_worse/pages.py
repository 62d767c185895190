"""The tables of README and of the pages of the benchmarks: ``--pages`` writes the figures of a run into them.

Tables stand between ``<!-- never_worse -->`` and ``<!-- /never_worse -->``. What a row is called is written by hand and
kept; the cells after it are those of the run.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[2]
BEGIN, END = "<!-- never_worse -->", "<!-- /never_worse -->"

LABELS = {
    "built-in joint, noise 2 mrad/s": "paper_100hz",
    "the same at 1 kHz": "noisy_1khz",
    "0.5 kg m², 20 N m, 6 rad/s from a data sheet (`new`), 61 Hz at 1 kHz, 4 min": "data_sheet",
    "load step of 80 N m": "load_step_80",
    "friction triples": "friction_triples",
    "inertia doubles": "payload_double",
    "gravity 100 sin q, not modelled": "gravity_100",
    "LuGre, bristles 1e3 N m/rad": "lugre_1e3",
    "LuGre, 1e4 N m/rad": "lugre_1e4",
    "motion up to 0.25 Vs": "slow_025",
    "a tenth of the inertia, up to 0.25 Vs": "light_slow",
    "Stribeck fall of 5 Kp": "steep_5",
    "of 10 Kp": "steep_10",
    "Fs = 3 Fc, Vs assumed a quarter": "high_stiction_vs_quarter",
    "drive one period late": "delay",
    "elastic gear": "elastic",
    "PI's fastest loop, 80 Hz at 1 kHz": "fast_loop_1khz",
    "an encoder of 4096 counts a turn, low-pass, 6 Hz": "coarse_encoder",
    "a Kalman filter, 10 Hz at 1 kHz, 4096 counts": "kalman_1khz_4096",
    "drive lags by 10 ms, controller not told": "lag_untold_10",
    "its torque rises by 1500 N m/s at most, not told": "rate_untold_1500",
    "a sensor whose velocity ripples 120 times a turn, motion one way, 500 Hz": "sensor_ripple_120",
    "20 times a turn": "sensor_ripple_20",
    "a sensor holds its value for 0.5 s now and then": "sensor_held_50",
}
"""What README calls the situations that it shows."""


class Page(NamedTuple):
    """A page with a table.

    Attributes
    ----------
    path : Path
        The page, in the repository.
    name_of : callable
        Returns the situation of a row from its first cell.
    cells_of : callable
        Returns the other cells of a row of figures.
    """

    path: Path
    name_of: Callable[[str], str]
    cells_of: Callable[[dict[str, Any]], list[str]]


def all_figures(row: dict[str, Any]) -> list[str]:
    """Return all figures of a row, each with what is asked of it."""
    asked = row["asked"]
    return [
        f"{1e3 * row['pi']:.3g}",
        f"{_pair(row, 'settled')}, {asked['settled']:g}",
        f"{row['worst_window']:.2f}{_asked(asked['window'])}",
        f"{_pair(row, 'start')}{_asked(asked['start'])}",
        "-" if row["after"] is None else f"{row['after']:.2f}{_asked(asked['after'])}",
        ", ".join(row["missed"]),
    ]


def figures_of_a_map(row: dict[str, Any]) -> list[str]:
    """Return the figures of a joint with a map of friction."""
    missed = ", ".join(row["missed"])
    return [f"{1e3 * row['pi']:.3g}", _pair(row, "settled"), f"{row['worst_window']:.2f}", _pair(row, "start"), missed]


def figures_for_newcomers(row: dict[str, Any]) -> list[str]:
    """Return what README shows of a row."""
    settled = f"{_three_digits(row['settled'])} ({_three_digits(row['settled_worst'])})"
    return [f"{1e3 * row['pi']:.3g}", settled, f"{row['worst_window']:.2f}"]


PAGES = (
    Page(ROOT / "README.md", lambda cell: LABELS[cell], figures_for_newcomers),
    Page(ROOT / "benchmarks" / "never_worse.md", lambda cell: cell, all_figures),
    Page(ROOT / "benchmarks" / "README.md", lambda cell: cell.split("`")[1], figures_of_a_map),
)


def write_tables(rows: list[dict[str, Any]]) -> None:
    """Write the figures of all situations into the pages.

    Parameters
    ----------
    rows : list of dict
        A row of each situation.
    """
    for page in PAGES:
        page.path.write_text(with_figures(page.path.read_text(encoding="utf-8"), page, rows), encoding="utf-8")


def with_figures(text: str, page: Page, rows: list[dict[str, Any]]) -> str:
    """Return the text of a page with the figures of a run in its table."""
    found = {row["situation"]: row for row in rows}
    before, table = text.split(BEGIN)
    table, after = table.split(END)
    heading, line, *old = table.strip().splitlines()
    new = [heading, line]
    for row in old:
        first = row.split("|")[1].strip()
        new.append("| " + " | ".join([first, *page.cells_of(found[page.name_of(first)])]) + " |")
    return "\n".join([before + BEGIN, *new, END]) + after


def _three_digits(ratio: float) -> str:
    return f"{ratio:.2f}" if ratio < 10.0 else f"{ratio:.3g}"


def _pair(row: dict[str, Any], figure: str) -> str:
    return f"{row[figure]:.2f} ({row[f'{figure}_worst']:.2f})"


def _asked(value: float) -> str:
    return "" if value == float("inf") else f", {value:g}"
