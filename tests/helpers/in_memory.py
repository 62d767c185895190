"""Functions compiled for what lies in memory, as the kernels of a controller are."""

import numba

from controllers.kernel_compiler import EntryCompiler
from controllers.memory_arrays import type_in_memory
from controllers.memory_layout import Memory
from controllers.pointers import typed_intrinsic


def run_in_memory(function, value, *arguments):
    """Return what a compiled function makes of a nested named tuple that lies in memory."""
    kind = type_in_memory(value)

    @typed_intrinsic
    def at(typing, address):
        """What lies at an address."""

        def generate(context, builder, signature, arguments):
            pointer = builder.inttoptr(arguments[0], context.get_data_type(kind).as_pointer())
            return context.unpack_value(builder, kind, pointer)

        return kind(address), generate

    uncached = numba.njit(error_model="numpy", _nrt=False, pipeline_class=EntryCompiler)
    body = uncached(function)

    def entry(address, *others):
        return body(at(address), *others)

    return uncached(entry)(Memory(value).address, *arguments)
