"""Small functions of C beside the kernels: what Python's operations do and no operator of C does."""

CHOICE = """{static} {kind} {name}({kind} first, {kind} second)
{{{{
    return second {sign} first ? second : first;
}}}}
"""
"""Of equal values, and beside what is not a number, the first one is taken, as in Python."""


def _choice(kind: str, name: str, sign: str) -> str:
    return CHOICE.format(static="{static}", kind=kind, name=name, sign=sign)


HELPERS = {  # rest and quotient of integers are rounded down as in Python
    "square": "{static} {real} square({real} value)\n{{\n    return value * value;\n}}\n",
    "larger": _choice("{real}", "larger", ">"),
    "smaller": _choice("{real}", "smaller", "<"),
    "larger_integer": _choice("int64_t", "larger_integer", ">"),
    "smaller_integer": _choice("int64_t", "smaller_integer", "<"),
    "absolute_integer": """{static} int64_t absolute_integer(int64_t value)
{{
    return value < 0 ? (int64_t)(0u - (uint64_t)value) : value;
}}
""",
    "floored_rest": """{static} int64_t floored_rest(int64_t value, int64_t divisor)
{{
    if (divisor == 0 || divisor == -1) {{
        return 0;
    }}
    int64_t rest = value % divisor;
    return rest != 0 && (rest < 0) != (divisor < 0) ? rest + divisor : rest;
}}
""",
    "floored_quotient": """{static} int64_t floored_quotient(int64_t value, int64_t divisor)
{{
    if (divisor == 0) {{
        return 0;
    }}
    if (divisor == -1) {{
        return (int64_t)(0u - (uint64_t)value);
    }}
    return value / divisor - (value % divisor != 0 && (value < 0) != (divisor < 0));
}}
""",
    "whole_number": """/* The integer towards zero, the nearest that there is; zero for what is not a number. */
{static} int64_t whole_number({real} value)
{{
    if (value >= -9223372036854775808.0 && value < 9223372036854775808.0) {{
        return (int64_t)value;
    }}
    return value < 0.0 ? INT64_MIN : value > 0.0 ? INT64_MAX : 0;
}}
""",
    "from_start": """/* An index that counts from the end where it is negative. */
{static} int64_t from_start(int64_t index, int64_t size)
{{
    return index < 0 ? index + size : index;
}}
""",
    "copy_array": """/* Copy what both arrays have; on an axis on which the other has one element, that is repeated. */
static void copy_array(void *to, const int64_t *sizes, const void *from, const int64_t *given, int axes, size_t width)
{{
    int64_t count = 1;
    bool alike = true;
    for (int k = 0; k < axes; k++) {{
        count *= sizes[k];
        alike = alike && sizes[k] == given[k];
    }}
    if (alike) {{
        memmove(to, from, (size_t)count * width);
        return;
    }}
    for (int64_t place = 0; place < count; place++) {{
        int64_t left = place, source = 0, stride = 1;
        bool both = true;
        for (int k = axes - 1; k >= 0; k--) {{
            const int64_t index = left % sizes[k];
            left /= sizes[k];
            both = both && (given[k] == 1 || index < given[k]);
            source += (given[k] == 1 ? 0 : index) * stride;
            stride *= given[k];
        }}
        if (both) {{
            memcpy((char *)to + (size_t)place * width, (const char *)from + (size_t)source * width, width);
        }}
    }}
}}
""",
}
"""Texts with places for ``static`` and for the type of real numbers."""


def helper_texts(names: set[str], real: str, static: str = "static") -> list[str]:
    """Return the definitions of helpers, in order."""
    return [HELPERS[name].format(real=real, static=static) for name in sorted(names)]
