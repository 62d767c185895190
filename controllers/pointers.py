"""Pointers in compiled code: values in memory, and functions called by their address."""

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

typed_intrinsic: Any = intrinsic  # numba's own types take its first argument for one of the caller's


@typed_intrinsic
def call(typing: Any, address: Any, parameters: Any, state: Any, numbers: Any, count: Any) -> Any:
    """Call a function of C by its address: ``void f(parameters, state, numbers, count)``."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        byte = ir.IntType(8).as_pointer()
        word = arguments[4].type
        kind = ir.FunctionType(ir.VoidType(), [byte, byte, byte, word])
        pointers = [builder.inttoptr(argument, byte) for argument in arguments[1:4]]
        builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), [*pointers, arguments[4]])
        return context.get_dummy_value()

    return types.void(types.intp, types.intp, types.intp, types.intp, types.intp), generate


def load(address: Any) -> Any:
    """Return what lies at an address; in kernels alone."""
    raise NotImplementedError("only a translated kernel has addresses")


def store(address: Any, value: Any) -> None:
    """Write a value to an address; in kernels alone."""
    raise NotImplementedError("only a translated kernel has addresses")


def row_at(address: Any, count: int) -> Any:
    """Return numbers at an address as an array; in kernels alone."""
    raise NotImplementedError("only a translated kernel has addresses")
