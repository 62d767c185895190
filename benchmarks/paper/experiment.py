"""What an experiment hands over to the command that prints it."""

from dataclasses import dataclass, field

from matplotlib.figure import Figure


@dataclass(frozen=True)
class Row:
    """A line of the table.

    Attributes
    ----------
    quantity : str
        What was measured, unit included.
    value : float or str
        The figure.
    target : str
        What it should reach, empty where nothing is asked.
    met : bool or None
        Whether it does; None without a target.
    """

    quantity: str
    value: float | str
    target: str = ""
    met: bool | None = None


@dataclass(frozen=True)
class Experiment:
    """Result of one experiment.

    Attributes
    ----------
    title : str
        Figure or section of the paper, and what was done.
    rows : list of Row
        The figures.
    notes : list of str
        What agrees with the paper, what cannot be known, what was found; a sentence each.
    figures : dict of Figure
        Pictures by file name without ending, such as ``figure_04``.
    """

    title: str
    rows: list[Row]
    notes: list[str] = field(default_factory=list)
    figures: dict[str, Figure] = field(default_factory=dict)
