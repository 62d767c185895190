"""A translation unit: structs, constants and functions of C that kernels became."""

import ast
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from controllers.kernels.comments import WIDTH, comment_lines, described, summary
from controllers.kernels.errors import NotTranslatable
from controllers.kernels.literals import Precision, c_name
from controllers.kernels.record import meaning
from controllers.kernels.sources import Constant, Kernel, resolve
from controllers.kernels.types import BOOLEAN, INTEGER, REAL, Array, Line, Record, Scalar, Type
from controllers.kernels.values import Value, open_name

C_PARTS = {
    (re.search(r"(\w+)\(\w+ \w+[,)]", part) or ("", ""))[1]: f"{part.rstrip()}\n"
    for part in Path(__file__).with_name("kernels.c").read_text(encoding="ascii").split("\n\n")
}
"""The head of a library, and the small functions beside kernels: what Python's operations do and no operator of C."""

Known = float | str | None
"""What is known of a number at translation: its value, ``natural`` where it is not negative, or nothing."""

Key = tuple[Callable[..., Any], tuple[Type, ...], tuple[Known, ...]]
"""A kernel with the types of its arguments, and what is known of them."""


@dataclass(frozen=True)
class Function:
    """A function of C."""

    name: str  # its name
    result: Type | None  # what it returns; none for one that changes arrays in place only
    kernel: Kernel  # what it was translated from
    text: str  # its definition with its comment
    writes: bool  # whether it changes arrays in place
    constant: int | None = None  # what it returns, where that is an integer or truth value that is known at translation
    natural: bool = False  # whether what it returns is known to be not negative
    files: frozenset[Path] = frozenset()  # files of it and of what it calls
    meanings: Mapping[tuple[str, str], str] = field(default_factory=dict)  # what the global names in these stand for


@dataclass(frozen=True)
class Struct:
    """A struct of C: its type, its name, and its definition."""

    type: Type
    name: str
    text: str


