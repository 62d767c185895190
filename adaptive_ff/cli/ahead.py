"""Compiles ahead what comes with a wheel, ``python -m adaptive_ff.cli.ahead FOLDER``: steps, loops, commands on a log.

What is wanted is run once, with a cache of its own; what that compiles is the library. So nothing is listed that could
be forgotten: a kernel that these runs reach is there, and any other is compiled when it is first asked for.
"""

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from operator import call
from pathlib import Path
from typing import Any

from adaptive_ff.adaptive.group import JointGroup
from adaptive_ff.comparison.registry import CONTROLLERS, make_controller
from adaptive_ff.scenario.library import scenario_names
from adaptive_ff.scenario.scenario import load_scenario
from adaptive_ff.simulation.experiment import build_setup, empty_record
from adaptive_ff.simulation.loop import run_controller, start_position
from controllers import Native, difference_velocity, direct_velocity, kalman_velocity, low_pass_velocity
from controllers.delay import LENGTHS
from controllers.kernels.cache_directory import BUILT, cache_directory

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


def compile_steps(name: str, length: int) -> None:
    """Compile step, estimates and monitors of a controller for a length of delay lines."""
    controller = make_controller(load_scenario(), name)
    Native(controller.parameters, lengthened(controller.state, length))


def compile_loop(scenario: str, estimator: str) -> None:
    """Compile the loop over the joint of a scenario with a velocity estimator, which serves every controller."""
    setup = build_setup(load_scenario(scenario))._replace(observer=ESTIMATORS[estimator]())
    controller = make_controller(load_scenario(), "pi")
    run_controller(controller, setup, start_position(setup), 1, empty_record(setup, 1, 1))


def compile_group() -> None:
    """Compile the steps of a group of joints."""
    adaptive = make_controller(load_scenario(), "adaptive")
    group = JointGroup({"joint": adaptive})
    group.step([0.0], [0.0])


def run_commands() -> None:
    """Compile what the commands on a log need beside steps and loops."""
    with tempfile.TemporaryDirectory() as folder:
        command, log = [sys.executable, "-m", "adaptive_ff"], str(Path(folder, "results", "pi.csv"))
        columns = ["--velocity", "measured", "--torque", "torque"]
        for words in (["compare"], ["identify", log, *columns], ["replay", log, *columns]):
            subprocess.run([*command, *words, "--out", str(Path(folder, "results"))], check=True, stdout=sys.stderr)


def jobs() -> list[Callable[[], None]]:
    """Return steps and loops, each a job of its own."""
    kinds = {type(make_controller(load_scenario(), name).parameters): name for name in reversed(CONTROLLERS)}
    joints = {type(load_scenario(name).joint.parameters): name for name in reversed(scenario_names())}
    found: list[Callable[[], None]] = [compile_group]
    found += [partial(compile_steps, name, length) for name in kinds.values() for length in LENGTHS]
    found += [partial(compile_loop, joint, each) for joint in joints.values() for each in ESTIMATORS]
    return found


def main(target: Path) -> None:
    """Compile everything and copy it into a folder of the package."""
    with tempfile.TemporaryDirectory() as folder:
        os.environ["ADAPTIVE_FF_CACHE"] = folder
        cache_directory.cache_clear()
        with ProcessPoolExecutor(os.cpu_count()) as pool:
            list(pool.map(call, jobs()))
        run_commands()
        library = target / BUILT.name
        shutil.rmtree(library, ignore_errors=True)
        shutil.copytree(cache_directory(), library, ignore=shutil.ignore_patterns("*.part", "tmp*"))
    print(f"compiled {len(list(library.glob('*.record')))} kernels", file=sys.stderr)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
