"""Units of inputs, outputs and estimates."""

from adaptive_ff.friction.model import unit_of
from controllers.kernels.comments import plain, section, unit


def estimate_unit(name: str) -> str:
    """Return the unit of a physical estimate by its name, which may end in a direction; empty where it is not known."""
    base = name.removesuffix("_positive").removesuffix("_negative")
    return plain(unit_of(base))


def field_units(origin: type) -> dict[str, str]:
    """Return the unit of each field of a named tuple, as its docstring says it."""
    return {name: unit(text) for name, text in section(origin, "Attributes").items()}
