"""Controllers as machine code: a step at an address, parameters and state in memory.

The kernels of a controller are compiled once for its types, as functions that C could call. A single step from Python,
the closed loop and a group of joints call them by address: nothing of these is compiled anew for another controller,
and none hands over the hundred numbers of its state. Only the shortest steps, those of ``INLINED``, are part of a loop.
"""

import math
from collections import ChainMap
from collections.abc import Callable, Hashable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numba import types
from numba.extending import register_jitable

from controllers.arrays import MutableArray, NDArray
from controllers.compiled import compiled
from controllers.kernel_language.dispatch import DISPATCHED
from controllers.kernel_language.kinds import INTEGER, REAL, kind_of, pointer_to
from controllers.kernel_language.machine_code import address_of
from controllers.kernels import (
    ESTIMATES,
    MONITORS,
    STEPS,
    Inputs,
    Output,
    step,
    without_estimates,
    write_estimates,
    write_monitors,
)
from controllers.memory_layout import Memory, structure
from controllers.pointers import call, load, row_at, store

TORQUE = len(Inputs._fields)
"""Place of the torque in what is exchanged at a step, behind the inputs; the feedforward follows."""

ACTING = Inputs._fields.index("acting_reference")
"""Place of the plan over the period in which the torque acts; the last of the inputs, as few controllers need it."""


def _step_once(parameters: Any, state: Any, row: Any, count: int) -> None:
    inputs = Inputs(
        reference=row[0],
        velocity=row[1],
        next_reference=row[2],
        correction=row[3],
        position=row[4],
        realised_torque=row[5],
        feedforward=row[6],
        inertia=row[7],
        dt=row[8],
        acting_reference=row[9],
        next_acting_reference=row[10],
    )
    row[ACTING], row[ACTING + 1] = math.nan, math.nan  # known for one sample, to whoever does not write them anew
    output, new = step(load(parameters), load(state), inputs)
    store(state, new)
    row[TORQUE] = output.torque
    row[TORQUE + 1] = output.feedforward


def _write_estimates_once(parameters: Any, state: Any, row: Any, count: int) -> None:
    write_estimates(load(parameters), load(state), row_at(row, count))


def _write_monitors_once(parameters: Any, state: Any, row: Any, count: int) -> None:
    write_monitors(load(parameters), load(state), row_at(row, count))


def _address(function: Callable[..., None], parameters: Any, state: Any) -> int:
    """Return where the machine code of a function lies that is compiled, or loaded, for a controller."""
    return address_of(function, (kind_of(parameters), kind_of(state), pointer_to(REAL), INTEGER))


_KNOWN: dict[Hashable, tuple[int, int, int]] = {}
"""Addresses of the kernels by the structure of parameters and state: numba's own types are slow to make and compare."""


def _addresses(parameters: Any, state: Any, *structures: Hashable) -> tuple[int, int, int]:
    """Return where the kernels of a controller lie; zero for what it does not have."""
    kind = type(parameters)
    kernels = ESTIMATES[kind], MONITORS.get(kind)
    key = (*structures, *kernels)
    if key not in _KNOWN:
        _KNOWN[key] = (
            _address(_step_once, parameters, state),
            0 if kernels[0] is without_estimates else _address(_write_estimates_once, parameters, state),
            0 if kernels[1] is without_estimates else _address(_write_monitors_once, parameters, state),
        )
    return _KNOWN[key]


class NativeParameters(NamedTuple):
    """Parameters of a controller in memory, for compiled code that serves every controller.

    Attributes
    ----------
    step, estimates, monitors : int
        Addresses of its kernels; zero where it has none.
    parameters, state : int
        Addresses of its parameters and its state.
    exchange : ndarray, shape (13,)
        Inputs and output of a step.
    """

    step: int
    estimates: int
    monitors: int
    parameters: int
    state: int
    exchange: MutableArray


@register_jitable
def step_in_memory(address: int, parameters: int, state: int, row: NDArray[np.float64]) -> None:
    """Do one sample of a controller in memory; the row holds the inputs and is given torque and feedforward, N m."""
    call(address, parameters, state, row.ctypes.data, row.size)


@register_jitable
def step_native(block: NativeParameters, state: int, inputs: Inputs) -> tuple[Output, int]:
    """Do one sample of a controller in memory; the state that is handed through is that of no one."""
    row = block.exchange
    row[0], row[1], row[2] = inputs.reference, inputs.velocity, inputs.next_reference
    row[3], row[4], row[5] = inputs.correction, inputs.position, inputs.realised_torque
    row[6], row[7], row[8] = inputs.feedforward, inputs.inertia, inputs.dt
    row[9], row[10] = inputs.acting_reference, inputs.next_acting_reference
    step_in_memory(block.step, block.parameters, block.state, row)
    return Output(row[TORQUE], row[TORQUE + 1]), state


