"""Numbers as C writes them, in double or in single precision."""

import math
from dataclasses import dataclass

import numpy as np

from adaptive_ff.export.errors import NotExportable

SMALLEST_SINGLE = float(np.finfo(np.float32).tiny)
"""Smallest normal number in single precision: stands for what would round to zero."""

LARGEST_SINGLE = float(np.finfo(np.float32).max)

IN_SINGLE = {"CANDIDATES_LEAST_PRIOR": 1e-6, "CANDIDATE_MOMENTS_LEAST_LEFT": 64.0 * float(np.finfo(np.float32).eps)}
"""Constants of kernels that stand for the rounding of sums, by their names in C: what they are in single precision.

With those of double precision the candidates for the friction curve are chosen by rounding, up to 46 times in 12 s at
20 kHz, each time with the lag that is assumed at first; 1e-5 for the prior holds estimates back at 1 kHz and faster.
"""


@dataclass(frozen=True)
class Precision:
    """How real numbers are written.

    Attributes
    ----------
    real : str
        C type of a real number.
    suffix : str
        Suffix of literals and of functions of ``math.h``.
    """

    real: str
    suffix: str

    def literal(self, value: float | bool, where: str = "a number") -> str:
        """Return a constant as C writes it; the shortest text that reads back as the same number."""
        if isinstance(value, bool | np.bool_):
            return "true" if value else "false"
        if isinstance(value, int | np.integer):
            return str(int(value))
        if math.isnan(value):
            return self._as_real("NAN")
        if math.isinf(value):
            return self._as_real("INFINITY" if value > 0.0 else "-INFINITY")
        if not self.suffix:
            return repr(float(value))
        if abs(value) > LARGEST_SINGLE:
            raise NotExportable(f"{where} = {value} cannot be exported in single precision: it is too large")
        if value != 0.0 and abs(value) < SMALLEST_SINGLE:  # a bound that tells tiny from zero must not become zero
            value = math.copysign(SMALLEST_SINGLE, value)
        text = str(np.float32(value))
        return (text if any(sign in text for sign in ".e") else text + ".0") + self.suffix

    def _as_real(self, text: str) -> str:
        """Return one of the two macros of ``math.h``, which are single, without a promotion to warn of."""
        return text if self.suffix else f"({self.real}){text}"

    def constant(self, name: str, value: float | bool) -> str:
        """Return a constant of a kernel, by its name in C, as C writes it."""
        return self.literal(IN_SINGLE.get(name, value) if self.suffix else value, name)


DOUBLE, SINGLE = Precision("double", ""), Precision("float", "f")
