"""Compiles ahead what comes with a wheel, ``python -m adaptive_ff.cli.ahead FOLDER``: steps, loops, kernels over a log.

What is wanted is asked for once, in plain Python, and then compiled in a few files, in which kernels share what they
call: a compiler's start costs more than most kernels. Any other kernel is compiled when it is first asked for.
"""

import os
import shutil
import sys
import tempfile
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from adaptive_ff.comparison.registry import CONTROLLERS, make_controller
from adaptive_ff.friction.columns import columns_along
from adaptive_ff.replay.learning import initial_state, learn, make_learner
from adaptive_ff.scenario.library import scenario_names
from adaptive_ff.scenario.scenario import load_scenario
from adaptive_ff.simulation.experiment import build_setup, empty_record
from adaptive_ff.simulation.loop import run_in_memory, start_position
from controllers import Native, difference_velocity, direct_velocity, kalman_velocity, low_pass_velocity
from controllers.delay import LENGTHS
from controllers.kernels.compiler import NoCompiler
from controllers.kernels.library import BUILT, cache_directory, collected, compile_kernels, stepper
from controllers.native import NativeParameters, empty_exchange

ESTIMATORS: dict[str, Callable[[], Any]] = {
    "direct": partial(direct_velocity, 0.01),
    "difference": partial(difference_velocity, 0.01),
    "kalman": partial(kalman_velocity, 0.5, 10.0, 1.0, 0.01),
    "low_pass": partial(low_pass_velocity, 30.0, 0.01),
}


def lengthened(state: Any, length: int) -> Any:
    """Return a state whose delay lines have a length; they are the only tuples of one number."""
    if not isinstance(state, tuple):
        return state
    if not hasattr(state, "_fields") and len(state) == 1:
        return state * length
    items = [lengthened(item, length) for item in state]
    return type(state)(*items) if hasattr(state, "_fields") else tuple(items)


def ask_for_loop(scenario: str, estimator: str) -> None:
    """Ask for the loop over the joint of a scenario with a velocity estimator, which serves every controller."""
    setup = build_setup(load_scenario(scenario))._replace(observer=ESTIMATORS[estimator]())
    anyone = NativeParameters(0, 0, 0, 0, 0, empty_exchange())
    run_in_memory(anyone, 0, setup, start_position(setup), 0, empty_record(setup, 1, 1))


def ask_for_log() -> None:
    """Ask for what the commands on a log need beside steps and loops."""
    usual: dict[str, Any] = {"fast": 1.0, "torque": 1.0, "accelerated": 1.0, "inertia": 1.0, "stribeck_velocity": 0.1}
    learner = make_learner(**usual, parameters=(), ripples=())
    columns = np.zeros((1, len(learner.names)))
    learn(learner, initial_state(learner), columns, np.zeros(1), np.zeros(1, dtype=np.bool_), 0.01, 1.0)
    columns_along(learner.hypothesis, learner.curve, np.zeros(2), 0.01)


def ask_for_all() -> None:
    """Ask for everything that comes with a wheel."""
    # what is identified or tuned by a simulation first has the kernels of others
    names = [name for name in reversed(CONTROLLERS) if not name.endswith(("_batch", "_tuned"))]
    kinds = {type(one.parameters): one for one in (make_controller(load_scenario(), name) for name in names)}
    joints = {type(load_scenario(name).joint.parameters): name for name in reversed(scenario_names())}
    for controller in kinds.values():
        for length in LENGTHS:  # of delay lines
            with suppress(NoCompiler):
                Native(controller.parameters, lengthened(controller.state, length))
    for joint in joints.values():
        for each in ESTIMATORS:
            ask_for_loop(joint, each)
    ask_for_log()


def main(target: Path) -> None:
    """Compile everything and copy it into a folder of the package."""
    with tempfile.TemporaryDirectory() as folder:
        os.environ["ADAPTIVE_FF_CACHE"] = folder
        cache_directory.cache_clear()
        with collected() as wanted, warnings.catch_warnings(action="ignore"):
            ask_for_all()
        workers = os.cpu_count() or 1
        left, size = iter(wanted.items()), -(-len(wanted) // (2 * workers))
        parts = iter(lambda: dict(islice(left, size)), {})
        with ThreadPoolExecutor(workers) as pool:  # one translates while the compiler of another one runs
            list(pool.map(compile_kernels, parts))
        stepper()
        library = target / BUILT.name
        shutil.rmtree(library, ignore_errors=True)
        shutil.copytree(cache_directory(), library, ignore=shutil.ignore_patterns("*.part", "tmp*"))
    print(f"compiled {len(wanted)} kernels", file=sys.stderr)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