@register_jitable
def write_native_estimates(block: NativeParameters, state: int, row: NDArray[np.float64]) -> None:
    """Write the physical estimates of a controller in memory into a row."""
    if block.estimates != 0:
        call(block.estimates, block.parameters, block.state, row.ctypes.data, row.size)


@register_jitable
def write_native_monitors(block: NativeParameters, state: int, row: NDArray[np.float64]) -> None:
    """Write what a controller in memory watches itself by into a row."""
    if block.monitors != 0:
        call(block.monitors, block.parameters, block.state, row.ctypes.data, row.size)


# beside the registries, which list the controllers that there are
DISPATCHED[step] = ChainMap(STEPS, {NativeParameters: step_native})
DISPATCHED[write_estimates] = ChainMap(ESTIMATES, {NativeParameters: write_native_estimates})
MONITORS[NativeParameters] = write_native_monitors  # which has a kernel for every class, one that writes nothing


def _step_at(
    address: int,
    parameters: int,
    state: int,
    exchange: NDArray[np.float64],
    reference: float,
    velocity: float,
    next_reference: float,
    correction: float,
    position: float,
    realised_torque: float,
    feedforward: float,
    inertia: float,
    dt: float,
) -> float:
    """Do one sample of a controller in memory; what is not known is not a number, as in :class:`controllers.Inputs`.

    The plan over the period in which the torque acts is taken from what is exchanged, where it may have been written.

    Parameters
    ----------
    address, parameters, state : int
        Addresses of the step's machine code, and of the controller's parameters and state.
    exchange : ndarray, shape (13,)
        Takes inputs and output of the step.
    reference, velocity, next_reference, correction : float
        Planned and measured velocity, the plan at the next sample, and what an outer loop adds to it, rad/s.
    position : float
        Measured position, rad.
    realised_torque, feedforward : float
        Mean torque of the drive over the last period, and torque known from elsewhere, N m.
    inertia : float
        Inertia of the present configuration, kg m^2.
    dt : float
        Time since the last sample, s.

    Returns
    -------
    float
        The commanded torque, N m.
    """
    exchange[0], exchange[1], exchange[2] = reference, velocity, next_reference
    exchange[3], exchange[4], exchange[5] = correction, position, realised_torque
    exchange[6], exchange[7], exchange[8] = feedforward, inertia, dt
    step_in_memory(address, parameters, state, exchange)
    torque: float = exchange[TORQUE]
    return torque


@cache
def step_at() -> Callable[..., float]:
    """Return :func:`_step_at` compiled, as what takes any numbers and makes floats of them, texts of digits included.

    It is numba's wrapper for these types alone: to be asked for the types of thirteen arguments first takes as long as
    the rest of a call.
    """
    signature = types.float64(*[types.intp] * 3, types.float64[::1], *[types.float64] * ACTING)
    entry: Any = compiled(_step_at, allocates=False)
    entry.compile(signature)
    return entry.get_overload(signature)  # type: ignore[no-any-return]


def empty_exchange() -> MutableArray:
    """Return room for inputs and output of a step."""
    return np.full(TORQUE + len(Output._fields), math.nan)


class Native:
    """A controller's parameters and state in memory, and the machine code of its kernels.

    Parameters
    ----------
    parameters, state : NamedTuple
        Parameters and state of a controller whose class is registered; the arrays in the state are shared.
    exchange : ndarray, shape (13,), optional
        Takes inputs and output of a step.

    Attributes
    ----------
    block : NativeParameters
        What stands for the parameters in compiled code that serves every controller.
    """

    def __init__(self, parameters: Any, state: Any, exchange: MutableArray | None = None) -> None:
        structures = structure(parameters), structure(state)
        self._parameters, self._state = Memory(parameters, structures[0]), Memory(state, structures[1])
        self.block = NativeParameters(
            *_addresses(parameters, state, *structures),
            self._parameters.address,
            self._state.address,
            empty_exchange() if exchange is None else exchange,
        )

    @property
    def state(self) -> Any:
        """The state now; its arrays are those that compiled code changes."""
        return self._state.value

    @state.setter
    def state(self, value: Any) -> None:
        self._state.value = value
