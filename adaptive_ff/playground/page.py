"""The page: ``adaptive-ff playground`` puts code, numbers and looks into one file that needs nothing else.

Controllers, joint and sensor run in the browser from the kernels of this package. What is no kernel (scenarios, the
design of the loop, what ``AdaptiveController`` computes when it is made) the page does not do anew: it holds what the
package computed for every stop of every slider. That is possible because no two sliders change the same number, which
:func:`_machine` checks. References are held as integers of ``2^-44`` of their peak, 6e-14 of it; functions such as
``exp`` are those of the browser, where a machine has those of its C library. Both together move the series that a run
gives by less than 1e-8 of their largest values: some 2e-9 of the built-in scenario.
"""

import base64
import json
import shutil
import subprocess
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from adaptive_ff import __version__
from adaptive_ff.comparison.registry import make_controller
from adaptive_ff.errors import InputError
from adaptive_ff.files import staged
from adaptive_ff.playground.machines import Machine, Slider, machines
from adaptive_ff.playground.webassembly import Blob, Json, changes, image, webassembly
from adaptive_ff.scenario.axis_units import axis_unit
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.simulation.experiment import build_setup, empty_record
from adaptive_ff.simulation.loop import start_position
from adaptive_ff.simulation.metrics import first_motion
from adaptive_ff.simulation.tracking_errors import LEAST_OF_MEDIAN, error_slices
from controllers.kernels.sources import package_root

CONTROLLERS = ("pi", "adaptive")
SHOWN = {"inertia": 1.0, "coulomb": 1.0, "stiction": 1.0, "friction_lag": 1e3}
"""Estimates that are drawn, of which the first sliders have the true values; factors to the units of those."""

FRACTION, DIFFERENCES = 44, 5
"""Bits of a reference behind the point, and how often differences of it are taken before it is packed."""


def arguments(scenario: Scenario, name: str) -> tuple[Any, ...]:
    """Return what a compiled run of a controller is called with."""
    controller, setup = make_controller(scenario, name), build_setup(scenario)
    record = empty_record(setup, len(controller.estimate_names), len(controller.monitor_names))
    run = (controller.parameters, controller.state, setup, start_position(setup), 0, record)
    count = len(controller.estimate_names)
    return run if name == "pi" else (*run, np.zeros((count, controller.state.estimate.mean.size)), np.zeros(count))


def _spans(scenario: Scenario) -> Json:
    """Return where errors count, as places on the solver's grid: settled, start, length of a window."""
    reference, period = scenario.reference_velocity(), scenario.joint.solver_period
    times = [change.time for change in scenario.change]
    begin = first_motion(reference) * period
    settled, start, windows, _ = error_slices(reference.size, period, begin=begin, changes=times)
    return {"settled": settled.start, "start": [start.start, start.stop], "window": windows[0].stop}


def _reference(scenario: Scenario, peak: float) -> bytes:
    """Return a reference over its peak, packed: differences of integers, which are small."""
    numbers = np.rint(scenario.reference_velocity() / peak * 2.0**FRACTION).astype(np.int64)
    for _ in range(DIFFERENCES):
        numbers = np.diff(numbers, prepend=0)
    return numbers.astype(np.float64).tobytes()


def _slider(machine: Machine, slider: Slider, blob: Blob) -> Json:
    """Return a slider, with what each of its stops changes in the file, in the memory of both runs, and in figures."""
    motion = next(iter(machine.motions))
    stops = range(len(slider.stops))
    found = [machine.modified(motion, slider.beside, slider.changed(stop)) for stop in stops]
    return {
        **{name: getattr(slider, name) for name in ("name", "unit", "says", "stops", "start")},
        "tables": [slider.changed(stop) for stop in stops],
        "changes": [changes([arguments(one, name) for one in found], blob) for name in CONTROLLERS],
        "settled": [_spans(one)["settled"] for one in found],
        "noise": [one.sensor.velocity_noise for one in found],
    }


def _machine(machine: Machine, blob: Blob, runs: dict[str, tuple[Any, ...]]) -> Json:
    """Return a machine with its sliders; its runs are added where there are none of their kinds yet."""
    scenario, axis = machine.scenario, machine.scenario.joint.axis
    kind = type(scenario.velocity_estimator).__name__
    for name in CONTROLLERS:
        runs.setdefault(f"{name}_{kind}", arguments(scenario, name))
    sliders = [_slider(machine, slider, blob) for slider in machine.sliders]
    for k in range(len(CONTROLLERS)):
        places = [leaf[0] for slider in sliders for part in slider["changes"][k].values() for leaf in part]
        if len(set(places)) < len(places):
            raise InputError(f"{machine.name}: two sliders change one number; a page holds no product of their stops")
    controller = make_controller(scenario, "adaptive")
    motion = next(iter(machine.motions))
    base = machine.modified(motion)
    unit_noise = machine.modified(motion, {"sensor": {"encoder_resolution": None, "velocity_noise": 1.0}})
    return {
        "name": machine.name,
        "runs": [f"{name}_{kind}" for name in CONTROLLERS],
        "images": [image(arguments(base, name), blob) for name in CONTROLLERS],
        "names": controller.estimate_names,
        "sliders": sliders,
        "noise": blob.add(unit_noise.noise().tobytes()),
        "peak": machine.peak,
        "period": scenario.sampling.period,
        "solver_period": scenario.joint.solver_period,
        "tables": machine.tables,
        "motions": machine.motions,
        "units": {name: axis_unit(axis, unit) for name, unit in (("velocity", "rad/s"), ("torque", "N m"))},
        "torque": "force" if axis == "linear" else "torque",
    }


def commit() -> str:
    """Return the commit that the package is at; of one that is installed without its repository it is not known."""
    root, git = package_root(), shutil.which("git")
    if git is None or not (root / ".git").exists():
        return "commit not known"
    command = [git, "-C", str(root), "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return f"commit {done.stdout.strip()}" if done.returncode == 0 else "commit not known"


def page() -> str:
    """Return the page."""
    blob, runs, shown = Blob(), dict[str, tuple[Any, ...]](), machines()
    first = shown[0]
    content = {
        "machines": [_machine(machine, blob, runs) for machine in shown],
        "references": {
            name: {
                "place": blob.add(_reference(first.modified(name), first.peak)),
                "spans": _spans(first.modified(name)),
            }
            for name in first.motions
        },
        "steps": first.scenario.times().size,
        "fraction": FRACTION,
        "differences": DIFFERENCES,
        "least": LEAST_OF_MEDIAN,
        "shown": SHOWN,
    }
    module = webassembly(runs)
    packed = zlib.compress(b"".join([*blob.parts, module]), 9)
    content["module"] = [sum(map(len, blob.parts)), len(module)]
    environment = Environment(loader=PackageLoader("adaptive_ff.playground", "."), undefined=StrictUndefined)
    return environment.get_template("page.html").render(
        content=json.dumps(content, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c"),
        packed=base64.b64encode(packed).decode("ascii"),
        script=(Path(__file__).with_name("page.js")).read_text(encoding="utf-8"),
        least=LEAST_OF_MEDIAN,
        version=f"adaptive-ff {__version__}, {commit()}",
    )


def write_page(path: Path) -> None:
    """Write the page to a file."""
    text = page()
    with staged(path.parent, path) as stage:
        (stage / path.name).write_text(text, encoding="utf-8")
