"""What a sweep finds of each drawn joint, and the file that keeps it, so that a long sweep may be interrupted."""

import json
import math
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from adaptive_ff.comparison.kept import mark_of, own_mark, source_digest
from adaptive_ff.comparison.own import Own
from adaptive_ff.errors import InputError
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.simulation.metrics import Metrics


@dataclass(frozen=True)
class Outcome:
    """One drawn joint.

    Attributes
    ----------
    draw : int
        Number of the draw; with the seed of the sweep it gives the joint.
    metrics : dict of Metrics
        Figures of merit by controller; empty where the draw was refused.
    refused : str
        Why it was not run, empty where it was.
    fall : float
        Steepest fall of its friction over the proportional gain.
    """

    draw: int
    metrics: dict[str, Metrics]
    refused: str = ""
    fall: float = math.nan

    def ratio(self, figure: str, controller: str, to: str) -> float:
        """Return a figure of merit of one controller over that of another."""
        top: float = getattr(self.metrics[controller], figure)
        bottom: float = getattr(self.metrics[to], figure)
        return top / bottom


class KeptOutcomes:
    """Outcomes in a file, a line each, added as they come.

    Parameters
    ----------
    folder : Path or None
        Where the file is; None to keep nothing.
    scenario : Scenario
        What the joints are drawn around.
    seed : int
        Seed of the draws.
    further : mapping
        Further controllers that are run, None for those of the package. Where one of them is a living object, nothing
        is kept, since nobody knows whether it is the same the next time.
    """

    def __init__(self, folder: Path | None, scenario: Scenario, seed: int, further: Mapping[str, Own | None]) -> None:
        marks = {name: "" if one is None else own_mark(one) for name, one in further.items()}
        self._file: Path | None = None
        self._mark = ""
        if folder is not None and None not in marks.values():
            self._file = folder / f"sweep-{seed}.jsonl"
            text = f"{scenario.model_dump_json()} {seed} {sorted(marks.items())}"
            self._mark = mark_of(source_digest(), text.encode())

    def read(self) -> dict[int, Outcome]:
        """Return what is kept of the same scenario, seed, controllers and sources, by draw."""
        try:
            lines = [] if self._file is None else self._file.read_text(encoding="utf-8").splitlines()
        except (OSError, UnicodeDecodeError):
            return {}
        found = {}
        for line in lines:
            outcome = self._outcome(line)
            if outcome is not None:
                found[outcome.draw] = outcome
        return found

    def add(self, outcomes: Iterable[Outcome]) -> None:
        """Add outcomes to the file.

        Raises
        ------
        InputError
            The file cannot be written.
        """
        if self._file is None:
            return
        text = "".join(json.dumps({"mark": self._mark, **asdict(outcome)}) + "\n" for outcome in outcomes)
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            with self._file.open("a", encoding="utf-8") as stream:
                stream.write(text)
        except OSError as error:
            raise InputError(f"{self._file}: cannot be written: {error.strerror or error}") from error

    def _outcome(self, line: str) -> Outcome | None:
        """Return the outcome of a line; None for one of another sweep, or cut short by a power cut."""
        try:
            content = json.loads(line)
            if content.pop("mark") != self._mark:
                return None
            metrics = {name: Metrics(**figures) for name, figures in content.pop("metrics").items()}
            return Outcome(content["draw"], metrics, content["refused"], content["fall"])
        except (ValueError, KeyError, TypeError, AttributeError):
            return None
