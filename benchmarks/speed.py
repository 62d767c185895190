"""Speed of loop, step and command line: ``python -m benchmarks.speed [--only SECTION] [--json FILE]``.

Everything is measured beside a rival in the same run, in turn with it: the closed loop beside the same loop in C (the
adaptive controller as the C that it is exported to) and in python-control, a long run beside a short one, a step beside
the same step in plain Python, a group of joints beside its joints one by one. Before a rival of the closed loop is
timed, its run is checked against ours.
"""

import math
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable, Sequence
from ctypes import CDLL
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console

from adaptive_ff import Scenario, load_scenario, simulate
from adaptive_ff.files import write_json
from benchmarks.processor_time import REPEATS, child_time, help_beside_numpy
from benchmarks.speed_group import group_steps
from benchmarks.speed_rivals import (
    CLOCK,
    CLoop,
    ExportedLoop,
    OwnLoop,
    PythonControlLoop,
    check_alike,
    compile_loop,
    compiler,
    shared_series,
)
from benchmarks.speed_rows import Row, as_table, in_turn
from benchmarks.speed_steps import single_steps

COURSES: dict[str, dict[str, Any]] = {
    "100 Hz, joint 1 kHz": {},
    "1 kHz, joint 1 kHz": {"sampling": {"period": 0.001}},
    "100 Hz, joint 10 kHz": {"joint": {"solver_period": 0.0001}},
}
COMPARE = (sys.executable, "-m", "adaptive_ff", "compare", "--out", "{out}")

GROUP_SHARE = 10
"""Factor by which there are fewer calls of a group, which takes as long as many joints."""

LATER_RUNS = 3
"""Later runs of the command, of which the median counts."""

# Targets: ratios, and times in s.
RATIO_TO_C = 1.2
RATIO_TO_PYTHON_CONTROL = 0.01
RATIO_TO_SHORT_RUN = 1.5
RATIO_TO_SERIES = 3.0
LONGEST_FIRST_COMMAND = 40.0
LONGEST_LATER_COMMAND = 5.0
MOST_COMPILING = 8.6  # of processor time: half of what it once took
RATIO_TO_NUMPY = 4.0


@dataclass(frozen=True)
class Sizes:
    """How much is measured.

    Attributes
    ----------
    duration : float
        Simulated time, s.
    repeats, slow_repeats : int
        Repeats of what takes milliseconds, and of what takes seconds.
    lengths : tuple of int
        Factors on the duration for the dependence on it.
    calls : int
        Calls of a single step.
    commands : int
        Repeats of short commands.
    """

    duration: float = 60.0
    repeats: int = 31
    slow_repeats: int = 5
    lengths: tuple[int, ...] = (1, 10, 100)
    calls: int = 50_000
    commands: int = REPEATS


def beside_c(scenario: Scenario, course: str, repeats: int, library: CDLL | None) -> list[Row]:
    """Measure our loop beside the C loop, by hand and with the adaptive controller that was exported to C.

    Without a library there is one row that gives the reason.
    """
    if library is None:
        return [Row(course, "skipped: there is no C compiler (cc, gcc, clang)")]
    rows = []
    for name in ("pi", "fixed", "adaptive"):
        own = OwnLoop(scenario, name)
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
            rival = ExportedLoop(Path(folder), own) if name == "adaptive" else CLoop(library, own)
            own.run()
            rival.run()
            label = "C by hand" if name != "adaptive" else "C by hand with the exported controller"
            difference = check_alike(shared_series(own), shared_series(rival), f"{label}, {name}, {course}")
            (ours, theirs), (ratio, _) = in_turn(repeats, own.run, rival.run)
        rows.append(Row(f"{name}, {course}", label, ours, theirs, ratio, RATIO_TO_C, difference=difference))
    return rows


