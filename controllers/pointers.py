"""Pointers in compiled code: values in memory, and functions called by their address."""

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from controllers.memory_arrays import ArrayInMemory, packed_array

typed_intrinsic: Any = intrinsic  # numba's own types take its first argument for one of the caller's


@typed_intrinsic
def load(typing: Any, pointer: Any) -> Any:
    """Return what lies at a pointer."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return context.unpack_value(builder, signature.return_type, arguments[0])

    return pointer.dtype(pointer), generate


@typed_intrinsic
def store(typing: Any, pointer: Any, value: Any) -> Any:
    """Write a value to where a pointer points."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        context.pack_value(builder, signature.args[1], arguments[1], arguments[0])
        return context.get_dummy_value()

    return types.void(pointer, value), generate


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


@typed_intrinsic
def row_at(typing: Any, pointer: Any, count: Any) -> Any:
    """Return numbers at a pointer as an array, without a copy."""
    kind = ArrayInMemory(types.float64, 1, True)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return packed_array(context, builder, kind, *arguments)

    return kind(pointer, types.intp), generate
