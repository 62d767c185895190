"""Names that C code may have."""

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
