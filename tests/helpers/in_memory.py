"""Functions compiled for what lies in memory, as the kernels of a controller are."""

from controllers.compiled import compiled_in_place
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

    body = compiled_in_place(function)

    def entry(address, *others):
        return body(at(address), *others)

    return compiled_in_place(entry)(Memory(value).address, *arguments)
