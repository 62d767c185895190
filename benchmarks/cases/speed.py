"""Time and memory: a step from Python, a group, a run, the command line, a log.

Figures are times in s (``median``, ``slow``: one in a thousand takes longer), ``memory``, the peak over the size of
what is kept, and ``ratio``, a time over that of what the row is compared with, which runs in turn with it.
"""

import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any

import numpy as np

from adaptive_ff import JointGroup, Scenario, load_scenario, simulate
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.errors import InputError
from adaptive_ff.logs.log import read_log
from adaptive_ff.studies.study import Found, run_study
from adaptive_ff.studies.sweep import run_draw
from benchmarks.suite import Rows, seeded

CALLS = 50_000  # steps that are timed of a single controller; a tenth of them of a group
JOINTS = (1, 6, 24)  # sizes of groups
ROWS = 200_000  # rows of the log that is read
DRAWS = 1000  # joints of the sweep

CACHES = ("MPLCONFIGDIR", "XDG_CACHE_HOME", "ADAPTIVE_FF_CACHE")  # variables of where caches are
ROOT = Path(__file__).resolve().parents[2]

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

    torque = [np.zeros(joints)]

    def call(k: int) -> None:
        last, following = torque[0], references[k + 1]
        torque[0] = group.step(references[k], measured[k], next_reference=following, realised_torque=last)

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


def run_measurement(row: str, measure: Callable[[list[str]], Found], seed: int, controllers: list[str]) -> Found:
    """Measure what belongs to a row; controllers that it does not concern have nothing."""
    found = measure(controllers)
    return {"": {"row": row}, **{name: found.get(name, {}) for name in controllers}}


def steps(controllers: list[str]) -> Found:
    """Time a step from Python, and its ratio to simple-pid's call."""
    found = in_turn({name: step_of(name) for name in controllers}, CALLS)
    for one in found.values():
        one["ratio"] = one["median"] / found["simple_pid"]["median"]
    return found


