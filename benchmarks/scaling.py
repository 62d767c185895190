"""Cost over duration, runs, controllers and workers: ``python -m benchmarks.scaling [--json FILE]``.

Processor time where one process works, elapsed time where two are compared with one: that ratio means something on a
quiet machine with two cores and more alone, and the load is printed beside it.
"""

import time
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.box import SIMPLE
from rich.console import Console
from rich.table import Table

from adaptive_ff import Scenario, compare, load_scenario, simulate
from adaptive_ff.comparison import drawn_joints, running
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.files import write_json
from adaptive_ff.workers import pool_of_workers
from benchmarks.speed import machine
from benchmarks.speed_rows import shown

TWO_OVER_ONE = 1.8
"""How much faster two workers are asked to be than one."""

LOOP_SHARE = 0.6
"""Share of the compiled loop in the processor time of a sweep that is asked for."""

KEPT = 1000
"""Samples that the run keeps whose memory is measured."""


@dataclass(frozen=True)
class Sizes:
    """How much is measured.

    Attributes
    ----------
    durations : tuple of float
        Simulated times, s.
    runs : tuple of int
        Joints of a sweep.
    controllers : tuple of int
        Numbers of controllers.
    shared : int
        Joints of the sweep that one and two workers share.
    duration : float or None
        Duration of runs whose duration is not the question, s; that of the scenario by default.
    """

    durations: tuple[float, ...] = (10.0, 100.0, 1000.0, 10_000.0)
    runs: tuple[int, ...] = (10, 100, 1000, 10_000)
    controllers: tuple[int, ...] = (1, 3, 10)
    shared: int = 400
    duration: float | None = None


@dataclass(frozen=True)
class Cost:
    """What something costs.

    Attributes
    ----------
    what : str
        What is measured.
    total : float
        Time, s.
    each : float
        Time for each simulated second, joint or controller, s.
    note : str
        What else is measured.
    """

    what: str
    total: float
    each: float
    note: str = ""


def processor_time(job: Callable[[], Any]) -> float:
    """Return the processor time of a job in this process, s."""
    begin = time.process_time()
    job()
    return time.process_time() - begin


def over_duration(scenario: Scenario, sizes: Sizes) -> list[Cost]:
    """Measure ``simulate`` with the adaptive controller, thinned to some thousand samples, and the memory it takes."""
    found = []
    for duration in sizes.durations:
        asked = scenario.modified(duration=duration)
        thin = max(2, round(asked.samples / KEPT))
        spent = processor_time(lambda asked=asked, thin=thin: simulate(asked, thin=thin))
        memory = [peak_memory(lambda asked=asked, each=each: simulate(asked, thin=each)) for each in (thin, 1)]
        note = f"peak memory {shown(memory[0], 'B')} thinned, {shown(memory[1], 'B')} with all series"
        found.append(Cost(f"{duration:g} s", spent, spent / duration, note))
    return found


def peak_memory(job: Callable[[], Any]) -> int:
    """Return the peak of the memory that a job allocates, B."""
    tracemalloc.start()
    job()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


@contextmanager
def timed_loop() -> Iterator[list[float]]:
    """Yield a list whose only number is the time that the compiled loop took so far, s."""
    spent, run = [0.0], running.run_controller

    def timed(*arguments: Any) -> Any:
        begin = time.thread_time()
        try:
            return run(*arguments)
        finally:
            spent[0] += time.thread_time() - begin

    running.run_controller = timed
    try:
        yield spent
    finally:
        running.run_controller = run


def over_runs(scenario: Scenario, sizes: Sizes) -> list[Cost]:
    """Measure joints drawn one by one, with PI, oracle and adaptive each, and the share of the compiled loop in it."""
    found = []
    for runs in sizes.runs:
        with timed_loop() as loop:
            spent = processor_time(lambda runs=runs: [drawn_joints.run_draw(scenario, 1, draw) for draw in range(runs)])
        note = f"compiled loop {loop[0] / spent:.0%} of it, asked {LOOP_SHARE:.0%}"
        found.append(Cost(f"{runs} joints", spent, spent / runs, note))
    return found


def over_controllers(scenario: Scenario, sizes: Sizes) -> list[Cost]:
    """Measure ``compare`` with the first few controllers of the registry; all are compiled before."""
    compare(scenario.modified(duration=1.0, controllers=list(CONTROLLERS)[: max(sizes.controllers)]))
    found = []
    for count in sizes.controllers:
        asked = scenario.modified(controllers=list(CONTROLLERS)[:count])
        spent = processor_time(lambda asked=asked: compare(asked))
        found.append(Cost(f"{count} controllers", spent, spent / count))
    return found


def over_workers(scenario: Scenario, sizes: Sizes) -> list[Cost]:
    """Measure the same sweep on one worker and on two, elapsed time; the workers have started and loaded everything."""
    found = []
    for workers in (1, 2):
        with pool_of_workers(workers) as pool:
            drawn_joints.sweep(scenario, 4 * drawn_joints.BATCH, executor=pool)
            begin = time.perf_counter()
            drawn_joints.sweep(scenario, sizes.shared, executor=pool)
            spent = time.perf_counter() - begin
        ratio = found[0].total / spent if found else 1.0
        note = f"{ratio:.2f} times as fast as one, asked {TWO_OVER_ONE:g} on a quiet machine" if found else ""
        found.append(Cost(f"{workers} workers, {sizes.shared} joints", spent, spent / sizes.shared, note))
    return found


SECTIONS = {
    "simulate over duration; each: a simulated second": over_duration,
    "sweep over joints; each: a joint": over_runs,
    "compare over controllers; each: a controller": over_controllers,
    "sweep over workers, elapsed time; each: a joint": over_workers,
}


def report(console: Console, sizes: Sizes) -> dict[str, Any]:
    """Measure everything, print a table after the other, and return all numbers."""
    facts = machine()
    for name, fact in facts.items():
        console.print(f"{name}: {fact}", highlight=False, markup=False)
    scenario = load_scenario()
    if sizes.duration is not None:
        scenario = scenario.modified(duration=sizes.duration)
    drawn_joints.run_draw(scenario, 1, 0)  # what is compiled or loaded at first does not count
    written = {}
    for title, measure in SECTIONS.items():
        costs = measure(scenario, sizes)
        table = Table(title=title, box=SIMPLE)
        for heading in ("", "time", "each", ""):
            table.add_column(heading, justify="right" if heading else "left", no_wrap=True)
        for cost in costs:
            table.add_row(cost.what, shown(cost.total, "s"), shown(cost.each, "s"), cost.note)
        console.print(table)
        written[title] = [asdict(cost) for cost in costs]
    return {"machine": facts, "sizes": asdict(sizes), "costs": written}


def main(
    most: Annotated[int, typer.Option(min=10, help="Largest number of joints of a sweep.")] = 10_000,
    json: Annotated[Path | None, typer.Option(help="Write all numbers there.")] = None,
) -> None:
    """Measure how cost grows with duration, runs, controllers and workers."""
    sizes = Sizes()
    sizes = replace(sizes, runs=tuple(runs for runs in sizes.runs if runs <= most))
    result = report(Console(width=140), sizes)
    if json is not None:
        write_json(json, result)


if __name__ == "__main__":
    typer.run(main)
