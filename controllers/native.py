"""Controllers in memory: a compiled step at an address, parameters and state as structs of C.

The kernels of a controller are compiled once for its types, as functions of C. A single step from Python, the closed
loop and a group of joints call them by address: nothing of these is compiled anew for another controller, and none
hands over the hundred numbers of its state.
"""

import ctypes
import math
from collections import ChainMap
from collections.abc import Callable, Hashable, Sequence
from typing import Any, NamedTuple

import numpy as np

from controllers.arrays import MutableArray, NDArray
from controllers.kernels.entry import controller_text, symbol_of
from controllers.kernels.language import BY_ADDRESS, DISPATCHED, call
from controllers.kernels.library import loaded, stepper
from controllers.kernels.memory import Memory, structure
from controllers.kernels.types import type_of
from controllers.registry import (
    ESTIMATES,
    MONITORS,
    PREVIEW,
    RULES,
    STEPS,
    UNKNOWN,
    Inputs,
    Output,
    step,
    without_estimates,
    write_estimates,
)

TORQUE = len(Inputs._fields)
"""Place of the torque in what is exchanged at a step, behind the inputs; the feedforward follows."""

INPUTS = type_of(Inputs(*[0.0] * TORQUE))
"""Type of the inputs."""

_KNOWN: dict[Hashable, tuple[int, int, int]] = {}
"""Addresses of the kernels by the structure of parameters and state."""


def _addresses(parameters: Any, state: Any, *structures: Hashable) -> tuple[int, int, int]:
    """Return where the kernels of a controller lie; zero for what it does not have."""
    kind = type(parameters)
    both = ESTIMATES[kind], MONITORS.get(kind)
    estimates, monitors = (None if kernel is without_estimates else kernel for kernel in both)
    kernels = STEPS[kind], estimates, monitors
    key = (*structures, *kernels)
    if key not in _KNOWN:
        kinds = type_of(parameters, "parameters"), type_of(state, "state"), INPUTS
        symbol = symbol_of([kernel for kernel in kernels if kernel is not None], kinds)

        def write(unit: Any) -> tuple[str, None]:
            return controller_text(unit, kernels, kinds, symbol, TORQUE), None

        library = loaded((*kernels, *kinds), symbol, write)
        places = [library.address(f"{symbol}_{name}") for name in ("step", "estimates", "monitors")]
        _KNOWN[key] = places[0], places[1], places[2]
    return _KNOWN[key]


class NativeParameters(NamedTuple):
    """Parameters of a controller in memory, for compiled code that serves every controller."""

    step: int  # addresses of its kernels; zero where it has none
    estimates: int
    monitors: int
    parameters: int  # addresses of its parameters and its state
    state: int
    exchange: MutableArray  # inputs and output of a step, 13 numbers


def step_native(native: NativeParameters, state: int, inputs: Inputs) -> tuple[Output, int]:
    """Do one sample of a controller in memory; the state that is handed through is that of no one."""
    row = native.exchange
    row[0], row[1], row[2] = inputs.reference, inputs.velocity, inputs.next_reference
    row[3], row[4], row[5] = inputs.correction, inputs.position, inputs.realised_torque
    row[6], row[7], row[8] = inputs.feedforward, inputs.inertia, inputs.dt
    row[9], row[10] = inputs.acting_reference, inputs.next_acting_reference
    call(native.step, native.parameters, native.state, row)
    return Output(row[TORQUE], row[TORQUE + 1]), state


def write_native_estimates(native: NativeParameters, state: int, row: NDArray[np.float64]) -> None:
    """Write the physical estimates of a controller in memory into a row."""
    if native.estimates != 0:
        call(native.estimates, native.parameters, native.state, row)


def write_native_monitors(native: NativeParameters, state: int, row: NDArray[np.float64]) -> None:
    """Write what a controller in memory watches itself by into a row."""
    if native.monitors != 0:
        call(native.monitors, native.parameters, native.state, row)


