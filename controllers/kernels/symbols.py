"""Symbols that the kernels of a unit share: constants under their names in C, and types in the order of their use."""

from controllers.kernels.language import NotTranslatable
from controllers.kernels.sources import Constant
from controllers.kernels.types import Array, Line, Record, Scalar, Type


class Symbols:
    """Notes the symbols of kernels as these are read, for this machine or ``fixed``, for firmware."""

    def __init__(self, *, fixed: bool) -> None:
        self.fixed = fixed
        self.constants: dict[str, Constant] = {}
        self.types: list[Record | Line | Array] = []  # met since a function was printed

    def note(self, kind: Type) -> None:
        """Note that a type is used: structs stand in the order in which they are met."""
        if not isinstance(kind, Scalar) and (not isinstance(kind, Array) or kind.is_open):
            self.types.append(kind)

    def constant_name(self, constant: Constant) -> str:
        """Return the name of a constant, and note that it is used."""
        name, count = constant.name, 1
        while self.constants.setdefault(name, constant).value != constant.value:
            if self.fixed:
                values = f"{self.constants[name].value} and {constant.value}"
                raise NotTranslatable(f"{name} names two constants, {values}; rename one")
            count += 1
            name = f"{constant.name}_{count}"
        return name