def group(joints: int, controllers: list[str]) -> Found:
    """Time a step of a group of adaptive joints, and its ratio to that of as many controllers."""
    found = in_turn({"adaptive": group_step("adaptive", joints), "one": step_of("adaptive")}, CALLS // 10)
    found["adaptive"]["ratio"] = found["adaptive"]["median"] / found["one"]["median"] / joints
    return found


def runs(scenario: Scenario, controllers: list[str]) -> Found:
    """Time whole runs of a scenario and measure their memory."""
    made = [name for name in controllers if name != "simple_pid"]
    found = in_turn({name: lambda _, name=name: simulate(scenario, name, uncertain=False) for name in made}, 5)
    for name in made:
        tracemalloc.start()
        run = simulate(scenario, name, uncertain=False)
        kept = sum(series.nbytes for series in run.columns().values())
        found[name] = {"median": found[name]["median"], "memory": tracemalloc.get_traced_memory()[1] / kept}
        tracemalloc.stop()
    return found


def of_adaptive(measure: Callable[[], dict[str, float]], controllers: list[str]) -> Found:
    """Return what is measured, all under ``adaptive``."""
    return {"adaptive": measure()} if "adaptive" in controllers else {}


def commands() -> dict[str, float]:
    """Time ``adaptive-ff --help`` and a first and a later ``compare``, whole processes."""
    with tempfile.TemporaryDirectory() as folder:
        fresh = {**os.environ, **dict.fromkeys(CACHES, folder), "PYTHONDONTWRITEBYTECODE": ""}
        command = [sys.executable, "-m", "adaptive_ff"]
        timed([sys.executable, "-m", "compileall", "-q", "adaptive_ff", "plant", "controllers"], cwd=ROOT)  # as pip
        compare = [*command, "compare", "--out", str(Path(folder, "out"))]
        return {
            "help": np.median([timed([*command, "--help"], env=fresh)[0] for _ in range(5)]).item(),
            "first_compare": timed(compare, env=fresh)[0],
            "later_compare": np.median([timed(compare, env=fresh)[0] for _ in range(3)]).item(),
            "first_step": np.median([timed([sys.executable, "-c", FIRST_STEP], env=fresh)[0] for _ in range(5)]).item(),
        }


REPLAYED = 1_000_000  # samples at 1 kHz of the log that is replayed

REPLAY = """import re, sys
from pathlib import Path
from adaptive_ff.cli.main import app
app(sys.argv[1:], standalone_mode=False)
print(re.search(r"VmHWM:\\s+(\\d+)", Path("/proc/self/status").read_text())[1])
"""
FIRST_STEP = """from adaptive_ff import AdaptiveController
joint = {"inertia": 20.0, "stribeck_velocity": 0.05, "torque_limit": 400.0}
AdaptiveController(1200.0, 5000.0, 0.01, **joint).step(0.1, 0.0)
"""


def sweeping() -> dict[str, float]:
    """Time a sweep of joints in one thread and in two."""
    draw, names = partial(run_draw, load_scenario(), 1, {}), ["pi", "oracle", "adaptive"]
    cases = {str(number): number for number in range(DRAWS)}
    sweep = partial(run_study, draw, cases, names, threads=True)
    times = in_turn({"one": lambda _: sweep(workers=1), "two": lambda _: sweep(workers=2)}, 3)
    one, two = (times[name]["median"] for name in ("one", "two"))
    return {"one": one, "two": two, "ratio": two / one}


def installed() -> dict[str, float]:
    """Measure what is installed with the package, MB."""
    pending, known, total = ["adaptive-ff"], set(), 0
    while pending:
        name = pending.pop()
        with suppress(PackageNotFoundError):  # what other systems need
            found = distribution(name)
            if found.name not in known:
                known.add(found.name)
                files = (Path(str(file.locate())) for file in found.files or ())
                total += sum(file.stat().st_size for file in files if file.is_file())
                pending += [re.split(r"[^\w.-]", line)[0] for line in found.requires or () if "extra ==" not in line]
    return {"megabytes": total / 1e6}


OWN = """import time
from adaptive_ff import load_scenario, simulate

class Own:
    total = 0.0

    def step(self, reference, velocity, **others):
        error = reference - velocity
        self.total += 50.0 * error
        return 1200.0 * error + self.total

def run():
    begin = time.perf_counter()
    simulate(load_scenario(), Own(), uncertain=False)
    return time.perf_counter() - begin

print(sorted(run() for _ in range(11))[5])
"""
"""Prints the median time of a run of the built-in scenario with a controller of one's own."""

FIRST_COMMAND = "python3 -m venv .venv && .venv/bin/pip install --quiet {} && .venv/bin/adaptive-ff compare"
FIRST_COMMAND += f" && .venv/bin/python -c {shlex.quote(OWN)}"
AHEAD = "python3 -m venv .venv && .venv/bin/pip wheel --quiet --no-deps --wheel-dir {} ."
NOT_COPIED = (".*", "build", "*.egg-info", "__pycache__", "results")  # of the checkout
EARLIER = "9787daa"  # the version that first commands are compared with; numba compiled its kernels


def in_copy(command: str, *path: str, version: str = "", **variables: str) -> list[tuple[float, str]]:
    """Time the parts of a command in a copy of the checkout, or of a version in its history; its home is empty."""
    with tempfile.TemporaryDirectory() as home:
        copy, archive = Path(home, "copy"), Path(home, "version.tar")
        if version:
            timed(f"git archive --output={archive} {version}", shell=True, cwd=ROOT)
            shutil.unpack_archive(archive, copy)
        else:
            shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns(*NOT_COPIED))
        kept = {key: value for key, value in os.environ.items() if key not in ("CC", *CACHES)}
        known = {**kept, **variables, "HOME": home, "PATH": os.pathsep.join(path)}
        return [timed(part, shell=True, cwd=copy, env=known) for part in command.split(" && ")]


def first_command(*path: str, install: str = ".", version: str = "") -> list[float]:
    """Time the parts of README's first command, and then a run with a controller of one's own (s)."""
    *parts, own = in_copy(FIRST_COMMAND.format(install), *path, version=version)
    return [*(spent for spent, _ in parts), float(own[1])]


