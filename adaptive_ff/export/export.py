"""A controller prepared for export: its kernels translated, its numbers listed."""

import keyword
import re
from functools import cached_property
from typing import Any

from adaptive_ff.errors import check_kind
from adaptive_ff.export.buffer import layout_hash, payload
from adaptive_ff.export.errors import NotExportable, exporting
from adaptive_ff.export.sample import Recording, check_exportable, new_one, record, regressor_leaf, restarted, switches
from controllers import ESTIMATES, STEPS, Controller, Inputs, Output
from controllers.checks import checked_switch
from controllers.kernels.literals import DOUBLE, FILES, RESERVED, SINGLE
from controllers.kernels.memory import leaves
from controllers.kernels.tree import Function
from controllers.kernels.types import REAL, Array, Record, type_of
from controllers.kernels.unit import Unit


def as_record(value: Any, where: str) -> Record:
    """Return the type of a named tuple."""
    # parameters are constant, so that they may decide branches
    with exporting():
        kind = type_of(value, where, sizes=True, values=where == "parameters")
    if not isinstance(kind, Record):
        raise NotExportable(f"{where} cannot be exported: it must be a NamedTuple")
    return kind


class Export:
    """What all files of an export are written from."""

    def __init__(self, controller: Controller, prefix: str, single: bool = False) -> None:
        single = checked_switch("single", single)
        check_exportable(controller, single)
        check_kind("prefix", prefix, str, "a text")
        word = re.fullmatch(r"[a-z][a-z0-9_]{0,30}", prefix)
        if not word or keyword.iskeyword(prefix) or prefix in RESERVED:
            raise NotExportable(
                f"prefix = {prefix!r} is not allowed: it must be a C name of at most 31 lower-case letters, digits, _ "
                "that begins with a letter and is no word of C or Python"
            )
        if prefix in FILES:
            raise NotExportable(f"prefix = {prefix!r} is not allowed: {prefix}.c or {prefix}.h is another file already")
        self.controller = controller
        self.prefix = prefix
        self.single = single
        self.precision = SINGLE if single else DOUBLE
        self.fresh = new_one(controller)
        self.unit = Unit(self.precision, prefix, fixed=True)
        self.parameters = as_record(controller.parameters, "parameters")
        self.state = as_record(controller.state, "state")
        self.inputs = as_record(Inputs(*[0.0] * len(Inputs._fields)), "inputs")
        self.output = as_record(Output(*[0.0] * len(Output._fields)), "output")
        for kind in (self.state, self.inputs, self.output):
            self.unit.struct(kind)
        self.public_structs = list(self.unit.structs.values())
        self.unit.struct(self.parameters)
        kernel = STEPS[type(controller.parameters)]
        self.write_estimates: Function | None = None
        with exporting():
            self.step: Function = self.unit.function(kernel, (self.parameters, self.state, self.inputs))
            if controller.estimate_names:
                row = Array(REAL, (len(controller.estimate_names),))
                writes = ESTIMATES[type(controller.parameters)]
                self.write_estimates = self.unit.function(writes, (self.parameters, self.state, row))
        self.switches = switches(controller)
        self.regressors = regressor_leaf(controller)
        self.restarted = restarted(controller)
        self.parameter_leaves, self.state_leaves = list(leaves(self.parameters)), list(leaves(self.state))
        self.hash, self.payload_size = layout_hash(controller, single), payload(controller, single).size

    @cached_property
    def recording(self) -> Recording:
        """A run of the controller in Python from the state that it starts in."""
        return record(self.controller)

    @property
    def input_names(self) -> tuple[str, ...]:
        """Names of the inputs."""
        return tuple(name for name, _ in self.inputs.fields)

    @property
    def title(self) -> str:
        """First line of the controller's docstring."""
        return (type(self.controller).__doc__ or type(self.controller).__name__).strip().partition("\n")[0]
