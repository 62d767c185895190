"""Units of a joint by its axis: rad, N m and kg m² where it is rotary; m, N and kg where it is linear."""

import re


def of_linear(unit: str) -> str:
    """Return the unit of a linear axis that stands for one of a rotary joint."""
    return re.sub(r"\b([mkµ]?)rad\b", r"\1m", unit.replace("kg m²", "kg").replace("(N m)", "N").replace("N m", "N"))


def axis_unit(axis: str, unit: str) -> str:
    """Return the unit that an axis, rotary or linear, has for one of a rotary joint, with or without a prefix."""
    return of_linear(unit) if axis == "linear" else unit


def axis_label(axis: str, label: str) -> str:
    """Return the label that an axis has for one of a rotary joint, such as ``torque (N m)``: ``force (N)``."""
    return axis_unit(axis, label).replace("torque", "force") if axis == "linear" else label