class Unit:
    """Collects what kernels need, in an order that C takes; a ``Translator`` has what makes functions of them."""

    function: Callable[..., Function]

    def __init__(self, precision: Precision, prefix: str, *, fixed: bool) -> None:
        self.precision = precision
        self.prefix = prefix
        self.fixed = fixed
        self.structs: dict[Type, Struct] = {}
        self.functions: dict[Key, Function] = {}
        self.constants: dict[str, Constant] = {}
        self.helpers: set[str] = set()
        self.files: set[Path] = set()
        self.meanings: dict[tuple[str, str], str] = {}
        self._names: set[str] = set()
        self._pending: list[Callable[..., Any]] = []

    def resolved(self, kernel: Kernel, node: ast.expr) -> Any:
        """Return what a global name of a kernel stands for; the translation holds for no other meaning of it."""
        found = resolve(kernel, node)
        if not self.fixed:
            module, name = kernel.function.__module__, ast.unparse(node)
            if (module, name) not in self.meanings:
                self.meanings[module, name] = meaning(kernel.function.__globals__, name)
        return found

    def c_type(self, kind: Type) -> str:
        """Return the type in C of a value that is no array of fixed sizes."""
        if isinstance(kind, Scalar):
            return {REAL: self.precision.real, INTEGER: "int64_t", BOOLEAN: "bool"}[Scalar(kind.kind)]
        if isinstance(kind, Array) and not kind.is_open:
            raise TypeError("an array is declared with its name")
        return self.struct(kind).name

    def declaration(self, kind: Type, name: str) -> str:
        """Return the declaration of a variable, argument or field; an array of fixed sizes is a pointer."""
        if not isinstance(kind, Array) or kind.is_open:
            return f"{self.c_type(kind)} {name}"
        element, rows = self.c_type(kind.element), "".join(f"[{extent}]" for extent in kind.shape[1:])
        return f"{element} (*{name}){rows}" if rows else f"{element} *{name}"

    def struct(self, kind: Record | Line | Array) -> Struct:
        """Return the struct of a named tuple, a tuple of one type, what a function returns, or an open array."""
        if kind not in self.structs:
            name = self._struct_name(kind)
            while name in self._names:
                name += "_"
            text = self._text(kind, name)
            self._names.add(name)
            self.structs[kind] = Struct(kind, name, text)
        return self.structs[kind]

    def _text(self, kind: Record | Line | Array, name: str) -> str:
        if isinstance(kind, Record):
            return self._record_text(kind, name)
        if isinstance(kind, Line):
            field = self.declaration(kind.element, f"at[{kind.length}]")
            return f"/* A tuple of {kind.length}. */\ntypedef struct {{\n    {field};\n}} {name};\n"
        sizes = ", ".join(f"size{axis}" for axis in range(len(kind.shape)))
        return f"typedef struct {{\n    {self.c_type(kind.element)} *data;\n    int64_t {sizes};\n}} {name};\n"

    def _struct_name(self, kind: Record | Line | Array) -> str:
        if isinstance(kind, Array):
            return open_name(kind)
        if isinstance(kind, Record):
            return f"{self.prefix}_{kind.name}" if kind.origin is not None else kind.name
        if isinstance(kind.element, Scalar):
            return f"{self.prefix}_{kind.element.kind}_tuple{kind.length}"
        return f"{self.prefix}_{getattr(kind.element, 'name', 'tuple')}_tuple{kind.length}"

    def _record_text(self, kind: Record, name: str) -> str:
        texts = described(kind.origin) if kind.origin and self.fixed else {}
        lines, last = [], ""
        for member, item in kind.fields:
            said = texts.get(member, "")
            text, last = "" if said == last else said, said  # what is said of several stands at the first
            declared = self.declaration(item, c_name(member))
            beside = f"    {declared}; /* {text} */"
            if text and len(beside) <= WIDTH and "*/" not in text:
                lines.append(comment_lines(text, f"    {declared}; ").replace("\n", ""))
            else:
                lines += [*comment_lines(text, "    ").splitlines(), f"    {declared};"]
        comment = comment_lines(summary(kind.origin)) if kind.origin and self.fixed else ""
        return f"{comment}typedef struct {{\n" + "\n".join(lines) + f"\n}} {name};\n"

    def compound(self, record: Record, values: Sequence[Value]) -> str:
        """Return a value of a struct."""
        name = self.c_type(record)
        pairs = [f".{c_name(field)} = {value.content}" for (field, _), value in zip(record.fields, values, strict=True)]
        return f"({name}){{{', '.join(pairs)}}}"

    def constant_name(self, constant: Constant) -> str:
        """Return the name of a constant, and note that it is used."""
        name, count = constant.name, 1
        while self.constants.setdefault(name, constant).value != constant.value:
            if self.fixed:
                values = f"{self.constants[name].value} and {constant.value}"
                raise NotTranslatable(f"{name} names two constants, {values}; rename one")
            count += 1
            name = f"{constant.name}_{count}"
        return name

    def library(self, name: str, *arguments: str) -> str:
        """Return a call of a function of ``math.h``."""
        return f"{name}{self.precision.suffix}({', '.join(arguments)})"

    def helper(self, name: str, *arguments: str) -> str:
        """Return a call of one of the unit's own small functions."""
        self.helpers.add(name)
        return f"{name}({', '.join(arguments)})"

    def helper_texts(self) -> list[str]:
        """Return the definitions of the unit's own small functions, in order."""
        words = {"STATIC": "static" if self.fixed else "KERNEL", "REAL": self.precision.real}
        return [re.sub("STATIC|REAL", lambda word: words[word[0]], C_PARTS[name]) for name in sorted(self.helpers)]

    def definitions(self) -> str:
        """Return all constants, in firmware with what is said of them, of those that stand together once."""
        lines, last = [], ""
        for name, constant in sorted(self.constants.items()):
            if self.fixed and constant.doc and constant.doc != last:
                lines += comment_lines(constant.doc).splitlines()
            last = constant.doc
            text = self.precision.literal(constant.value, name)
            lines.append(f"#define {name} {f'({text})' if text.startswith('-') else text}")
        return "\n".join(lines)

    def called_in(self, code: str) -> list[Function]:
        """Return the functions that some code needs, callees first; of those that give a known number it needs none."""
        made = {function.name: function for function in self.functions.values()}
        pending, used = [code], set[str]()
        while pending:
            code = re.sub(r"/\*.*?\*/", "", pending.pop(), flags=re.DOTALL)
            new = {name for name in re.findall(r"\b(\w+)\(", code) if name in made} - used
            used |= new
            pending += [made[name].text for name in new]
        return [function for name, function in made.items() if name in used]