# beside the registries, which list the controllers that there are
DISPATCHED[step] = ChainMap(STEPS, {NativeParameters: step_native})
DISPATCHED[write_estimates] = ChainMap(ESTIMATES, {NativeParameters: write_native_estimates})
MONITORS[NativeParameters] = write_native_monitors


def bound_step(native: NativeParameters) -> Callable[..., float]:
    """Return a function that does one sample: all inputs in, the torque out, N m."""
    function, exchange = BY_ADDRESS(native.step), native.exchange
    place = exchange.ctypes.data

    def do_step(*inputs: float) -> float:
        exchange[:TORQUE] = inputs
        function(native.parameters, native.state, place, exchange.size)
        torque: float = exchange.item(TORQUE)
        return torque

    return do_step


def fast_step(
    natives: Sequence[NativeParameters], rows: MutableArray, period: float, *, together: bool
) -> Callable[..., Any]:
    """Return a function that checks what a step is given and does it, in one call; None where that needs words."""
    fast = stepper()
    if fast is None:
        return declined
    members = tuple((native.step, native.parameters, native.state) for native in natives)
    rules = "".join(RULES.values())
    rules = rules.replace(PREVIEW, UNKNOWN) if together else rules  # one joint of several may have none
    bound: Callable[..., Any] = fast.bind(members, rows.ctypes.data, rows.shape[-1], rules, period, together)
    return bound


def declined(*given: Any) -> None:
    """Do nothing, where there is no fast step."""


class CalledBack:
    """A controller in Python whose step the compiled loop calls back, once a sample.

    An error in it cannot pass through compiled code: it is kept, the torque is zero from then on, and whoever runs the
    loop raises it behind it by :meth:`check`, with its own traceback.

    Parameters
    ----------
    step : callable
        ``step(inputs) -> (torque, feedforward)``, of a list in the order of :class:`Inputs`.
    write_estimates : callable, optional
        Writes the estimates into a row, where it has any.
    """

    def __init__(
        self, step: Callable[[list[float]], tuple[float, float]], write_estimates: Callable[[Any], None] | None
    ) -> None:
        self._step, self._write = step, write_estimates
        self._error: BaseException | None = None
        exchange = empty_exchange()
        self._row: Any = exchange.data  # numbers of Python's go in and out of it in half of numpy's time
        self._functions = BY_ADDRESS(self._do_step), BY_ADDRESS(self._do_write)  # compiled code may call them
        places = [int(ctypes.cast(function, ctypes.c_void_p).value or 0) for function in self._functions]
        estimates = 0 if write_estimates is None else places[1]
        # what stands for the parameters in compiled code
        self.addresses = NativeParameters(places[0], estimates, 0, 0, 0, exchange)

    def _do_step(self, parameters: int, state: int, row: int, count: int) -> None:
        del parameters, state, row, count  # the step's own are in Python, and the row is what is exchanged
        output = 0.0, 0.0
        if self._error is None:
            try:
                output = self._step(self._row[:TORQUE].tolist())
            except BaseException as error:
                self._error = error
        self._row[TORQUE], self._row[TORQUE + 1] = output

    def _do_write(self, parameters: int, state: int, row: int, count: int) -> None:
        del parameters, state
        if self._error is None and self._write is not None:
            try:
                self._write(np.ctypeslib.as_array((ctypes.c_double * count).from_address(row)))
            except BaseException as error:
                self._error = error

    def check(self) -> None:
        """Raise the error that the controller has raised in the loop, if any."""
        if self._error is not None:
            raise self._error


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
    """

    def __init__(self, parameters: Any, state: Any, exchange: MutableArray | None = None) -> None:
        structures = structure(parameters), structure(state)
        self._parameters, self._state = Memory(parameters, structures[0]), Memory(state, structures[1])
        self.addresses = NativeParameters(  # for compiled code that serves every controller
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
