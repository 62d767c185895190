"""Arrays of parameters and states as compiled kernels see them: where they begin, and their shape.

Numba's own arrays are descriptors of seven words and more (owner, object, count, item size, data, shape, strides), and
kernels hand a controller's whole state to one another. They only read and write single elements: with a pointer and the
shape instead, compiling the adaptive controller takes a fifth less time (``python -m benchmarks.speed``).
"""

import operator
from typing import Any

import numba
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import AbstractTemplate, AttributeTemplate, infer_getattr, infer_global, signature
from numba.extending import lower_builtin, lower_getattr, models, register_model


class ArrayInMemory(types.Type):
    """A contiguous array of numbers that somebody else owns, with single elements and a shape.

    Parameters
    ----------
    dtype : numba type
        Type of its numbers.
    ndim : int
        Number of dimensions.
    mutable : bool
        Whether elements may be written.
    """

    def __init__(self, dtype: Any, ndim: int, mutable: bool) -> None:
        self.dtype, self.ndim, self.mutable = dtype, ndim, mutable
        super().__init__(f"ArrayInMemory({dtype}, {ndim}{'' if mutable else ', read only'})")


def type_in_memory(value: Any) -> Any:
    """Return the type in compiled code of a nested named tuple, or a part of one, that lies in memory.

    Raises
    ------
    ValueError
        An array is not contiguous in the order of C.
    """
    typeof: Any = numba.typeof
    if isinstance(value, tuple):
        return types.BaseTuple.from_types(tuple(map(type_in_memory, value)), type(value))
    kind = typeof(value)
    if not isinstance(kind, types.Array):
        return kind
    if kind.layout != "C" or not kind.aligned:
        raise ValueError(f"array of shape {value.shape} is not allowed: it must be contiguous and aligned")
    return ArrayInMemory(kind.dtype, kind.ndim, kind.mutable)


@register_model(ArrayInMemory)
class _Model(models.StructModel):
    def __init__(self, manager: Any, kind: Any) -> None:
        pointer: Any = types.CPointer
        sizes = [(f"size{axis}", types.intp) for axis in range(kind.ndim)]
        super().__init__(manager, kind, [("data", pointer(kind.dtype)), *sizes])


def packed_array(context: Any, builder: Any, kind: ArrayInMemory, data: Any, *shape: Any) -> Any:
    """Return an array that begins at a pointer, from generated code."""
    array = cgutils.create_struct_proxy(kind)(context, builder)
    array.data = data
    for axis, size in enumerate(shape):
        setattr(array, f"size{axis}", size)
    return array._getvalue()


def _shape(context: Any, builder: Any, kind: Any, value: Any) -> list[Any]:
    array = cgutils.create_struct_proxy(kind)(context, builder, value)
    return [getattr(array, f"size{axis}") for axis in range(kind.ndim)]


@infer_getattr
class _Attributes(AttributeTemplate):
    key = ArrayInMemory

    def resolve_size(self, kind: Any) -> Any:
        return types.intp

    def resolve_shape(self, kind: Any) -> Any:
        return types.UniTuple(types.intp, kind.ndim)


@lower_getattr(ArrayInMemory, "size")
def _size(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    first, *others = _shape(context, builder, kind, value)
    for size in others:
        first = builder.mul(first, size)
    return first


@lower_getattr(ArrayInMemory, "shape")
def _shape_as_tuple(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    return context.make_tuple(builder, types.UniTuple(types.intp, kind.ndim), _shape(context, builder, kind, value))


def _index(kind: Any, index: Any) -> Any:
    """Return the type that an index is converted to; none where the array has no such elements or rows."""
    if isinstance(index, types.Integer):
        return types.intp
    parts: Any = index
    integers = isinstance(index, types.BaseTuple) and all(isinstance(each, types.Integer) for each in parts)
    return types.UniTuple(types.intp, len(index)) if integers and 0 < len(index) <= kind.ndim else None


def _left(kind: Any, place: Any) -> int:
    """Return the number of dimensions that an index leaves."""
    return int(kind.ndim) - (len(place) if isinstance(place, types.BaseTuple) else 1)


@infer_global(operator.getitem)
class _GetItem(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        kind, index = args
        place = _index(kind, index) if isinstance(kind, ArrayInMemory) else None
        if place is None:
            return None
        left = _left(kind, place)
        return signature(ArrayInMemory(kind.dtype, left, kind.mutable) if left else kind.dtype, kind, place)


@infer_global(operator.setitem)
class _SetItem(AbstractTemplate):
    def generic(self, args: Any, kws: Any) -> Any:
        kind, index, _ = args
        place = _index(kind, index) if isinstance(kind, ArrayInMemory) else None
        if place is None or _left(kind, place) or not kind.mutable:
            return None
        return signature(types.none, kind, place, kind.dtype)


def _first(context: Any, builder: Any, kind: Any, value: Any, place: Any, index: Any) -> Any:
    """Return the pointer to the first element at an index; negative ones count from the end, as numpy's do."""
    indices = cgutils.unpack_tuple(builder, index) if isinstance(place, types.BaseTuple) else [index]
    shape, zero = _shape(context, builder, kind, value), context.get_constant(types.intp, 0)
    count = zero
    for axis, size in enumerate(shape):
        count = builder.mul(count, size) if axis else count
        if axis < len(indices):
            each = indices[axis]
            turned = builder.select(builder.icmp_signed("<", each, zero), builder.add(each, size), each)
            count = builder.add(count, turned) if axis else turned
    array = cgutils.create_struct_proxy(kind)(context, builder, value)
    return builder.gep(array.data, [count])


def _get(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    kind, place = sig.args
    first = _first(context, builder, kind, args[0], place, args[1])
    if not isinstance(sig.return_type, ArrayInMemory):
        return context.unpack_value(builder, kind.dtype, first)
    shape = _shape(context, builder, kind, args[0])[-sig.return_type.ndim :]
    return packed_array(context, builder, sig.return_type, first, *shape)


def _set(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    kind, place, dtype = sig.args
    context.pack_value(builder, dtype, args[2], _first(context, builder, kind, args[0], place, args[1]))
    return context.get_dummy_value()


for _place in (types.Integer, types.BaseTuple):
    lower_builtin(operator.getitem, ArrayInMemory, _place)(_get)
    lower_builtin(operator.setitem, ArrayInMemory, _place, types.Any)(_set)
