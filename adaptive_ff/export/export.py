"""A controller prepared for export: its kernels translated, its numbers listed."""

import copy
import keyword
import re
from collections.abc import Iterable
from typing import Any

from adaptive_ff.errors import check_kind
from adaptive_ff.export.buffer import layout_hash, payload, state_to_bytes
from adaptive_ff.export.errors import NotExportable, exporting
from adaptive_ff.export.sample import check_exportable, regressor_leaf, restarted, switches
from controllers import ESTIMATES, STEPS, Controller, Inputs, Output
from controllers.checks import checked_switch
from controllers.kernels.memory import Leaf, leaves
from controllers.kernels.text import DOUBLE, FILES, RESERVED, SINGLE
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


def arrays_of(found: Iterable[Leaf]) -> list[Leaf]:
    """Return the arrays that hold numbers."""
    return [leaf for leaf in found if leaf.is_array and leaf.count]


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
        self.fresh = copy.deepcopy(controller)
        self.fresh.reset()
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
        self.regressor_count = 0 if self.regressors is None else self.regressors.count
        self.restarted = restarted(controller)
        self.state_leaves = list(leaves(self.state))
        self.parameter_arrays, self.state_arrays = arrays_of(leaves(self.parameters)), arrays_of(self.state_leaves)
        self.has_own_start = state_to_bytes(controller) != state_to_bytes(self.fresh)
        self.hash, self.payload_size = layout_hash(controller, single), payload(controller, single).size

    @property
    def input_names(self) -> tuple[str, ...]:
        """Names of the inputs."""
        return tuple(name for name, _ in self.inputs.fields)
