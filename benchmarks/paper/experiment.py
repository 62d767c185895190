"""What an experiment hands over to the command that prints it, and figures of many seeds in a few words."""

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from adaptive_ff.friction.model import ESTIMATED
from benchmarks.cases.reports import Row
from benchmarks.paper.records import TRUTH_VALUES, Array

SYMBOLS = dict(zip(ESTIMATED, ("J", "Fc", "Fs", "sigma", "tau"), strict=True))
"""The paper's symbols of the identified parameters."""


@dataclass(frozen=True)
class Experiment:
    """Result of one experiment."""

    title: str  # figure or section of the paper, and what was done
    rows: list[Row]  # the figures
    notes: list[str] = field(default_factory=list)  # what agrees with the paper, cannot be known, was found
    figures: dict[str, Figure] = field(default_factory=dict)  # pictures by file name without ending: ``figure_04``


def notes(experiment: str) -> list[str]:
    """Return the notes on an experiment by the name of its module."""
    return list(tomllib.loads(Path(__file__).with_name("notes.toml").read_text(encoding="utf-8"))[experiment])


def deviations(physical: Sequence[float] | Array) -> dict[str, float]:
    """Return by how much each identified parameter is off the truth, %."""
    off = 100.0 * (np.array(physical[: len(ESTIMATED)]) / TRUTH_VALUES - 1.0)
    return dict(zip(ESTIMATED, off.tolist(), strict=True))


def in_words(physical: Sequence[float] | Array) -> str:
    """Return the deviations of physical parameters from the truth as a line of text, %."""
    return ", ".join(f"{SYMBOLS[name]} {value:+.1f}" for name, value in deviations(physical).items())


def median_and_range(values: Sequence[float], digits: int = 2) -> str:
    """Return the median of some numbers and their range as text."""
    low, middle, high = np.quantile(np.asarray(values, dtype=np.float64), (0.0, 0.5, 1.0))
    return f"{middle:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"
