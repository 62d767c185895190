"""Numbers as C writes them, in double or in single precision."""

import math
from dataclasses import dataclass

import numpy as np

from controllers.kernels.errors import NotTranslatable

SMALLEST_SINGLE = float(np.finfo(np.float32).tiny)
"""Smallest normal number in single precision: stands for what would round to zero."""

LARGEST_SINGLE = float(np.finfo(np.float32).max)

LEAST_INTEGER = -(2**63)
"""No literal of C: without its sign it is beyond 64 bits."""


@dataclass(frozen=True)
class Precision:
    """How real numbers are written."""

    real: str  # C type of a real number
    suffix: str  # suffix of literals and of functions of ``math.h``

    def literal(self, value: float | bool, where: str = "a number") -> str:
        """Return a constant as C writes it; the shortest text that reads back as the same number."""
        if isinstance(value, bool | np.bool_):
            return "true" if value else "false"
        if isinstance(value, int | np.integer):
            return str(int(value)) if value != LEAST_INTEGER else "INT64_MIN"
        if math.isnan(value):
            return self._as_real("NAN")
        if math.isinf(value):
            return self._as_real("INFINITY" if value > 0.0 else "-INFINITY")
        if not self.suffix:
            return repr(float(value))
        if abs(value) > LARGEST_SINGLE:
            raise NotTranslatable(f"{where} = {value} is too large for single precision")
        if value != 0.0 and abs(value) < SMALLEST_SINGLE:  # a bound that tells tiny from zero must not become zero
            value = math.copysign(SMALLEST_SINGLE, value)
        text = str(np.float32(value))
        return (text if any(sign in text for sign in ".e") else text + ".0") + self.suffix

    def _as_real(self, text: str) -> str:
        """Return one of the two macros of ``math.h``, which are single, without a promotion to warn of."""
        return text if self.suffix else f"({self.real}){text}"


DOUBLE, SINGLE = Precision("double", ""), Precision("float", "f")