def beside_python_control(scenario: Scenario, course: str, repeats: int) -> list[Row]:
    """Measure our loop, with PI and with the adaptive controller, beside python-control with PI."""
    pi, adaptive = OwnLoop(scenario, "pi"), OwnLoop(scenario, "adaptive")
    rival = PythonControlLoop(pi)
    for loop in (pi, adaptive, rival):
        loop.run()
    difference = check_alike(
        [pi.record.velocity[: -1 : scenario.substeps]], [rival.velocity], f"python-control, {course}"
    )
    times, ratios = in_turn(repeats, pi.run, adaptive.run, rival.run)
    beside = "python-control, PI"
    return [
        Row(f"pi, {course}", beside, times[0], times[2], ratios[0], difference=difference),
        Row(f"adaptive, {course}", beside, times[1], times[2], ratios[1], RATIO_TO_PYTHON_CONTROL),
    ]


def run_length(scenario: Scenario, repeats: int) -> tuple[float, int, int]:
    """Simulate a scenario and return the median time (s), the peak of memory and the size of all series (B)."""
    times = []
    for _ in range(repeats):
        begin = CLOCK()
        simulate(scenario, thin=1)
        times.append(CLOCK() - begin)
    tracemalloc.start()
    run = simulate(scenario, thin=1)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    series = [value for value in [*vars(run).values(), *run.estimates.values()] if isinstance(value, np.ndarray)]
    return statistics.median(times), peak, sum(array.nbytes for array in series)


def run_lengths(scenario: Scenario, sizes: Sizes) -> list[Row]:
    """Measure how time and memory of ``simulate``, with the adaptive controller, grow with the length of the run."""
    rows = []
    simulate(scenario)
    first = math.nan
    shortest = f"{sizes.lengths[0] * scenario.length:g} s"
    for factor in sizes.lengths:
        duration = factor * scenario.length
        elapsed, peak, size = run_length(scenario.modified(duration=duration), sizes.slow_repeats)
        each = elapsed / duration
        first = each if math.isnan(first) else first
        what = f"{duration:g} s: "
        rows.append(Row(f"{what}time a simulated second", shortest, each, first, each / first, RATIO_TO_SHORT_RUN))
        rows.append(Row(f"{what}peak memory", "series", peak, size, peak / size, RATIO_TO_SERIES, unit="B"))
    return rows


def command_line(command: Sequence[str] = COMPARE) -> list[Row]:
    """Measure a command without and with what its first run leaves on disk.

    Parameters
    ----------
    command : sequence of str
        Program and arguments; ``{out}`` stands for a new folder.

    Raises
    ------
    RuntimeError
        The command fails.
    """
    elapsed, used = [], []
    with tempfile.TemporaryDirectory() as folder:
        caches = {name: str(Path(folder, name)) for name in ("ADAPTIVE_FF_CACHE", "MPLCONFIGDIR")}
        for path in caches.values():
            os.mkdir(path)
        for attempt in range(1 + LATER_RUNS):
            parts = [part.replace("{out}", str(Path(folder, f"out{attempt}"))) for part in command]
            begin, before = time.perf_counter(), child_time()
            done = subprocess.run(parts, env={**os.environ, **caches}, capture_output=True, text=True, check=False)
            elapsed.append(time.perf_counter() - begin)
            used.append(child_time() - before)
            if done.returncode != 0:
                raise RuntimeError(f"{' '.join(parts)} failed: {done.stderr.strip()[-500:]}")
    first, later = elapsed[0], statistics.median(elapsed[1:])
    known = statistics.median(used[1:])
    compiling = {"ours": used[0] - known, "theirs": known, "ratio": (used[0] - known) / known} if known > 0.0 else {}
    return [
        Row("first run, nothing cached", "later run", first, later, first / later, largest=LONGEST_FIRST_COMMAND),
        Row("later run", "first run", later, first, later / first, largest=LONGEST_LATER_COMMAND),
        Row("compiling, processor time", "later run", **compiling, largest=MOST_COMPILING),
    ]


def help_command(repeats: int) -> list[Row]:
    """Measure the processor time of ``adaptive-ff --help`` beside that of importing numpy."""
    times = help_beside_numpy(repeats)
    if times is None:
        return [Row("--help", "skipped: processor times of processes are not to be had here")]
    return [Row("processor time", "python -c 'import numpy'", *times, times[0] / times[1], RATIO_TO_NUMPY)]


