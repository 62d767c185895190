"""The exported code in place of the compiled kernels, to try it in Python: the same torques."""

import copy
import re
from pathlib import Path
from typing import Any

from adaptive_ff.errors import InputError, library
from adaptive_ff.export.buffer import state_from_bytes, state_to_bytes
from adaptive_ff.export.errors import compiled
from adaptive_ff.export.export import Export
from adaptive_ff.export.source import header, source
from controllers import Controller, Output
from controllers.native import declined

PREFIX = "controller"


class InC:
    """A controller whose ``step`` runs as C; everything else is that of the controller it was made from.

    It gives the same torques, bit for bit on x86-64 with glibc. Its state lives in C between the steps; whatever else
    is asked of it first fetches that state, and what sets it hands it back. One is made by :func:`run_in_c`, which
    takes the controller over: it must not be stepped on its own any more.
    """

    def __init__(self, controller: Controller, ffi: Any, library: Path, single: bool) -> None:
        self.__dict__.update(  # not by setting attributes, which are the controller's
            _ffi=ffi,
            _library=ffi.dlopen(str(library)),
            _handle=ffi.new(f"{PREFIX}_Controller *"),
            _inputs=ffi.new(f"{PREFIX}_Inputs *"),
            _output=ffi.new(f"{PREFIX}_Output *"),
            _controller=controller,
            _buffer=ffi.new("unsigned char[]", len(state_to_bytes(controller, single=single))),
            _single=single,
            step=controller.step,
        )
        self._library.controller_init(self._handle)
        self.__dict__["_in_c"] = self._computing()
        self._step_in_c()

    def _computing(self) -> Any:
        handle, inputs, output = self._handle, self._inputs, self._output
        run = self._library.controller_step
        take = getattr(self._library, "controller_set_regressors", None)  # not there where the controller has none

        def compute(*given: float) -> float:
            inputs[0] = given
            if take is not None:
                take(handle, self._controller.regressors.tolist())
            run(handle, inputs, output)
            torque: float = output.torque
            return torque

        return compute

    def _step_in_c(self) -> None:
        """Let the controller step by C alone."""
        self._controller._fast, self._controller._run = declined, self._in_c

    def step_in_c(self, *inputs: float) -> Output:
        """Do one sample with inputs as they are, in the order of ``Inputs``; return torque and feedforward, N m."""
        return Output(self._in_c(*inputs), self._output.feedforward)

    def _fetch(self) -> None:
        """Give the controller in Python the state that C has."""
        self._library.controller_save_state(self._handle, self._buffer, len(self._buffer))
        held = getattr(self._controller, "regressors", None)
        written = None if held is None else held.copy()  # for the next step, C may not have taken them yet
        state_from_bytes(self._controller, bytes(self._ffi.buffer(self._buffer)), single=self._single)
        if written is not None:
            self._controller.regressors[:] = written

    def _hand_back(self) -> None:
        """Give C the state of the controller in Python."""
        content = state_to_bytes(self._controller, single=self._single)
        if self._library.controller_load_state(self._handle, content, len(content)):
            raise InputError("state is not allowed: it does not belong to this controller")

    def in_python(self) -> Controller:
        """Return a controller with the same settings and state that runs in Python, on its own."""
        self._fetch()
        own: Controller = copy.deepcopy(self._controller)
        return own

    def __getattr__(self, name: str) -> Any:
        self._fetch()
        found = getattr(self._controller, name)
        if not callable(found):
            return found

        def call(*arguments: Any, **named: Any) -> Any:
            self._fetch()
            own = self._controller
            own._run = own._plain_run  # a takeover tries a step, on the state in Python
            try:
                result = found(*arguments, **named)
            finally:
                self._step_in_c()
            self._hand_back()
            return result

        return call

    def __setattr__(self, name: str, value: Any) -> None:
        self._fetch()
        setattr(self._controller, name, value)
        self._hand_back()


def run_in_c(controller: Controller, *, single: bool = False) -> Any:
    """Return the controller with its step as C, compiled by the C compiler of this machine.

    It needs the package ``cffi`` and a C compiler (the variable CC, or ``cc``), and a second for that. Settings and
    state are those of the controller, which is copied.

    Parameters
    ----------
    controller : Controller
        Any controller whose step is a kernel.
    single : bool, optional
        Compute in single precision, to see what that would cost on a machine without double; other torques then.

    Returns
    -------
    InC
        To be used like the controller.

    Raises
    ------
    InputError
        The controller cannot be exported, or there is no ``cffi`` or no C compiler.
    """
    ffi = library("cffi").FFI()
    export = Export(controller, PREFIX, single)
    sources = {f"{PREFIX}.h": header(export), f"{PREFIX}.c": source(export)}
    ffi.cdef(declarations(sources[f"{PREFIX}.h"]))
    with compiled(sources, ["-fvisibility=default"]) as built:
        return InC(copy.deepcopy(controller), ffi, built, export.single)


def declarations(text: str) -> str:
    """Return a header as ``cffi`` reads it: without what the preprocessor takes."""
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    text = text.replace('extern "C" {', "").replace("#ifdef __cplusplus\n}\n#endif", "")
    return "\n".join(line for line in text.splitlines() if not line.startswith("#"))
