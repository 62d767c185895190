"""Single steps of a controller from Python, beside the call of simple-pid and the same step in plain Python."""

import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from importlib.util import find_spec
from multiprocessing import get_context
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff import load_scenario
from adaptive_ff.comparison.registry import make_controller
from benchmarks.speed_rows import Row
from controllers import Controller

STEPPED = ("pi", "fixed", "adaptive")

LONGEST_STEP = 1e-3  # s; one in a thousand may be longer than the period at 1 kHz
MEDIAN_STEP = 1e-4  # s
RATIO_TO_SIMPLE_PID = {"pi": 1.5, "adaptive": 2.5}

QUANTILES = {"median": 0.5, "99th percentile": 0.99, "99.9th percentile": 0.999}

SLOWER = 10
"""Factor by which there are fewer calls in plain Python."""

CLOCK = time.perf_counter_ns

Call = Callable[[int], float]
"""Does one sample of a number and returns the time that it took, s."""

Times = NDArray[np.float64]


def single_steps(calls: int) -> list[Row]:
    """Measure ``controller.step()`` with a number of calls after the first one."""
    rows = []
    for name in STEPPED:
        make_controller(load_scenario(), name).warm_up()  # the cache on disk holds it from here on
        cold = in_new_process(first_step, name, False)
        rows.append(Row(f"{name}: first, not warmed up", "none", cold))
        first, quantiles = in_new_process(warm_steps, name, calls)
        rows.append(Row(f"{name}: first after warm_up()", "not warmed up", first, cold, first / cold))
        ours, plain = quantiles["compiled"], quantiles["plain"]
        for label, limit in (("median", MEDIAN_STEP), ("99.9th percentile", LONGEST_STEP)):
            ratio = ours[label] / plain[label]
            rows.append(Row(f"{name}: {label}", "plain Python", ours[label], plain[label], ratio, largest=limit))
        rows += beside_simple_pid(name, ours, quantiles.get("simple-pid"))
    return rows


def beside_simple_pid(name: str, ours: dict[str, float], theirs: dict[str, float] | None) -> list[Row]:
    """Return the rows of a controller beside the call of simple-pid, or the reason why there are none."""
    if theirs is None:
        return [Row(f"{name}: simple-pid", "skipped: simple-pid is not installed")]
    rows, limit = [], RATIO_TO_SIMPLE_PID.get(name)
    for label in ("median", "99th percentile"):
        ratio = ours[label] / theirs[label]
        rows.append(Row(f"{name}: {label}, simple-pid", "simple-pid", ours[label], theirs[label], ratio, limit))
    return rows


def in_new_process(function: Callable[..., Any], *arguments: Any) -> Any:
    """Call a function in a fresh interpreter."""
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        return pool.submit(function, *arguments).result()


def first_step(name: str, warm: bool) -> float:
    """Return the time of the first step of a controller, s; meant for a process in which nothing has run."""
    controller = make_controller(load_scenario(), name)
    if warm:
        controller.warm_up()
    return steps_of(controller)(0)


def warm_steps(name: str, calls: int) -> tuple[float, dict[str, dict[str, float]]]:
    """Time single steps of a controller, its rivals' in turn with them; meant for a process in which nothing has run.

    Returns
    -------
    first : float
        Time of the first call after ``warm_up()``, s.
    quantiles : dict
        By job (``compiled``, ``plain`` and, where it is installed, ``simple-pid``), the quantiles of the others, s.
    """
    first = first_step(name, True)
    scenario = load_scenario()
    jobs = {
        "compiled": steps_of(make_controller(scenario, name)),
        "plain": steps_of(make_controller(scenario, name).run_uncompiled()),
    }
    if find_spec("simple_pid") is not None:
        jobs["simple-pid"] = simple_pid_calls(*scenario.feedback.gains, scenario.sampling.period)
    plain = jobs.pop("plain")
    times = {"plain": np.array([plain(k) for k in range(max(1, calls // SLOWER))])}
    turns = np.array([[call(k) for call in jobs.values()] for k in range(calls)])
    times |= dict(zip(jobs, turns.T, strict=True))
    return first, {job: quantiles_of(series) for job, series in times.items()}


def quantiles_of(times: Times) -> dict[str, float]:
    """Return the reported quantiles of times by name."""
    return {name: float(np.quantile(times, share)) for name, share in QUANTILES.items()}


def recorded_samples() -> tuple[list[float], list[float], list[float]]:
    """Return reference, next reference and measured velocity of the built-in scenario, as if tracking were perfect."""
    scenario = load_scenario()
    samples = scenario.reference_velocity()[:: scenario.substeps]
    return samples[:-1].tolist(), samples[1:].tolist(), (samples[:-1] + scenario.noise()).tolist()


def steps_of(controller: Controller) -> Call:
    """Return what steps a controller with the samples of the built-in scenario."""
    references, following, measured = recorded_samples()
    torque: float | None = None

    def call(k: int) -> float:
        nonlocal torque
        i = k % len(measured)
        now, velocity, coming = references[i], measured[i], following[i]
        begin = CLOCK()
        torque = controller.step(now, velocity, next_reference=coming, realised_torque=torque)
        return (CLOCK() - begin) * 1e-9

    return call


def simple_pid_calls(proportional: float, integral: float, period: float) -> Call:
    """Return what calls simple-pid with the same gains and samples; it is told the time, which saves it a clock."""
    from simple_pid import PID

    pid = PID(proportional, integral, 0.0, sample_time=None)
    references, _, measured = recorded_samples()

    def call(k: int) -> float:
        i = k % len(measured)
        pid.setpoint, velocity = references[i], measured[i]
        begin = CLOCK()
        pid(velocity, dt=period)
        return (CLOCK() - begin) * 1e-9

    return call
