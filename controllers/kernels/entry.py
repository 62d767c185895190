"""The text in C of entry points: a kernel called with what lies in memory, and the kernels of a controller."""

import hashlib
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from controllers.kernels.sources import identity
from controllers.kernels.text import DOUBLE, joined
from controllers.kernels.types import REAL, Array, Record, Type, passed_by_pointer, text_of

if TYPE_CHECKING:
    from controllers.kernels.unit import Unit

ROW = Array(REAL, (None,))
"""Type of a row of numbers."""


def library_unit() -> "Unit":
    """Return a unit of kernels for this machine: sizes are known at run time."""
    from controllers.kernels.unit import Unit  # a translator is for what has not been compiled yet

    return Unit(DOUBLE, "aff", fixed=False)


def symbol_of(kernels: Sequence[Callable[..., Any]], kinds: tuple[Type, ...]) -> str:
    """Return the name in C of kernels for types of arguments."""
    key = " ".join([*map(identity, kernels), *map(text_of, kinds)])
    return f"{kernels[0].__name__.strip('_')}_{hashlib.sha256(key.encode()).hexdigest()[:20]}"


def entry_text(
    unit: "Unit", kernel: Callable[..., Any], kinds: tuple[Type, ...], symbol: str
) -> tuple[str, Type | None]:
    """Return ``void symbol(arguments, result)`` with both as structs in memory, and what the kernel gives."""
    made = unit.function(kernel, kinds)
    declared = "\n".join(f"    {unit.declaration(kind, f'f{k}')};" for k, kind in enumerate(kinds))
    passed = ", ".join(f"{'&' if passed_by_pointer(kind) else ''}own->f{k}" for k, kind in enumerate(kinds))
    given = "(void)result;\n    " if made.result is None else f"*({unit.c_type(made.result)} *)result = "
    text = f"""typedef struct {{
{declared}
}} {symbol}_arguments;

WHOLE PUBLIC void {symbol}(const void *restrict arguments, void *restrict result)
{{
    const {symbol}_arguments *restrict own = arguments;
    {given}{made.name}({passed});
}}
"""
    return text, made.result


def controller_text(
    unit: "Unit", kernels: tuple[Any, Any, Any], kinds: tuple[Type, Type, Type], symbol: str, torque: int
) -> str:
    """Return step, estimates and monitors of a controller, each ``void (parameters, state, row, count)``."""
    parameters, state, inputs = kinds
    step = unit.function(kernels[0], kinds)
    assert isinstance(step.result, Record)
    assert isinstance(inputs, Record)
    output, new = (name for name, _ in step.result.fields)
    own, own_parameters = unit.c_type(state), f"((const {unit.c_type(parameters)} *)parameters)"
    passed = f"{own_parameters if passed_by_pointer(parameters) else '*' + own_parameters}"
    passed += f", {'own' if passed_by_pointer(state) else '*own'}"
    head = "const void *restrict parameters, void *restrict state, double *restrict row, int64_t count"
    fields = ", ".join(f"row[{k}]" for k in range(len(inputs.fields)))
    texts = [
        f"""WHOLE PUBLIC void {symbol}_step({head})
{{
    {own} *restrict own = state;
    (void)count;
    const {unit.c_type(inputs)} inputs = {{{fields}}};
    const {unit.c_type(step.result)} result = {step.name}({passed}, &inputs);
    *own = result.{new};
    row[{torque}] = result.{output}.torque;
    row[{torque + 1}] = result.{output}.feedforward;
}}
"""
    ]
    for kernel, name in zip(kernels[1:], ("estimates", "monitors"), strict=True):
        if kernel is not None:
            made = unit.function(kernel, (parameters, state, ROW))
            texts.append(
                f"""PUBLIC void {symbol}_{name}({head})
{{
    const {own} *restrict own = state;
    {made.name}({passed}, ({unit.c_type(ROW)}){{row, count}});
}}
"""
            )
    return "\n".join(texts)


def file_text(unit: "Unit", entries: Sequence[str]) -> str:
    """Return a file of C: what entries need of a unit, and the entries."""
    return joined(
        [
            unit.head,
            unit.definitions(),
            *(struct.text for struct in unit.structs.values()),
            *unit.helper_texts(),
            *(made.text for made in unit.called_in("\n".join(entries))),
            *entries,
        ]
    )
