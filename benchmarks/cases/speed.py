"""Time and memory: a step from Python, a group, a run, the command line, a log.

Figures are times in s (``median``, ``slow``: one in a thousand takes longer) and ``memory``, the peak over the size of
what is kept. What a row is compared with runs in turn with it in the same process.
"""

import os
import subprocess
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from adaptive_ff import JointGroup, Scenario, load_scenario, simulate
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.logs.log import read_log
from adaptive_ff.studies.study import Found
from benchmarks.suite import Case

CALLS = 50_000
"""Steps that are timed of a single controller; a tenth of them of a group."""

JOINTS = (1, 6, 24)
"""Sizes of groups."""

ROWS = 200_000
"""Rows of the log that is read."""

Call = Callable[[int], Any]


def samples() -> tuple[list[float], list[float]]:
    """Return reference and measured velocity of the built-in scenario, as if tracking were perfect."""
    scenario = load_scenario()
    reference = scenario.reference_velocity()[:: scenario.substeps]
    return reference.tolist(), (reference[:-1] + scenario.noise()).tolist()


def step_of(name: str) -> Call:
    """Return what steps a controller, or simple-pid with the same gains, with the samples of the built-in scenario."""
    references, measured = samples()
    scenario, torque = load_scenario(), [0.0]
    if name == "simple_pid":
        from simple_pid import PID

        pid, period = PID(*scenario.feedback.gains, 0.0, sample_time=None), scenario.sampling.period

        def call(k: int) -> None:
            pid.setpoint = references[k]
            pid(measured[k], dt=period)

        return call
    controller = make_controller(scenario, name)

    def step(k: int) -> None:
        last, following = torque[0], references[k + 1]
        torque[0] = controller.step(references[k], measured[k], next_reference=following, realised_torque=last)

    return step


def group_step(name: str, joints: int) -> Call:
    """Return what steps a group of joints."""
    references, measured = (np.repeat(np.array(one)[:, None], joints, axis=1) for one in samples())
    group = JointGroup({f"joint {place}": make_controller(load_scenario(), name) for place in range(joints)})

    def call(k: int) -> None:
        group.step(references[k], measured[k], next_reference=references[k + 1])

    return call


def in_turn(calls: dict[str, Call], count: int) -> dict[str, dict[str, float]]:
    """Return the times of calls (s), one of each in turn after one that does not count."""
    places = len(samples()[1])
    times = np.empty((count, len(calls)))
    for call in calls.values():
        call(0)
    for k in range(count):
        for place, call in enumerate(calls.values()):
            begin = time.perf_counter()
            call(k % places)
            times[k, place] = time.perf_counter() - begin
    return {
        name: {"median": float(np.median(one)), "slow": float(np.quantile(one, 0.999))}
        for name, one in zip(calls, times.T, strict=True)
    }


def run_step(controllers: list[str]) -> Found:
    """Time a step from Python."""
    return {"": {"row": "a step from Python"}, **in_turn({name: step_of(name) for name in controllers}, CALLS)}


def run_group(joints: int, controllers: list[str]) -> Found:
    """Time a step of a group of adaptive joints; the others have none."""
    found = in_turn({"adaptive": group_step("adaptive", joints)}, CALLS // 10)
    return {"": {"row": f"a step of {joints} joints"}, **{name: found.get(name, {}) for name in controllers}}


def run_runs(row: str, scenario: Scenario, controllers: list[str]) -> Found:
    """Time whole runs of a scenario and measure their memory."""
    made = [name for name in controllers if name != "simple_pid"]
    found = in_turn({name: partial(_run, scenario, name) for name in made}, 5)
    for name in made:
        tracemalloc.start()
        run = simulate(scenario, name, uncertain=False)
        kept = sum(series.nbytes for series in run.columns().values())
        found[name] = {"median": found[name]["median"], "memory": tracemalloc.get_traced_memory()[1] / kept}
        tracemalloc.stop()
    return {"": {"row": row}, **{name: found.get(name, {}) for name in controllers}}


def _run(scenario: Scenario, name: str, _: int) -> None:
    simulate(scenario, name, uncertain=False)


def run_commands(controllers: list[str]) -> Found:
    """Time ``adaptive-ff --help`` and a first and a later ``compare``, whole processes; all under ``adaptive``."""
    with tempfile.TemporaryDirectory() as folder:
        fresh = {**os.environ, **dict.fromkeys(("NUMBA_CACHE_DIR", "MPLCONFIGDIR", "XDG_CACHE_HOME"), folder)}
        command = [sys.executable, "-m", "adaptive_ff"]
        compare = [*command, "compare", "--out", str(Path(folder, "out"))]
        figures = {
            "help": float(np.median([_elapsed([*command, "--help"], fresh) for _ in range(5)])),
            "first_compare": _elapsed(compare, fresh),
            "later_compare": float(np.median([_elapsed(compare, fresh) for _ in range(3)])),
        }
    return {"": {"row": "command line"}, **{name: figures if name == "adaptive" else {} for name in controllers}}


def _elapsed(command: list[str], environment: dict[str, str]) -> float:
    begin = time.perf_counter()
    subprocess.run(command, env=environment, check=True, capture_output=True)
    return time.perf_counter() - begin


def run_log(controllers: list[str]) -> Found:
    """Measure the peak of the memory that reading a CSV log takes, over the size of its columns."""
    with tempfile.TemporaryDirectory() as folder:
        path, time_ = Path(folder) / "log.csv", 0.001 * np.arange(ROWS)
        rows = np.column_stack([time_, np.sin(time_), np.cos(time_)])
        np.savetxt(path, rows, fmt="%.6f", delimiter=",", header="t,q,u", comments="")
        tracemalloc.start()
        read_log(path, time="t", position="q", torque="u")
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    figures = {"memory": peak / (3 * 8 * ROWS)}
    return {"": {"row": "reading a log"}, **{name: figures if name == "adaptive" else {} for name in controllers}}


def measurements(count: int = 1, first: int = 1) -> list[Case]:
    """Return all measurements, each so many times."""
    runs = {
        "60 s at 100 Hz": load_scenario(),
        "60 s at 1 kHz": load_scenario("noisy_1khz"),
        "10 000 s at 100 Hz, thinned": load_scenario().modified(duration=10_000.0),
    }
    made: dict[str, Callable[[list[str]], Found]] = {
        "step": run_step,
        **{f"group {joints}": partial(run_group, joints) for joints in JOINTS},
        **{row: partial(run_runs, row, scenario) for row, scenario in runs.items()},
        "commands": run_commands,
        "log": run_log,
    }
    return [Case(f"{name}/{seed}", seed, run) for name, run in made.items() for seed in range(first, first + count)]
