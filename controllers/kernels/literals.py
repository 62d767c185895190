"""Names and numbers as C writes them, in double or in single precision."""

import math
from dataclasses import dataclass

import numpy as np

from controllers.kernels.language import NotTranslatable

WORDS = """
    auto bool break case char const continue default do double else enum extern false float for goto if inline int
    long register restrict return short signed sizeof static struct switch true typedef union unsigned void volatile
    while
"""
"""Words of C."""

WORDS_OF_C_PLUS_PLUS = """
    class delete explicit export friend mutable namespace new operator private protected public template this throw
    try catch typename using virtual
"""
"""Words of C++, which reads the header."""

FUNCTIONS = """
    exp expm1 asinh sin cos log pow sqrt fabs copysign memcpy memset square larger smaller floored_rest
    floored_quotient
"""
"""Functions of C's library, and the small ones beside kernels, that most exports have."""

OTHER_FUNCTIONS = """
    larger_integer smaller_integer absolute_integer whole_number from_start
    log1p tan asin acos atan atan2 sinh cosh tanh acosh atanh floor ceil memmove isfinite isnan isinf isnormal signbit
    abs fdim fma fmax fmin hypot lgamma tgamma erf erfc nan cbrt round trunc rint nearbyint remainder remquo logb ilogb
    scalbn scalbln ldexp frexp modf fmod exp2 log2 log10 nextafter nexttoward lround llround lrint llrint fpclassify
"""
"""Others of both: no kernel can have such a name, a variable can."""

RESERVED = frozenset((WORDS + WORDS_OF_C_PLUS_PLUS + FUNCTIONS).split())
"""Names that are taken."""

FILE_NAMES = """
    main assert complex ctype errno fenv inttypes iso646 limits locale math setjmp signal stdalign stdarg stdatomic
    stdbool stddef stdint stdio stdlib stdnoreturn string tgmath threads time uchar wchar wctype
"""

FILES = frozenset(FILE_NAMES.split())
"""Files that are there already: the example, and headers of C, in whose place a header of that name would be read."""


def function_name(name: str) -> str:
    """Return the name of a kernel that no function of C has."""
    return f"{name}_" if name in RESERVED or name in OTHER_FUNCTIONS.split() else name


def c_name(name: str) -> str:
    """Return a name that neither C nor C++ takes for something else."""
    return f"{name}_" if name in RESERVED else name


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
