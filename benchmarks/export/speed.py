"""Time of a step: the exported code beside the compiled kernels, and behind Python; time of an export."""

import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff import export_controller, run_in_c
from benchmarks.export.driver import build, found, random_inputs, run, write_sources
from benchmarks.export.rows import Row, skipped
from benchmarks.export.variants import SEED, adaptive
from controllers import Inputs, compiled, step

CLOCK = time.process_time
LARGEST_RATIO = 1.2


def _run_series(block: Any, state: Any, rows: NDArray[np.float64], torques: NDArray[np.float64]) -> Any:
    for k in range(torques.size):
        row = rows[k]
        inputs = Inputs(row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8], row[9], row[10])
        output, state = step(block, state, inputs)
        torques[k] = output.torque
    return state


run_series = compiled(_run_series)


def steps(samples: int, repeats: int) -> list[Row]:
    """Compare processor time a step: median over the repeats of the ratio of runs in turn; the machine may be busy."""
    controller = adaptive("symmetric", 0.0, 0.0)
    inputs = random_inputs(controller, samples, SEED)
    torques = np.zeros(samples)
    run_series(controller.native, 0, inputs, torques)  # compiles
    rows, target = [], f"at most {LARGEST_RATIO}"
    with tempfile.TemporaryDirectory() as folder:
        write_sources(adaptive("symmetric", 0.0, 0.0), Path(folder))
        builds = {}
        for program in ("gcc", "clang"):
            if not found(program):
                rows.append(skipped(f"step, {program} over compiled Python", "not installed", target))
                continue
            for level in ("-O2", "-O3"):
                out = f"{program}{level}"
                builds[f"{program} {level}"] = build(Path(folder), [program, "-std=c99", level], out=out)
        times = []
        for _ in range(repeats):
            controller.reset()
            begin = CLOCK()
            run_series(controller.native, 0, inputs, torques)
            times.append([(CLOCK() - begin) / samples * 1e9])
            for name, program in builds.items():
                outputs, _, spent = run([program], inputs)
                times[-1].append(spent)
                if outputs[:, 0].tobytes() != torques.tobytes():
                    raise ArithmeticError(f"{name} gives other torques than compiled Python")
    table = np.array(times)
    medians, ratios = np.median(table, axis=0), np.median(table / table[:, :1], axis=0)
    for name, spent, ratio in zip(builds, medians[1:], ratios[1:], strict=True):
        figure = f"{ratio:.2f} ({spent:.0f} of {medians[0]:.0f} ns)"
        rows.append(
            Row(f"step, {name} over compiled Python, same torques", figure, target, bool(ratio <= LARGEST_RATIO))
        )
    return rows


def behind_python(calls: int) -> list[Row]:
    """Compare ``controller.step()`` with the kernels and with the exported code."""
    controller = adaptive("symmetric", 0.0, 0.0)
    compared = {"compiled Python": controller, "C": run_in_c(controller)}
    times = {}
    for name, item in compared.items():
        item.step(0.1, 0.1, next_reference=0.1)
        best = np.inf
        for _ in range(5):
            begin = CLOCK()
            for _ in range(calls):
                item.step(0.1, 0.1, next_reference=0.1)
            best = min(best, (CLOCK() - begin) / calls)
        times[name] = 1e6 * best
    return [Row(f"controller.step() in {name}", f"{spent:.2f} us") for name, spent in times.items()]


def exporting() -> list[Row]:
    """Time an export, without and with the FMU's compilation."""
    rows = []
    for fmu in (False, True):
        with tempfile.TemporaryDirectory() as folder:
            begin = time.perf_counter()
            export_controller(adaptive("directions", 1.5, 0.004), folder, with_fmu=fmu)
            spent = time.perf_counter() - begin
        rows.append(Row(f"export{' with FMU' if fmu else ''}", f"{spent:.1f} s", "seconds", spent < 10.0))
    return rows
