"""The regression gate of ``adaptive-ff compare``: options checked before the run, the verdict after it."""

from pathlib import Path
from typing import TYPE_CHECKING

from adaptive_ff.cli.output import Printer, error_console

if TYPE_CHECKING:
    from adaptive_ff.comparison.comparison import Comparison
    from adaptive_ff.scenario.scenario import Scenario

WORSE = 1
"""Exit status where a regression gate fails."""


class Gate:
    """A baseline and what may be worse than it, checked before anything runs."""

    def __init__(
        self,
        path: Path,
        scenario: "Scenario",
        tolerance: list[str] | None,
        controllers: list[str] | None,
        metrics: list[str] | None,
        across: list[str] | None,
        seeds: int = 1,
    ) -> None:
        from adaptive_ff.comparison.baseline import check_same_scenario, read_baseline
        from adaptive_ff.comparison.gate import Tolerances, check_same_seeds, guarded_controllers, guarded_metrics

        self._path, self._baseline, self._across = path, read_baseline(path), across or []
        check_same_scenario(scenario, self._baseline, str(path), self._across)
        check_same_seeds(self._baseline, seeds)
        self._tolerance = _by_name(tolerance or [])
        Tolerances(self._tolerance, self._baseline["controllers"])
        self._chosen, self._controllers = controllers, guarded_controllers(self._baseline, controllers)
        self._metrics = guarded_metrics(self._baseline, metrics)

    def judge(self, comparison: "Comparison") -> int:
        """Print what got worse, or that nothing did, and what is guarded; return the exit status."""
        from adaptive_ff.comparison.gate import regressions

        worse = regressions(
            comparison,
            self._baseline,
            self._tolerance,
            controllers=self._chosen,
            metrics=self._metrics,
            across=self._across,
        )
        for sentence in worse:
            error_console().print(f"worse than {self._path}: {sentence}", markup=False)
        if not worse:
            Printer().say(f"Nothing is worse than in {self._path}, within the tolerances.")
        free = [name for name in comparison.runs if name not in self._controllers]
        others = f"; not guarded: {', '.join(free)} (--guard NAME)" if free else ""
        figures = f"{len(self._metrics)} figures of {', '.join(self._controllers)}"
        Printer().say(f"Guarded: {figures}{others}")
        return WORSE if worse else 0


def _by_name(tolerances: list[str]) -> dict[str, str]:
    """Return tolerances by what they are for."""
    found = {}
    for text in tolerances:
        name, equals, fraction = text.rpartition("=")
        found[name.strip() if equals else "default"] = fraction
    return found
