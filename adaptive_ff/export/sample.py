"""What an export needs to know of a controller beside its types: switches, start state, a recorded run."""

import copy
import inspect
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.export.buffer import layout
from adaptive_ff.export.errors import NotExportable
from controllers import ESTIMATES, STEPS, Controller, Inputs
from controllers.kernels.memory import Leaf, rebuilt, value_at
from controllers.kernels.text import described
from controllers.kernels.types import BOOLEAN

SAMPLES = 200
"""Length of the recorded run."""


@dataclass(frozen=True)
class Switch:
    """A property of a controller that is set at run time, such as whether it learns."""

    name: str  # name of the property
    doc: str  # what it does
    leaves: tuple[Leaf, ...]  # truth values of the state that it sets


@dataclass(frozen=True)
class Recording:
    """A run of the controller in Python."""

    inputs: NDArray[np.float64]  # inputs of each sample
    outputs: NDArray[np.float64]  # outputs


def check_exportable(controller: Any, single: bool) -> None:
    """Raise ``NotExportable`` for what is no controller with kernels, or not in single precision."""
    known = [cls.__name__.removesuffix("Parameters") for cls in STEPS if cls.__name__.endswith("Parameters")]
    name = type(controller).__name__
    if not isinstance(controller, Controller) or type(controller.parameters) not in STEPS:
        raise NotExportable(f"controller = {name} cannot be exported: it has no kernel; there are {', '.join(known)}")
    if controller.estimate_names and type(controller.parameters) not in ESTIMATES:
        raise NotExportable(f"controller = {name} cannot be exported: no kernel gives its estimates")
    if single and controller.needs_double:
        raise NotExportable(f"controller = {name} cannot be exported in single precision: {controller.needs_double}")


def optional_inputs() -> tuple[str, ...]:
    """Return the inputs that may be unknown, then not a number: those that ``step`` may be called without."""
    arguments = inspect.signature(Controller.step).parameters
    return tuple(name for name in Inputs._fields if arguments[name].default is None and name != "dt")


def unchecked_inputs() -> tuple[str, ...]:
    """Return the inputs that may be any number: the optional ones, and the measurement, which may fail."""
    texts = described(Inputs)
    return (*optional_inputs(), *(name for name in Inputs._fields if "not finite where" in texts[name]))


def switches(controller: Controller) -> list[Switch]:
    """Return the properties of a controller that set nothing but truth values of its state."""
    found = []
    for name, item in inspect.getmembers(type(controller), lambda member: isinstance(member, property)):
        if item.fset is None or not isinstance(getattr(controller, name), bool):
            continue
        states = []
        for value in (True, False):
            changed = copy.deepcopy(controller)
            setattr(changed, name, value)
            states.append(changed.state)
        on, off = states
        pairs = ((leaf, value_at(on, leaf.path), value_at(off, leaf.path)) for leaf in layout(controller))
        differ = [leaf for leaf, first, second in pairs if not np.array_equal(first, second, equal_nan=True)]
        plain = all(leaf.kind == BOOLEAN and not leaf.is_array and value_at(on, leaf.path) for leaf in differ)
        if not differ or not plain:
            owner = type(controller).__name__
            raise NotExportable(f"{owner}.{name} cannot be exported: it sets more than truth values")
        found.append(Switch(name, (inspect.getdoc(item) or "").partition("\n")[0], tuple(differ)))
    return found


