"""A translation unit: structs, constants and functions of C that kernels became."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from adaptive_ff.export.calls import Calls
from adaptive_ff.export.comments import WIDTH, block_comment, section, summary
from adaptive_ff.export.errors import NotExportable
from adaptive_ff.export.functions import Function, translate_function
from adaptive_ff.export.literals import Precision
from adaptive_ff.export.names import c_name
from adaptive_ff.export.types import BOOLEAN, INTEGER, REAL, Array, Line, Record, Scalar, Type
from adaptive_ff.export.values import Value
from controllers.kernel_language.errors import NotTranslatable
from controllers.kernel_language.sources import Constant, Kernel, read_kernel

Key = tuple[Callable[..., Any], tuple[Type, ...], tuple[int | None, ...]]
"""A kernel with the types of its arguments, and those of them that are known integers."""


@dataclass(frozen=True)
class Struct:
    """A struct of C: its type, its name, and its definition."""

    type: Record | Line
    name: str
    text: str


class Unit:
    """Collects what kernels need, in an order that C takes.

    Parameters
    ----------
    precision : Precision
        How real numbers are written.
    prefix : str
        Begins the names of all structs that stem from named tuples.
    """

    def __init__(self, precision: Precision, prefix: str) -> None:
        self.precision = precision
        self.prefix = prefix
        self.calls = Calls()
        self.structs: dict[Type, Struct] = {}
        self.functions: dict[Key, Function] = {}
        self.constants: dict[str, Constant] = {}
        self.helpers: set[str] = set()
        self._pending: list[Callable[..., Any]] = []

    def c_type(self, kind: Type) -> str:
        """Return the type in C of a value that is no array."""
        if isinstance(kind, Scalar):
            return {REAL: self.precision.real, INTEGER: "int64_t", BOOLEAN: "bool"}[Scalar(kind.kind)]
        if isinstance(kind, Array):
            raise TypeError("an array is declared with its name")
        return self.struct(kind).name

    def declaration(self, kind: Type, name: str) -> str:
        """Return the declaration of a variable, argument or field; an array is a pointer to its first element."""
        if not isinstance(kind, Array):
            return f"{self.c_type(kind)} {name}"
        element, rows = self.c_type(kind.element), "".join(f"[{extent}]" for extent in kind.shape[1:])
        return f"{element} (*{name}){rows}" if rows else f"{element} *{name}"

    def struct(self, kind: Record | Line) -> Struct:
        """Return the struct of a named tuple, of a tuple of one type, or of what a function returns."""
        if kind not in self.structs:
            name = self._struct_name(kind)
            while name in {struct.name for struct in self.structs.values()}:
                name += "_"
            text = self._line_text(kind, name) if isinstance(kind, Line) else self._record_text(kind, name)
            self.structs[kind] = Struct(kind, name, text)
        return self.structs[kind]

    def _struct_name(self, kind: Record | Line) -> str:
        if isinstance(kind, Record):
            return f"{self.prefix}_{kind.name}" if kind.origin is not None else kind.name
        if isinstance(kind.element, Scalar):
            return f"{self.prefix}_{kind.element.kind}_tuple{kind.length}"
        return f"{self.prefix}_{getattr(kind.element, 'name', 'tuple')}_tuple{kind.length}"

    def _line_text(self, kind: Line, name: str) -> str:
        field = self.declaration(kind.element, f"at[{kind.length}]")
        return f"/* A tuple of {kind.length}. */\ntypedef struct {{\n    {field};\n}} {name};\n"

    def _record_text(self, kind: Record, name: str) -> str:
        described = section(kind.origin, "Attributes") if kind.origin else {}
        lines = []
        for field, item in kind.fields:
            text = described.get(field, "")
            declared = self.declaration(item, c_name(field))
            beside = f"    {declared}; /* {text} */"
            if text and len(beside) <= WIDTH and "*/" not in text:
                lines.append(block_comment(text, f"    {declared}; ").replace("\n", ""))
            else:
                lines += [*block_comment(text, "    ").splitlines(), f"    {declared};"]
        comment = block_comment(summary(kind.origin)) if kind.origin else ""
        return f"{comment}typedef struct {{\n" + "\n".join(lines) + f"\n}} {name};\n"

    def record_like(self, origin: type) -> Record | None:
        """Return the first record of a class that is in use: its fields tell which numbers are real."""
        return next((k for k in self.structs if isinstance(k, Record) and k.origin is origin), None)

    def compound(self, record: Record, values: Sequence[Value]) -> str:
        """Return a value of a struct."""
        name = self.c_type(record)
        pairs = [f".{c_name(field)} = {value.content}" for (field, _), value in zip(record.fields, values, strict=True)]
        return f"({name}){{{', '.join(pairs)}}}"

    def constant_name(self, constant: Constant) -> str:
        """Return the name of a constant, and note that it is used."""
        known = self.constants.setdefault(constant.name, constant)
        if known.value != constant.value:
            raise NotExportable(f"{constant.name} names two constants, {known.value} and {constant.value}; rename one")
        return constant.name

    def library(self, name: str, *arguments: str) -> str:
        """Return a call of a function of ``math.h``."""
        return f"{name}{self.precision.suffix}({', '.join(arguments)})"

    def helper(self, name: str, *arguments: str) -> str:
        """Return a call of one of the unit's own small functions."""
        self.helpers.add(name)
        return f"{name}({', '.join(arguments)})"

    def function(
        self,
        function: Callable[..., Any],
        kinds: tuple[Type, ...],
        constants: tuple[int | None, ...] = (),
        caller: tuple[Kernel, Any] | None = None,
    ) -> Function:
        """Return a kernel in C for arguments of some types; it is translated when it is first met.

        Arguments that are known integers, such as sizes, decide branches within it, as they do at the call.
        """
        key = (function, kinds, constants or (None,) * len(kinds))
        if key not in self.functions:
            try:
                kernel = read_kernel(function)
                if function in self._pending and caller is not None:
                    raise caller[0].refusal(caller[1], f"{kernel.name} calls itself; write a loop over a range")
                self._pending.append(function)
                self.functions[key] = translate_function(self, kernel, kinds, key[2], self._function_name(function))
            except NotTranslatable as error:
                raise NotExportable(str(error)) from error
            self._pending.pop()
        return self.functions[key]

    def _function_name(self, function: Callable[..., Any]) -> str:
        taken = {made.name: origin for (origin, _, _), made in self.functions.items()}
        name = c_name(function.__name__)
        if name in taken and taken[name] is not function:
            name = f"{function.__module__.rpartition('.')[2]}_{name}"
        count, base = 1, name
        while name in taken:
            count += 1
            name = f"{base}_{count}"
        return name
