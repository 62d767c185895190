"""What is measured of the exported C, by the name of a section: bits, machines, sizes, time, single precision."""

import math
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff import export_controller, load_scenario, run_in_c, simulate
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.export.buffer import state_to_bytes
from adaptive_ff.scenario.library import SCENARIOS
from adaptive_ff.simulation.experiment import build_setup
from benchmarks.cases.reports import Row, limited
from benchmarks.export.chips import M4, M7
from benchmarks.export.project import (
    adaptive,
    compiled,
    compilers,
    difference,
    exported,
    run,
    variants,
    zig,
)
from controllers import compiled as compiled_kernel
from controllers import planned_inputs, step

WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-pedantic", "-Werror")
CLOSENESS = 1e-11  # largest difference of another machine's torque to Python's, over the largest torque
ALLOWED = {"exp", "expm1", "log", "pow", "sqrt", "memcpy", "memset"}
EMULATED = {
    "x86_64": ("x86_64-linux-musl", ""),
    "aarch64": ("aarch64-linux-musl", "qemu-aarch64"),
    "ARMv7": ("arm-linux-musleabihf", "qemu-arm"),
    "riscv64": ("riscv64-linux-musl", "qemu-riscv64"),
}
OBJECTS = {"Cortex-M7, double": M7, "Cortex-M4F, double in software": M4, "Cortex-M4F, single": M4}
SANITIZERS = ("-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
LARGEST_RATIO = 1.2  # processor time of a step in C over that of the compiled kernels
STEPS, REPEATS, CALLS = 20_000, 15, 5000
SHORT = 2.0  # s of a closed loop, or a second after the last change


def exporting() -> list[Row]:
    """Time an export without and with the FMU's compilation, and ``controller.step()`` in Python and in C."""
    rows = []
    for fmu in (False, True):
        with tempfile.TemporaryDirectory() as folder:
            begin = time.perf_counter()
            export_controller(adaptive("directions", 1.5, 0.004), folder, with_fmu=fmu)
            spent = time.perf_counter() - begin
        rows.append(limited(f"export{' with FMU' if fmu else ''}", spent, 10.0))
    controller = adaptive("symmetric")
    for name, item in {"compiled Python": controller, "C": run_in_c(controller)}.items():
        best = min(_spent(item) for _ in range(5))
        rows.append(Row(f"controller.step() in {name}", 1e6 * best / CALLS))
    return rows


def _spent(controller: Any) -> float:
    begin = time.process_time()
    for _ in range(CALLS):
        controller.step(0.1, 0.1, next_reference=0.1)
    return time.process_time() - begin


def objects() -> list[Row]:
    """Compile objects with all warnings, and say whether they need more than mathematics and copying."""
    rows = []
    library = ALLOWED | {f"{name}f" for name in ALLOWED}
    for name, command in OBJECTS.items():
        if not shutil.which(command[0]):
            rows.append(Row(f"object for {name}", "skipped"))
            continue
        with exported(adaptive("offset"), single=name.endswith("single")) as folder:
            rows.append(Row(f"object for {name}", compiled(folder, command, *WARNINGS)[0], "compiles", True))
            needed = {line.split()[-1] for line in run(folder, "arm-none-eabi-nm", "-u", "drive.o").splitlines()}
            own = needed - library
            rows.append(
                Row("undefined symbols", len(own), "arithmetic", all(one.startswith("__aeabi_") for one in own))
            )
    return rows


def machines() -> list[Row]:
    """Repeat a recorded run of the adaptive controller, by direction and with a delay, with another libm."""
    rows, command = [], zig()
    with exported(adaptive("directions", 1.5, 0.004)) as folder:
        for name, (triple, emulator) in EMULATED.items():
            what = f"random inputs, musl on {name}"
            if command is None or (emulator and not shutil.which(emulator)):
                rows.append(Row(what, "skipped"))
                continue
            worst = difference(folder, [*command, "-O2", "-static", "-target", triple], [emulator] if emulator else [])
            rows.append(limited(what, worst, CLOSENESS))
    return rows


def sanitized() -> list[Row]:
    """Repeat it under the sanitizers for addresses and undefined behaviour, which end a program that is at fault."""
    if "gcc" not in compilers():
        return [Row("sanitizers", "skipped")]
    with exported(adaptive("directions", 1.5, 0.004)) as folder:
        return [limited("sanitizers: address, undefined", difference(folder, ["gcc", *SANITIZERS]), 0.0)]


def bits() -> list[Row]:
    """Repeat a recorded run of every variant, and count those that differ by compiler and level."""
    builds = [(program, f"-O{level}") for program in compilers() for level in range(4)]
    unequal: dict[tuple[str, str], list[str]] = {build: [] for build in builds}
    for name, maker in variants().items():
        with exported(maker()) as folder:
            for build in builds:
                if difference(folder, build) > 0.0:
                    unequal[build].append(name)
    return [
        limited(f"random inputs, {program} {level} -std=c99", len(names), 0)
        for (program, level), names in unequal.items()
    ]


class Own:
    """A controller's ``step`` as a user's own, so that the loop runs in plain Python."""

    def __init__(self, controller: Any) -> None:
        self.step = controller.step


def closed_loops() -> list[Row]:
    """Run the adaptive controller in closed loop on all scenarios in Python, in C, and in C in single precision."""
    differing, costs = 0, []
    for file in sorted(SCENARIOS.glob("*.toml")):
        scenario = load_scenario(file)
        scenario = scenario.modified(duration=min(scenario.length, max(SHORT, scenario.last_change + 1.0)))
        plain = make_controller(scenario, "adaptive").run_uncompiled()
        exact = run_in_c(make_controller(scenario, "adaptive"))
        rough = run_in_c(make_controller(scenario, "adaptive"), single=True)
        runs = [simulate(scenario, Own(one), setup=build_setup(scenario)) for one in (plain, exact, rough)]
        same = runs[0].torque.tobytes() == runs[1].torque.tobytes()
        differing += not same or state_to_bytes(plain) != state_to_bytes(exact.in_python())
        costs.append(runs[2].metrics.rms_error_settled / runs[1].metrics.rms_error_settled)
    values = np.array(costs)
    return [
        limited("closed loop, cc -O2: scenarios that differ", differing, 0),
        Row("settled error in single over double precision, median", float(np.median(values))),
        Row("scenarios within 0.1 %", float(np.mean(np.abs(values - 1.0) <= 1e-3))),
        Row("worst", float(values.max())),
        Row("best", float(values.min())),
    ]


def _run_series(native: Any, state: Any, references: NDArray[np.float64], torques: NDArray[np.float64]) -> Any:
    for k in range(torques.size):
        inputs = planned_inputs(references[k], 0.97 * references[k], references[k + 1], math.nan, 0.01)
        output, state = step(native, state, inputs)
        torques[k] = output.torque
    return state


run_series = compiled_kernel(_run_series)


def steps() -> list[Row]:
    """Compare processor time a step: median over the repeats of the ratio of runs in turn; the machine may be busy."""
    controller = adaptive("symmetric")
    references, torques = 0.3 * np.sin(0.02 * np.arange(STEPS + 1.0)), np.zeros(STEPS)
    run_series(controller.native, 0, references, torques)  # compiles
    times = []
    with exported(adaptive("symmetric")) as folder:
        shutil.copy(Path(__file__).with_name("timed.c"), folder)
        builds = [(program, level) for program in compilers() for level in ("-O2", "-O3")]
        for program, level in builds:
            run(folder, program, "-std=c99", level, "drive.c", "timed.c", "-o", program + level, "-lm")
        for _ in range(REPEATS):
            controller.reset()
            begin = time.process_time()
            run_series(controller.native, 0, references, torques)
            times.append([(time.process_time() - begin) / STEPS])
            for build in builds:
                command = [folder / "".join(build), str(STEPS)]
                done = subprocess.run(command, input=references.tobytes(), capture_output=True, check=True)
                spent, last = map(float, done.stdout.split())
                times[-1].append(spent)
                if last != torques[-1]:
                    raise ArithmeticError(f"{' '.join(build)} gives other torques than compiled Python")
    table = np.array(times)
    ratios = np.median(table / table[:, :1], axis=0)[1:]
    return [
        limited(f"step, {' '.join(build)} over compiled Python, same torques", float(ratio), LARGEST_RATIO)
        for build, ratio in zip(builds, ratios, strict=True)
    ]


EXPERIMENTS: dict[str, Callable[[], list[Row]]] = {
    "python": exporting,
    "objects": objects,
    "machines": machines,
    "sanitizers": sanitized,
    "speed": steps,
    "random": bits,
    "closed": closed_loops,
}
"""What is measured, by the name of a section."""
