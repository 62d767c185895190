"""Bits of the exported code beside the kernels: random inputs for all variants, closed loop on the matrix."""

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import adaptive_ff
from adaptive_ff import load_scenario, run_in_c, simulate
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.export.buffer import state_to_bytes
from adaptive_ff.simulation.experiment import build_setup
from benchmarks.export.driver import build, found, in_python, random_inputs, run, write_sources
from benchmarks.export.rows import Row, skipped
from benchmarks.export.variants import SEED, variants

LEVELS = ("-O0", "-O1", "-O2", "-O3")
SCENARIOS = Path(adaptive_ff.__file__).parent / "scenario" / "scenarios"
TARGET = "0 of all"


def random_runs(samples: int, levels: Sequence[str] = LEVELS) -> list[Row]:
    """Compare torque, feedforward and all of the state, for every variant, compiler and level."""
    compilers = [program for program in ("gcc", "clang") if found(program)]
    rows = [skipped(f"random inputs, {name}", "not installed") for name in ("gcc", "clang") if name not in compilers]
    builds = [(program, level) for program in compilers for level in levels]
    unequal: dict[tuple[str, str], list[str]] = {item: [] for item in builds}
    chosen = variants()
    for name, maker in chosen.items():
        inputs = random_inputs(maker(), samples, SEED)
        controller = maker()
        expected = in_python(controller, inputs)
        with tempfile.TemporaryDirectory() as folder:
            write_sources(maker(), Path(folder))
            for program, level in builds:
                built = build(Path(folder), [program, "-std=c99", level])
                outputs, state, _ = run([built], inputs)
                if outputs.tobytes() != expected.tobytes() or state != state_to_bytes(controller):
                    unequal[program, level].append(name)
    for (program, level), names in unequal.items():
        figure = f"{len(names)} of {len(chosen)} variants differ over {samples} samples"
        rows.append(Row(f"random inputs, {program} {level} -std=c99", figure, TARGET, not names))
        rows += [Row(f"  {name}", "differs") for name in names]
    return rows


class Own:
    """A controller's ``step`` as a user's own, so that the loop runs in plain Python."""

    def __init__(self, controller: Any) -> None:
        self.step = controller.step


def closed_loops(
    seconds: float | None = None, progress: Callable[[str], None] | None = None
) -> tuple[list[Row], list[Row]]:
    """Run the adaptive controller in closed loop in Python, in C, and in C in single precision.

    Returns
    -------
    identity, single : list of Row
        How many torque series and states differ; what single precision costs.
    """
    differing, costs = [], {}
    files = sorted(SCENARIOS.glob("*.toml"))
    for file in files:
        scenario = load_scenario(file)
        if seconds is not None and scenario.length > max(seconds, scenario.last_change + 1.0):
            scenario = scenario.modified(duration=max(seconds, scenario.last_change + 1.0))
        setup = build_setup(scenario)
        plain = make_controller(scenario, "adaptive").run_uncompiled()
        exact = run_in_c(make_controller(scenario, "adaptive"))
        rough = run_in_c(make_controller(scenario, "adaptive"), single=True)
        runs = [simulate(scenario, Own(item), setup=setup) for item in (plain, exact, rough)]
        same = runs[0].torque.tobytes() == runs[1].torque.tobytes()
        if not same or state_to_bytes(plain) != state_to_bytes(exact.in_python()):
            differing.append(file.stem)
        costs[file.stem] = runs[2].metrics.rms_error_settled / runs[1].metrics.rms_error_settled
        if progress is not None:
            progress(f"{file.stem}: {'same' if same else 'DIFFERENT'}, single precision {costs[file.stem]:.4f}")
    length = "their own length" if seconds is None else f"at most {seconds:g} s, or 1 s after the last change"
    identity = [
        Row(
            f"closed loop, {len(files)} scenarios of {length}, cc -O2",
            f"{len(differing)} differ",
            TARGET,
            not differing,
        )
    ]
    identity += [Row(f"  {name}", "differs") for name in differing]
    values = np.array(list(costs.values()))
    single = [
        Row("settled error in single over double precision, median", f"{np.median(values):.4f}"),
        Row("  scenarios within 0.1 %", f"{np.count_nonzero(np.abs(values - 1.0) <= 1e-3)} of {values.size}"),
        Row("  worst", f"{values.max():.4f} ({max(costs, key=lambda name: costs[name])})"),
        Row("  best", f"{values.min():.4f} ({min(costs, key=lambda name: costs[name])})"),
    ]
    return identity, single