def machine() -> dict[str, str]:
    """Return what the figures depend on."""
    model = platform.processor() or platform.machine()
    info = Path("/proc/cpuinfo")
    if info.exists():
        models = [line.partition(":")[2].strip() for line in info.read_text().splitlines() if "model name" in line]
        model = models[0] if models else model
    program, lines = compiler(), ""
    if program is not None:
        lines = subprocess.run([program, "--version"], capture_output=True, text=True, check=False).stdout
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return {
        "processor": model,
        "cores": str(cores),
        "load": f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown",
        "Python": platform.python_version(),
        **{name: version(name) for name in ("numpy", "control")},
        "C compiler": lines.partition("\n")[0] or "none",
    }


def measurements(sizes: Sizes, folder: Path, command: Sequence[str]) -> dict[str, Callable[[], list[Row]]]:
    """Return what is measured, by title; the C loop is compiled into a folder."""
    library = compile_loop(folder) if compiler() else None
    base = load_scenario().modified(duration=sizes.duration)
    courses = {name: base.modified(**tables) for name, tables in COURSES.items()}

    def all_courses(measure: Callable[..., list[Row]], *arguments: Any) -> list[Row]:
        return [row for name, scenario in courses.items() for row in measure(scenario, name, *arguments)]

    loop = f"Closed loop of {base.length:g} s; rival:"
    return {
        f"{loop} the same in C": lambda: all_courses(beside_c, sizes.repeats, library),
        f"{loop} python-control, with PI": lambda: all_courses(beside_python_control, sizes.slow_repeats),
        "Longer runs; rival: the shortest, and the size of the series": lambda: run_lengths(base, sizes),
        "controller.step(); rival: the same in plain Python": lambda: single_steps(sizes.calls),
        "JointGroup.step(); rival: its joints one by one": lambda: group_steps(max(1, sizes.calls // GROUP_SHARE)),
        "adaptive-ff compare; rival: the other run": lambda: command_line(command),
        "adaptive-ff --help; rival: python -c 'import numpy'": lambda: help_command(sizes.commands),
    }


def report(console: Console, sizes: Sizes, command: Sequence[str] = COMPARE, only: str = "") -> dict[str, Any]:
    """Measure the sections whose title contains a text, print a table after the other, and return all numbers.

    Raises
    ------
    ValueError
        There is no such section.
    """
    facts = machine()
    for name, fact in facts.items():
        console.print(f"{name}: {fact}", highlight=False, markup=False)
    sections: dict[str, list[Row]] = {}
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        chosen = measurements(sizes, Path(folder), command)
        if not any(only in title for title in chosen):
            raise ValueError(f"--only {only} is not allowed: it must be part of one of {'; '.join(chosen)}")
        for title, measure in ((title, measure) for title, measure in chosen.items() if only in title):
            sections[title] = measure()
            console.print(as_table(title, sections[title]))
    verdicts = [row.met for rows in sections.values() for row in rows if row.met is not None]
    if verdicts:
        console.print(f"{sum(verdicts)} of {len(verdicts)} targets are met", highlight=False)
    written = {title: [{**asdict(row), "met": row.met} for row in rows] for title, rows in sections.items()}
    return {"machine": facts, "sizes": asdict(sizes), "measurements": written}


def main(
    json: Annotated[Path | None, typer.Option(help="Write all numbers there.")] = None,
    only: Annotated[str, typer.Option(help="Part of the title of the sections to measure.")] = "",
) -> None:
    """Measure the speed of the package beside its rivals."""
    try:
        result = report(Console(), Sizes(), only=only)
    except (ArithmeticError, ValueError) as error:
        print(f"benchmarks.speed: {error}", file=sys.stderr)
        raise typer.Exit(1) from error
    if json is not None:
        write_json(json, result)


if __name__ == "__main__":
    typer.run(main)
