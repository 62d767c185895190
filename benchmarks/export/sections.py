"""What is measured of the exported C, by the name of a section: bits, machines, time, single precision."""

import shutil
import tempfile
import time
import timeit
from collections.abc import Callable
from typing import Any

import numpy as np

from adaptive_ff import export_controller, load_scenario, run_in_c, simulate
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.export.buffer import state_to_bytes
from adaptive_ff.scenario.library import scenario_names
from adaptive_ff.simulation.experiment import build_setup
from benchmarks.cases.reports import Row, limited
from benchmarks.export.project import LATE, PROMPT, adaptive, announced, difference, exported, variants, zig

CLOSENESS = 1e-11  # largest difference of another machine's torque to Python's, over the largest torque
CALLS = 5000
EMULATED = {
    "x86_64": ("x86_64-linux-musl", ""),
    "aarch64": ("aarch64-linux-musl", "qemu-aarch64"),
    "ARMv7": ("arm-linux-musleabihf", "qemu-arm"),
    "riscv64": ("riscv64-linux-musl", "qemu-riscv64"),
}
SHORT = 2.0  # s of a closed loop, or a second after the last change


def exporting() -> list[Row]:
    """Time an export without and with the FMU's compilation, and ``controller.step()`` in Python and in C."""
    rows = []
    for fmu in (False, True):
        with tempfile.TemporaryDirectory() as folder:
            begin = time.perf_counter()
            export_controller(adaptive(LATE, "directions"), folder, with_fmu=fmu)
            spent = time.perf_counter() - begin
        rows.append(limited(f"export{' with FMU' if fmu else ''}", spent, 10.0))
    controller = adaptive(PROMPT, "symmetric")
    for name, item in {"compiled Python": controller, "C": run_in_c(controller)}.items():
        step = "step(0.1, 0.1, next_reference=0.1)"
        best = min(timeit.repeat(step, timer=time.process_time, number=CALLS, globals={"step": item.step}))
        rows.append(Row(f"controller.step() in {name}", 1e6 * best / CALLS))
    return rows


def machines() -> list[Row]:
    """Repeat a recorded run of the adaptive controller, by direction and with a delay, with another libm."""
    rows, command = [], zig()
    with exported(adaptive(LATE, "directions")) as folder:
        for name, (triple, emulator) in EMULATED.items():
            what = f"random inputs, musl on {name}"
            if command is None or (emulator and not shutil.which(emulator)):
                rows.append(Row(what, "skipped"))
                continue
            worst = difference(folder, [*command, "-O2", "-static", "-target", triple], [emulator] if emulator else [])
            rows.append(limited(what, worst, CLOSENESS))
    return rows


def bits() -> list[Row]:
    """Repeat a recorded run of every variant, and count those that differ by compiler and level."""
    builds = [(program, f"-O{level}") for program in ("gcc", "clang") if shutil.which(program) for level in range(4)]
    unequal = dict.fromkeys(builds, 0)
    makers = variants()
    for name in announced("random inputs", makers):
        with exported(makers[name]()) as folder:
            for build in builds:
                unequal[build] += difference(folder, build) > 0.0
    return [limited(f"random inputs, {' '.join(build)} -std=c99", count, 0) for build, count in unequal.items()]


class Own:
    """A controller's ``step`` as a user's own, so that the loop runs in plain Python."""

    def __init__(self, controller: Any) -> None:
        self.step = controller.step


def closed_loops() -> list[Row]:
    """Run the adaptive controller in closed loop on all scenarios in Python, in C, and in C in single precision."""
    differing, costs = 0, []
    for name in announced("closed loops", scenario_names()):
        scenario = load_scenario(name)
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


EXPERIMENTS: dict[str, Callable[[], list[Row]]] = {
    "python": exporting,
    "machines": machines,
    "random": bits,
    "closed": closed_loops,
}
"""What is measured, by the name of a section."""
