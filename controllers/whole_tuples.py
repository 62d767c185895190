"""Named tuples of the packages as compiled kernels see them: one value each, wherever they go.

Numba takes a tuple apart to hand it to a function, and takes it apart and puts it together again to return it or to
keep it in memory: a controller's state of two hundred numbers costs as many instructions, to be made and then removed
again, at each call. Here parameters and states of the packages are handed over, returned and kept as they are.
"""

from typing import Any

from numba import types
from numba.core.datamodel import models
from numba.extending import register_model

from controllers.kernel_sources import KERNEL_PACKAGES


class _Whole:
    """A data model with one representation: as a value, as an argument, as a result and in memory."""

    get_value_type: Any

    def get_data_type(self) -> Any:
        """Return the type of all representations."""
        return self.get_value_type()

    get_argument_type = get_return_type = get_data_type

    def as_data(self, builder: Any, value: Any) -> Any:
        """Return the value as it is."""
        return value

    as_argument = as_return = from_data = from_argument = from_return = as_data

    def load_from_data_pointer(self, builder: Any, ptr: Any, align: Any = None) -> Any:
        """Return the value at a pointer."""
        return builder.load(ptr, align=align)


class _Struct(_Whole, models.TupleModel):
    """Of a tuple of different types."""


class _Row(_Whole, models.UniTupleModel):
    """Of a tuple of one type."""


def _choose(kind: Any, whole: Any, apart: Any) -> None:
    """Give named tuples of the packages a model of their own, and leave numba's to all others."""

    def choose(manager: Any, tuple_type: Any) -> Any:
        ours = tuple_type.instance_class.__module__.partition(".")[0] in KERNEL_PACKAGES
        return (whole if ours else apart)(manager, tuple_type)

    register: Any = register_model(kind)
    register(choose)


_choose(types.NamedTuple, _Struct, models.TupleModel)
_choose(types.NamedUniTuple, _Row, models.UniTupleModel)
