"""What the adaptive controller is asked to reach on the matrix, beside what it reached."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff.comparison.comparison import BASELINE
from adaptive_ff.comparison.matrix.jobs import Results
from adaptive_ff.comparison.matrix.summary import OURS, TRUTH

BATCH = "lagged_batch"

SETTLED, START, SECOND = "rms_error_settled", "rms_error_start", "rms_error_second"


@dataclass(frozen=True)
class Target:
    """One figure that is asked for.

    Attributes
    ----------
    scenario : str
        The scenario.
    figure : str
        Figure of merit.
    over : str
        Controller whose figure it is divided by; empty for the figure itself.
    limit : float
        What the ratio may be at most, or, where ``of`` is PI, at least.
    of : str
        Controller whose figure is divided.
    worst : bool
        Whether the worst seed counts instead of the median.
    reachable : float
        Improvement that the oracle must reach in the median for the target to be asked.
    """

    scenario: str
    figure: str
    over: str
    limit: float
    of: str = OURS
    worst: bool = False
    reachable: float = 0.0

    @property
    def at_least(self) -> bool:
        """Whether the ratio must be at least the limit."""
        return self.of == BASELINE

    def values(self, results: Results) -> np.ndarray | None:
        """Return the ratio of each seed; None where it was not run or there is no such figure."""
        runs = [found for job, found in results.items() if job.scenario == self.scenario and not job.fastest]
        pairs = [(found.get(self.of, {}), found.get(self.over, {})) for found in runs]
        tops = [top.get(self.figure) for top, _ in pairs]
        bottoms = [bottom.get(self.figure) if self.over else 1.0 for _, bottom in pairs]
        if not runs or None in tops or None in bottoms:
            return None
        if self.reachable > 0.0:
            if not all(self.figure in found.get(name, {}) for found in runs for name in (BASELINE, TRUTH)):
                return None
            gains = [found[BASELINE][self.figure] / found[TRUTH][self.figure] for found in runs]
            if np.median(gains) < self.reachable:
                return None
        return np.array(tops, dtype=float) / np.array(bottoms, dtype=float)

    def text(self) -> str:
        """Return what is compared, in words."""
        ratio = f"{self.of} / {self.over}" if self.over else self.of
        name = self.figure.removeprefix("rms_error_").replace("_", " ")
        return f"{name}: {ratio}, {'worst' if self.worst else 'median'}"


def against(scenario: str, oracle: float, pi: float, *, truth: str = TRUTH, reachable: float = 0.0) -> list[Target]:
    """Return the two settled targets of a scenario."""
    improvement = Target(scenario, SETTLED, OURS, pi, of=BASELINE, reachable=reachable)
    return [Target(scenario, SETTLED, truth, oracle), improvement]


def cold_start(scenario: str) -> list[Target]:
    """Return the targets of the first ten seconds."""
    return [
        Target(scenario, START, BASELINE, 1.05, worst=True),
        Target(scenario, START, BASELINE, 0.6),
        Target(scenario, SECOND, BASELINE, 0.25),
    ]


def jump(scenario: str) -> list[Target]:
    """Return the targets after a sudden change of friction."""
    return [
        Target(scenario, "rms_error_recovered", TRUTH, 1.2),
        Target(scenario, "worst_window", "", 1.0, worst=True),
    ]


TARGETS = [
    *against("ideal_1khz", 0.8, 60.0),
    *against("noisy_1khz", 1.1, 15.0),
    *against("paper_100hz", 1.05, 5.0),
    *against("jittered_22ms", 1.15, 3.0),
    *(
        target
        for name in ("encoder", "delay", "asymmetric", "servo")
        for target in against(name, 1.2, 3.0, reachable=4.0)
    ),
    *(target for name in ("elastic", "lugre") for target in against(name, 1.2, 3.0, truth=BATCH)),
    *(target for name in ("vs_half", "vs_double") for target in against(name, 2.0, 3.0)),
    *(target for name in ("friction_drops", "friction_rises") for target in jump(name)),
    *(target for name in ("ideal_1khz", "noisy_1khz", "paper_100hz", "jittered_22ms") for target in cold_start(name)),
    Target("standstill", "standstill", BASELINE, 1.0),
    *against("saturation", 1.2, 1.0),
]


def targets_table(results: Results) -> Table | None:
    """Return the targets that the results cover; None where there are none."""
    table = Table(title="Targets", box=SIMPLE, title_style="bold")
    for heading in ("scenario", "figure", "asked", "reached", "met"):
        table.add_column(heading, justify="left" if heading in ("scenario", "figure") else "right")
    for target in TARGETS:
        values = target.values(results)
        if values is None:
            continue
        choose: Callable[[np.ndarray], float] = np.max if target.worst else np.median
        reached = float(choose(values))
        met = reached >= target.limit if target.at_least else reached <= target.limit
        asked = f"{'>=' if target.at_least else '<='} {target.limit:g}"
        style = None if met else "red"
        table.add_row(target.scenario, target.text(), asked, f"{reached:.3g}", "yes" if met else "no", style=style)
    return table if table.row_count else None
