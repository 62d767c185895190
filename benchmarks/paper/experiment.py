"""What an experiment hands over to the command that prints it, and figures of many seeds in a few words."""

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from adaptive_ff.friction.model import ESTIMATED
from benchmarks.paper.data import SYMBOLS, TRUTH_VALUES, Array


@dataclass(frozen=True)
class Row:
    """A line of the table.

    ``quantity``: what was measured, unit included; ``value``: the figure; ``target``: what it should reach, empty where
    nothing is asked; ``met``: whether it does; None without a target.
    """

    quantity: str
    value: float | str
    target: str = ""
    met: bool | None = None


def limited(quantity: str, value: float, limit: float) -> Row:
    """Return a row whose figure should not be above a limit."""
    return Row(quantity, value, f"<= {limit:g}", value <= limit)


@dataclass(frozen=True)
class Experiment:
    """Result of one experiment.

    ``title``: figure or section of the paper, and what was done; ``rows``: the figures; ``notes``: what agrees with the
    paper, what cannot be known, what was found; a sentence each; ``figures``: pictures by file name without ending,
    such as ``figure_04``.
    """

    title: str
    rows: list[Row]
    notes: list[str] = field(default_factory=list)
    figures: dict[str, Figure] = field(default_factory=dict)


def notes(experiment: str) -> list[str]:
    """Return the notes on an experiment by the name of its module."""
    return list(tomllib.loads(Path(__file__).with_name("notes.toml").read_text(encoding="utf-8"))[experiment])


def median_and_range(values: Sequence[float], digits: int = 2) -> str:
    """Return the median of some numbers and their range as text."""
    low, middle, high = np.quantile(np.asarray(values, dtype=np.float64), (0.0, 0.5, 1.0))
    return f"{middle:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"


def median_deviation(estimates: Sequence[Array]) -> str:
    """Return by how much physical parameters are off the truth, in %, the median over some records, as text."""
    deviations = 100.0 * (np.median(np.array(estimates), axis=0) / TRUTH_VALUES - 1.0)
    return ", ".join(f"{SYMBOLS[name]} {value:+.1f}" for name, value in zip(ESTIMATED, deviations, strict=True))