def first_commands() -> dict[str, float]:
    """Time README's first command: with this machine's compilers, with zig alone, of a wheel; and ratios to an earlier.

    ``compare`` is its last part, the first comparison after the installation with a compiler, and ``own`` the time of a
    run with a controller in Python. Building the wheel goes before and does not count; the earlier version runs before
    and after the others. Without this version in the history of git there are no ratios; without a package index there
    is ``InputError``.
    """
    earlier = list[list[float]]()
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "python3").symlink_to(sys.executable)  # and no compiler
        both = folder, os.environ["PATH"]
        in_copy(AHEAD.format(folder), *both, ADAPTIVE_FF_AHEAD="1")
        (wheel,) = Path(folder).glob("*.whl")
        with suppress(InputError):
            earlier.append(first_command(*both, version=EARLIER))
        parts = {
            "with_compiler": first_command(*both),
            "with_zig": first_command(folder),
            "from_wheel": first_command(folder, install=str(wheel)),
        }
        with suppress(InputError):
            earlier.append(first_command(*both, version=EARLIER))
    found = {name: sum(spent[:-1]) for name, spent in parts.items()}
    found["compare"], found["own"] = parts["with_compiler"][-2:]
    if not earlier:
        return found
    *before, compare, own = np.mean(earlier, axis=0).tolist()
    whole, alone = sum(before) + compare, {"compare": compare, "own": own}
    ratios = {f"{name}_ratio": spent / alone.get(name, whole) for name, spent in found.items()}
    return {**found, "earlier": whole, "earlier_compare": compare, "earlier_own": own, **ratios}


def timed(command: str | list[str], **there: Any) -> tuple[float, str]:
    """Return the time of a command, a process of its own (s), and what it prints."""
    begin = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, check=False, **there)
    spent = time.perf_counter() - begin
    if done.returncode:
        raise InputError(f"{command}: {done.stderr.strip().rpartition(chr(10))[2]}")
    return spent, done.stdout


def log_read() -> dict[str, float]:
    """Measure the peak of the memory that reading a CSV log takes, over the size of its columns."""
    with tempfile.TemporaryDirectory() as folder:
        path, time_ = Path(folder) / "log.csv", 0.001 * np.arange(ROWS)
        rows = np.column_stack([time_, np.sin(time_), np.cos(time_)])
        np.savetxt(path, rows, fmt="%.6f", delimiter=",", header="t,q,u", comments="")
        tracemalloc.start()
        read_log(path, time="t", position="q", torque="u")
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    return {"memory": peak / (3 * 8 * ROWS)}


def replayed() -> dict[str, float]:
    """Time the replay of a log of a joint in closed form, a whole process, and its peak memory over the log's size."""
    with tempfile.TemporaryDirectory() as folder:
        path, time_ = Path(folder) / "log.npz", 0.001 * np.arange(REPLAYED)
        omega, size = 2.0 * np.pi * np.array([[0.0713], [0.2391], [0.917]]), np.array([[0.25], [0.15], [0.05]])
        velocity = np.sum(size * np.sin(omega * time_), axis=0)
        torque = 2.0 * np.sum(size * omega * np.cos(omega * time_), axis=0) + 3.0 * np.sign(velocity) + 4.0 * velocity
        noise = 0.05 * np.random.default_rng(101).standard_normal(time_.size)
        np.savez(path, time=time_, velocity=velocity, torque=torque + noise)
        command = [sys.executable, "-c", REPLAY, "replay", str(path), "--out", str(Path(folder, "out"))]
        spent, printed = timed(command)
        return {"median": spent, "memory": 1024.0 * float(printed.splitlines()[-1]) / path.stat().st_size}


def listed() -> Rows:
    """Return all measurements: what measures, by the key of the case."""
    scenarios = {
        "60 s at 100 Hz": load_scenario(),
        "60 s at 1 kHz": load_scenario("noisy_1khz"),
        "10 000 s at 100 Hz, thinned": load_scenario().modified(duration=10_000.0),
    }
    alone = {
        "commands": ("command line", commands),
        "log": ("reading a log", log_read),
        "replay": (f"replay of {REPLAYED} samples", replayed),
        "sweep": ("a sweep", sweeping),
        "installed": ("installed", installed),
        "first command": ("README's first command", first_commands),
    }
    return {
        "step": ("a step from Python", steps),
        **{f"group {joints}": (f"a step of {joints} joints", partial(group, joints)) for joints in JOINTS},
        **{row: (row, partial(runs, scenario)) for row, scenario in scenarios.items()},
        **{name: (row, partial(of_adaptive, measure)) for name, (row, measure) in alone.items()},
    }


measurements = seeded(run_measurement, listed)