def restarted(controller: Controller) -> list[tuple[Leaf, Any]]:
    """Return what ``restart`` sets in the state, and to which value; of an array, all numbers to zero.

    The state is marked in two ways, and what keeps neither mark has been set.
    """
    found, pairs = layout(controller), []
    for marks in ({"real": 0.125, "integer": 3, "boolean": True}, {"real": 0.375, "integer": 5, "boolean": False}):
        marked = copy.deepcopy(controller).run_uncompiled()
        values = [np.full(leaf.shape, marks[leaf.kind.kind]) for leaf in found]
        numbers = (value if leaf.is_array else value.item() for leaf, value in zip(found, values, strict=True))
        marked.state = rebuilt(controller.state, numbers)
        marked.restart()
        after = [np.asarray(value_at(marked.state, leaf.path)) for leaf in found]
        pairs.append(list(zip(values, after, strict=True)))
    changed = []
    for leaf, (old, new), (older, newer) in zip(found, *pairs, strict=True):
        if np.array_equal(old, new) and np.array_equal(older, newer):
            continue
        if not np.array_equal(new, newer) or (leaf.is_array and np.any(new)):
            raise NotExportable(f"{type(controller).__name__}.restart cannot be exported: state.{leaf.member} varies")
        changed.append((leaf, 0.0 if leaf.is_array else new.item()))
    return changed


def regressor_leaf(controller: Controller) -> Leaf | None:
    """Return where a controller holds its further known regressors; None for one that takes none."""
    held = getattr(controller, "regressors", None)
    if held is None:
        return None
    found = (leaf for leaf in layout(controller) if leaf.is_array and leaf.count)
    return next((leaf for leaf in found if np.shares_memory(value_at(controller.state, leaf.path), held)), None)


def record(controller: Controller, samples: int = SAMPLES) -> Recording:
    """Run a copy of a controller in plain Python along a made-up motion.

    The measurement trails the reference and stumbles where that reverses; some are lost, some previews and torques are
    not known, the period varies: a sample of all that the code must bear, not a judgement of the controller.
    """
    own = copy.deepcopy(controller).run_uncompiled()
    held = {leaf: value_at(own.state, leaf.path) for leaf in layout(own) if leaf.is_array}
    inputs = made_up_inputs(own.period, samples)
    outputs = [list(own.step_plain(Inputs(*row))) for row in inputs.tolist()]
    for leaf, array in held.items():
        if value_at(own.state, leaf.path) is not array:
            raise NotExportable(f"state.{leaf.member} is replaced by another array in a step; change it in place")
    return Recording(inputs, np.array(outputs, dtype=float))


def made_up_inputs(period: float, samples: int, seed: int = 101) -> NDArray[np.float64]:
    """Return inputs of so many samples, shape (samples, fields of the inputs)."""
    generator = np.random.default_rng(seed)
    columns = {name: np.zeros(samples) for name in Inputs._fields}
    lengths = period * (1.0 + 0.1 * generator.uniform(-1.0, 1.0, samples))
    time = np.cumsum(lengths)
    speed = 0.2 * np.sin(2.0 * math.pi * time / (40.0 * period)) + 0.1 * np.sin(2.0 * math.pi * time / (93.0 * period))
    columns["reference"] = speed
    columns["velocity"] = 0.97 * np.roll(speed, 1) - 0.02 * np.tanh(20.0 * speed)
    columns["velocity"] += 0.001 * generator.standard_normal(samples)
    columns["next_reference"] = np.roll(speed, -1)
    columns["realised_torque"] = 60.0 * np.tanh(20.0 * speed) + 100.0 * np.gradient(speed)
    columns["feedforward"] = 0.5 * np.sin(time / (17.0 * period))
    columns["dt"] = lengths
    columns["correction"] = 0.005 * np.sin(time / (11.0 * period))
    columns["position"] = np.cumsum(speed * lengths)
    columns["inertia"] = 20.0 + 2.0 * np.sin(time / (29.0 * period))
    columns["acting_reference"], columns["next_acting_reference"] = np.roll(speed, -2), np.roll(speed, -3)
    for name in optional_inputs():
        columns[name] = np.where(generator.uniform(size=samples) < 0.1, math.nan, columns[name])
    lost = generator.uniform(size=samples) < 0.03
    broken = generator.choice([math.nan, math.inf, -math.inf], samples)
    columns["velocity"] = np.where(lost, broken, columns["velocity"])
    return np.column_stack([columns[name] for name in Inputs._fields])
