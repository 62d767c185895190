"""What is measured of a joint: identification, replay of its logs, and a closed loop."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff import Comparison
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.identify.score import Score, score_log
from adaptive_ff.replay.replay import Replay, replay_log
from benchmarks.measured.identified_joint import simulate_identified
from benchmarks.measured.machines import Job

COLUMNS = {
    "none": "none",
    "recorded": "own",
    "fixed": "fixed",
    "adaptive": "adaptive",
    "adaptive_saved": "saved",
}
"""Feedforwards of a replay, and their headings."""


@dataclass(frozen=True)
class Result:
    """What was measured of a joint.

    Attributes
    ----------
    job : Job
        The joint.
    found : LogIdentification
        Its first log identified, and validated on the second one or on its end.
    replays : list of Replay
        Its logs, the second one from a cold start and from the state at the end of the first.
    closed_loop : Comparison or None
        The identified joint in the closed loop.
    score : Score or None
        Open-loop simulation of the second log by a model trained on the first.
    """

    job: Job
    found: LogIdentification
    replays: list[Replay]
    closed_loop: Comparison | None
    score: Score | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return everything but the series as plain values."""
        loop = self.closed_loop
        return {
            "identification": self.found.to_dict(),
            "replays": {
                record: replay.to_dict() for record, replay in zip(self.job.records, self.replays, strict=True)
            },
            "closed_loop": None if loop is None else loop.to_dict(),
            "score": None if self.score is None else self.score.to_dict(),
        }


def measure(job: Job, data: Path) -> Result:
    """Identify a joint, replay its logs and simulate it."""
    logs = [job.read(data, record) for record in job.records]
    other = logs[1] if len(logs) > 1 else None
    found = identify_log(
        logs[0], held_out=0.0 if other is not None else job.held_out, validation=other, linear=job.linear
    )
    replays = [replay_log(logs[0], linear=job.linear, **job.settings)]
    if other is not None:
        replays.append(replay_log(other, linear=job.linear, state=replays[0].state_to_json(), **job.settings))
    loop = simulate_identified(found, logs[0]) if job.simulated else None
    score = score_log(logs[0], logs[1], linear=job.linear) if job.scored else None
    return Result(job, found, replays, loop, score)


def score_sentence(result: Result) -> str:
    """Return what the open-loop simulation of the second log came to."""
    score = result.score
    assert score is not None
    unit = "mm" if score.linear else "mrad"
    return (
        f"{result.job.name}: open loop, identified on {result.job.records[0]}, "
        f"{result.job.records[1]} from its torque: "
        f"{1e3 * score.rms:.3g} {unit} rms, {1e3 * score.windows:.3g} {unit} in windows of 1 s."
    )


def results_table(results: list[Result]) -> Table:
    """Return one row for each log."""
    table = Table(
        title="Identification: torque left unexplained. Replay: torque left to the feedback, rms in N m (N), 20 Hz, "
        "whole log | its second half | while the joint moves. Closed loop: settled error of "
        "pi | oracle over that of adaptive.",
        box=SIMPLE,
        title_style="bold",
    )
    for heading in ("log", "fit", "validation", *COLUMNS.values(), "closed loop"):
        table.add_column(heading, justify="left" if heading == "log" else "right", no_wrap=heading == "log")
    for result in results:
        for place, (record, replay) in enumerate(zip(result.job.records, result.replays, strict=True)):
            first = place == 0
            found, loop = result.found, result.closed_loop
            name = Path(record).stem.removeprefix("trajectory_").removeprefix("DATA_")
            table.add_row(
                f"{result.job.name} {name}" if len(result.job.records) > 1 else result.job.name,
                f"{100.0 * found.best.left:.1f} %" if first else "",
                f"{100.0 * found.validation:.1f} %" if first and found.validation is not None else "",
                *(_shown(replay, name) for name in COLUMNS),
                _improvements(loop) if first and loop is not None else "",
            )
    return table


def _improvements(loop: Comparison) -> str:
    """Return by how much the error of others is larger than that of adaptive."""
    errors = {name: run.metrics.rms_error_settled for name, run in loop.runs.items()}
    others = ("pi", "oracle")
    return " | ".join(f"{errors[name] / errors['adaptive']:.3g}" for name in others)


def _shown(replay: Replay, name: str) -> str:
    if name not in replay.left:
        return ""
    left = replay.left[name]
    return f"{left.whole:.3g} | {left.second_half:.3g} | {left.moving:.3g}"
