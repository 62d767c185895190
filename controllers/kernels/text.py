"""How C writes names and numbers, in double or in single precision, and docstrings and comments of the kernels."""

import inspect
import math
import re
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import accumulate, pairwise
from typing import Any

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


WIDTH = 116
"""Longest line of a comment."""

PLAIN = str.maketrans(
    {"²": "^2", "³": "^3", "·": " ", "×": "x", "–": "-", "—": "-", "’": "'", "µ": "u", "τ": "tau", "±": "+-", "é": "e"}
)

UNIT = re.compile(r", ((?:kg|rad|m|N|s|1|Hz)\b[\w /^()*]*?)(?= as a|[,;.:]|$)")


def plain(text: str) -> str:
    """Return a text that any compiler takes within a comment."""
    text = text.translate(PLAIN).encode("ascii", "replace").decode()
    return text.replace("*/", "* /").replace("/*", "/ *").replace("``", "").replace("??", "? ?")


def comment_lines(text: str, indent: str = "") -> str:
    """Return a text of one or more lines as a comment of its own lines."""
    lines = plain(text).rstrip().splitlines()
    if not lines:
        return ""
    if len(lines) == 1 and len(indent) + len(lines[0]) + 6 <= WIDTH:
        return f"{indent}/* {lines[0]} */\n"
    wrapped = [part for line in lines for part in (_wrapped(line, WIDTH - len(indent) - 3) or [""])]
    body = "\n".join(f"{indent} * {line}".rstrip() for line in wrapped[1:])
    return f"{indent}/* {wrapped[0]}\n{body}{chr(10) if body else ''}{indent} */\n"


def _wrapped(line: str, width: int) -> list[str]:
    margin = line[: len(line) - len(line.lstrip())]
    return textwrap.wrap(line, width, subsequent_indent=margin, break_long_words=False, break_on_hyphens=False)


def summary(value: Any) -> str:
    """Return a docstring without its sections of fields and arguments."""
    return re.split(r"\n\n[A-Z][a-z]+\n-{4,}", inspect.getdoc(value) or "")[0]


def section(value: Any, title: str) -> dict[str, str]:
    """Return what a numpydoc section says of each name in it, on one line each."""
    found = re.search(rf"\n\n{title}\n-+\n(.*?)(?=\n\n[A-Z][a-z]+\n-{{4,}}|\Z)", inspect.getdoc(value) or "", re.DOTALL)
    described: dict[str, str] = {}
    names: list[str] = []
    for line in found[1].splitlines() if found else []:
        if line and not line.startswith(" "):
            names = [name.strip() for name in line.partition(" : ")[0].split(",")]
            described |= dict.fromkeys(names, "")
        elif line.strip():
            described |= {name: f"{described[name]} {line.strip()}".strip() for name in names}
    return described


@cache
def described(kind: type) -> Mapping[str, str]:
    """Return what is said of each field of a named tuple, in its docstring or beside the field in its source."""
    found = section(kind, "Attributes")
    try:
        source = inspect.getsource(kind)
    except (OSError, TypeError):  # a class that a function has made
        return found
    beside = re.findall(r"^    (\w+): [^#\n]*# (.*)$", source, re.MULTILINE)
    return {**{name: f"{text[0].upper()}{text[1:].rstrip('.')}." for name, text in beside}, **found}


def unit(description: str) -> str:
    """Return the unit that a description of a quantity names, such as ``rad/s``; empty where there is none."""
    found = UNIT.search(description)
    return found[1].strip() if found else ""


OPERATOR = re.compile(r"([+\-*/?:<>]|&&|\|\||[<>=!]=) ")


def wrapped_code(line: str, width: int = 118) -> list[str]:
    """Break a long line of C: initialisers by field, else at a comma or operator as little nested as there is one."""
    if len(line) <= width or line.lstrip().startswith(("/*", "*")):
        return [line]
    margin = len(line) - len(line.lstrip())
    depths = list(accumulate((sign in "([{") - (sign in ")]}") for sign in line))
    start = line.find("{.") + 1
    end = next((place for place in range(start, len(line)) if start and depths[place] < depths[start]), 0)
    if end:  # each field has a line
        cuts = [
            start,
            *(place + 1 for place in range(start, end) if line[place] == "," and depths[place] == depths[start]),
        ]
        parts = [line[first:last].strip().rstrip(",") for first, last in pairwise([*cuts, end])]
        inner = [part for part in parts for part in wrapped_code(f"{' ' * (margin + 4)}{part},", width)]
        return [line[:start], *inner, *wrapped_code(" " * margin + line[end:], width)]
    breaks = [(depths[place], -place) for place in range(margin + 25, width + 1) if _may_begin(line, place)]
    if not breaks:
        return [line]
    place = -min(breaks)[1]
    rest = " " * (margin if OPERATOR.match(line.lstrip()) else margin + 4) + line[place:].lstrip()
    return [line[:place].rstrip(), *wrapped_code(rest, width)]


def _may_begin(line: str, place: int) -> bool:
    """Tell whether a line may begin at a place: behind a comma or with an operator."""
    return line[place - 2 : place] == ", " or (line[place - 1] == " " and OPERATOR.match(line, place) is not None)


def joined(parts: Sequence[str]) -> str:
    """Return blocks of text with an empty line between them."""
    return "\n".join(part if part.endswith("\n") else part + "\n" for part in parts if part)
