"""The source of an exported controller: constants, translated kernels, and the functions of the header."""

import importlib
import re

from adaptive_ff.export.entry_points import entry_points, estimates
from adaptive_ff.export.export import Export
from adaptive_ff.export.state_functions import state_buffer
from adaptive_ff.export.tables import state_tables
from controllers.kernels.comments import block_comment, joined, plain, summary
from controllers.kernels.helpers import helper_texts
from controllers.kernels.sources import Constant
from controllers.kernels.unit import Function

GUARD = """#if defined(__FAST_MATH__) || defined(_M_FP_FAST) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "fast-math drops the tests for what is not a number, on which this controller depends: compile without it"
#endif
"""

CONTRACTION = """#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif
"""


def source(export: Export) -> str:
    """Return the source."""
    kernels = _kernels(export)  # first: it says which constants and helpers there are
    public = len(export.public_structs)
    parts = [
        f'/* {plain(export.title)} See {export.prefix}.h. */\n#include "{export.prefix}.h"\n',
        "#include <math.h>\n#include <string.h>\n",
        GUARD,
        CONTRACTION,
        _constants(export),
        *(struct.text for struct in list(export.unit.structs.values())[public:]),
        *helper_texts(export.unit.helpers, export.precision.real),
        kernels,
        state_tables(export),
        entry_points(export),
        state_buffer(export),
        estimates(export),
    ]
    return joined(parts)


def _constants(export: Export) -> str:
    lines = []
    for name, constant in sorted(export.unit.constants.items()):
        lines += block_comment(constant.doc).splitlines() if constant.doc else []
        lines += _definitions(export, name, constant)
    return "\n".join(lines)


def _definitions(export: Export, name: str, constant: Constant) -> list[str]:
    values = constant.value if isinstance(constant.value, tuple) else None
    pairs = [(name, constant.value)] if values is None else [(f"{name}_{i}", item) for i, item in enumerate(values)]
    texts = [(key, export.precision.constant(key, item)) for key, item in pairs]
    return [f"#define {key} {f'({text})' if text.startswith('-') else text}" for key, text in texts]


def used_functions(export: Export) -> list[Function]:
    """Return the functions that are called, callees first; of those that give a known number, the number is used."""
    made = {function.name: function for function in export.unit.functions.values()}
    pending = [function for function in (export.step, export.write_estimates) if function is not None]
    used: set[str] = set()
    while pending:
        function = pending.pop()
        if function.name not in used:
            used.add(function.name)
            code = re.sub(r"/\*.*?\*/", "", function.text, flags=re.DOTALL)
            pending += [made[name] for name in re.findall(r"\b(\w+)\(", code) if name in made]
    return [function for name, function in made.items() if name in used]


def _kernels(export: Export) -> str:
    parts, last, seen = [], "", set()
    for function in used_functions(export):
        kernel = function.kernel
        if kernel.path != last:
            last = kernel.path
            module = importlib.import_module(kernel.function.__module__)
            text = f"---- {kernel.path}" if last in seen else f"---- {kernel.path}\n\n{summary(module)}"
            seen.add(last)
            parts.append(block_comment(text))
        parts.append(function.text)
    return joined(parts)
