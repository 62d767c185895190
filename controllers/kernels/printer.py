"""The printer of the typed tree to C99: for this machine or, with sizes that are fixed and comments, for firmware."""

import inspect
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from controllers.kernels.text import WIDTH, Precision, c_name, comment_lines, described, summary, wrapped_code
from controllers.kernels.tree import Do, For, Function, Give, If, Let, Node, Statement, Variable, While
from controllers.kernels.types import BOOLEAN, INTEGER, REAL, Array, Line, Record, Scalar, Type, passed_by_pointer

C_PARTS = {
    (re.search(r"(\w+)\(\w+ \w+[,)]", part) or ("", ""))[1]: f"{part.rstrip()}\n"
    for part in Path(__file__).with_name("kernels.c").read_text(encoding="ascii").split("\n\n")
}
"""The head of a library, and the small functions beside kernels: what Python's operations do and no operator of C."""

PRIMARY, UNARY, SUM, JOINED, CHOICE = 99, 14, 11, 5, 2
RANKS = {"*": 12, "/": 12, "%": 12, "+": SUM, "-": SUM, "<": 9, ">": 9, "<=": 9, ">=": 9, "==": 9, "!=": 9}
RANKS |= {"&&": 4, "||": 3}
"""How tightly operators of C bind; comparisons all alike: compilers warn of one in another without parentheses."""


class Struct(NamedTuple):
    """A struct of C: its name and its definition."""

    name: str
    text: str


class Printer:
    """Prints types, expressions, statements and functions; notes which structs and helpers these need."""

    def __init__(self, precision: Precision, prefix: str, *, fixed: bool) -> None:
        self.precision = precision
        self.prefix = prefix
        self.fixed = fixed
        self.head = C_PARTS[""]
        self.structs: dict[Type, Struct] = {}
        self.helpers: set[str] = set()
        self._names: set[str] = set()
        self._used: set[str] = set()  # variables that are named in the function that is printed

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
            text = self._struct_text(kind, name)
            self._names.add(name)
            self.structs[kind] = Struct(name, text)
        return self.structs[kind]

    def _struct_name(self, kind: Record | Line | Array) -> str:
        if isinstance(kind, Array):
            return _open_name(kind)
        if isinstance(kind, Record):
            return f"{self.prefix}_{kind.name}" if kind.origin is not None else kind.name
        element = kind.element.kind if isinstance(kind.element, Scalar) else getattr(kind.element, "name", "tuple")
        return f"{self.prefix}_{element}_tuple{kind.length}"

    def _struct_text(self, kind: Record | Line | Array, name: str) -> str:
        if isinstance(kind, Line):
            field = self.declaration(kind.element, f"at[{kind.length}]")
            return f"/* A tuple of {kind.length}. */\ntypedef struct {{\n    {field};\n}} {name};\n"
        if isinstance(kind, Array):
            sizes = ", ".join(f"size{axis}" for axis in range(len(kind.shape)))
            return f"typedef struct {{\n    {self.c_type(kind.element)} *data;\n    int64_t {sizes};\n}} {name};\n"
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

    def helper_texts(self) -> list[str]:
        """Return the definitions of the small functions beside kernels that are used, in order."""
        words = {"STATIC": "static" if self.fixed else "KERNEL", "REAL": self.precision.real}
        return [re.sub("STATIC|REAL", lambda word: words[word[0]], C_PARTS[name]) for name in sorted(self.helpers)]

    def text(self, node: Node, rank: int = 0) -> str:
        """Return an expression in C, in parentheses where an operator of a rank around it binds more tightly."""
        return f"({self._text(node)})" if _rank(node) < rank else self._text(node)

    def _text(self, node: Node) -> str:
        match node.kind:
            case "number":
                return self.precision.literal(node.constant, node.name or "a number")
            case "constant":
                return node.name
            case "variable":
                assert node.variable is not None
                return f"{'*' if node.variable.is_pointer else ''}{self._named(node.variable)}"
            case "field":
                return f"{self._behind(node.parts[0])}{c_name(node.name)}"
            case "size":
                base, _, axes = self._flat(node.parts[0])
                return f"{base}.size{axes + int(node.name)}"
            case "element":
                return self._element(node)
            case "operator":
                return self._operator(node)
            case "real" | "integer":
                assert node.type is not None
                return f"({self.c_type(node.type)}){self.text(node.parts[0], UNARY)}"
            case "choice":
                test, *others = node.parts
                first, second = (self.text(other, CHOICE + 1) for other in others)
                return f"{self.text(test, CHOICE + 1)} ? {first} : {second}"
            case "make":
                return self._struct_value(node)
            case "by address":
                address, *places, row = (self.text(part, UNARY) for part in node.parts)
                function = f"((void (*)(void *, void *, double *, int64_t))(intptr_t){address})"
                pointers = "".join(f"(void *)(intptr_t){place}, " for place in places)
                return f"{function}({pointers}{row}.data, {row}.size0)"
        arguments = ", ".join(
            self.address(part) if passed_by_pointer(part.type) else self.text(part) for part in node.parts
        )
        if node.kind == "call" and node.name in C_PARTS:
            self.helpers.add(node.name)
        return f"{node.name}{self.precision.suffix if node.kind == 'math' else ''}({arguments})"

    def _named(self, variable: Variable) -> str:
        self._used.add(variable.name)
        return variable.name

    def address(self, node: Node) -> str:
        """Return a pointer to a place in memory."""
        if node.variable is not None and node.variable.is_pointer:
            return self._named(node.variable)
        return f"&{self.text(node, UNARY)}"

    def _behind(self, owner: Node) -> str:
        """Return a record or tuple with what stands in C between it and the name of a field."""
        if owner.variable is not None and owner.variable.is_pointer:
            return f"{self._named(owner.variable)}->"
        return f"{self.text(owner, PRIMARY)}."

    def _flat(self, node: Node) -> tuple[str, str, int]:
        """Return an array of open sizes, which element or row of all of it is meant, and behind how many axes."""
        if node.kind != "element" or not isinstance(node.parts[0].type, Array):
            return self.text(node, PRIMARY), "", 0
        base, place, axes = self._flat(node.parts[0])
        if not axes:
            return base, self.text(node.parts[1]), 1
        return base, f"{_simple(place)} * {base}.size{axes} + {self.text(node.parts[1], SUM)}", axes + 1

    def _element(self, node: Node) -> str:
        owner, index = node.parts
        if isinstance(owner.type, Line):
            return f"{self._behind(owner)}at[{self.text(index)}]"
        if not owner.array.is_open:
            return f"{self.text(owner, PRIMARY)}[{self.text(index)}]"
        base, place, axes = self._flat(node)
        if not isinstance(node.type, Array):
            return f"{base}.data[{place}]"
        sizes = [f"{base}.size{axes + axis}" for axis in range(len(node.type.shape))]
        start = f"{base}.data + {' * '.join([_simple(place), *sizes])}"
        return f"({_open_name(node.type)}){{{', '.join([start, *sizes])}}}"

    def _operator(self, node: Node) -> str:
        sign, parts = node.name, node.parts
        if len(parts) == 1:
            return f"{sign}{self.text(parts[0], UNARY + (sign == '-'))}"
        if sign in ("&&", "||"):
            return f" {sign} ".join(self.text(part, JOINED) for part in parts)
        rank = RANKS[sign]  # C and Python both group from the left; parentheses keep the grouping of the tree exactly
        first = self.text(parts[0], rank if rank >= SUM else rank + 1)
        return f" {sign} ".join([first, *(self.text(part, rank + 1) for part in parts[1:])])

    def _struct_value(self, node: Node) -> str:
        values = [self.text(part) for part in node.parts]
        assert isinstance(node.type, Record | Line)
        if isinstance(node.type, Record):
            names = (name for name, _ in node.type.fields)
            values = [f".{c_name(name)} = {value}" for name, value in zip(names, values, strict=True)]
            return f"({self.c_type(node.type)}){{{', '.join(values)}}}"
        return f"({self.c_type(node.type)}){{{{{', '.join(values)}}}}}"

    def _integer(self, node: Node) -> str:
        """Return an integer, of a known one its value, but for constants of modules, whose names say more."""
        return self.text(node) if node.constant is None or _is_of_constants(node) else str(node.constant)

    def _lines(self, body: Sequence[Statement], depth: int) -> Iterator[str]:
        """Yield the lines of statements; after a variable that may be used nowhere, one that is written if so."""
        margin = "    " * depth
        for each in body:
            match each:
                case Let(variable, value):
                    if variable.type is not None:  # else its only values are in branches for other sizes
                        yield f"{margin}{self._let(each)};"
                    if value is not None and self.fixed:
                        yield f"{margin}(void){variable.name};"
                case Give(place, value, sign):
                    yield f"{margin}{self.text(place)} {sign}= {self.text(value)};"
                case Do(value, word):
                    yield f"{margin}{word}{self.text(value)};"
                case str():
                    yield f"{margin}{each}"
                case If():
                    yield from self._branch(each, depth)
                case For(counter, start, end, stride, inner):
                    name, sign, change = counter.name, *(("<", "++") if stride == 1 else (">", "--"))
                    first = f"{'int' if counter.is_int else 'int64_t'} {name} = {self._integer(start)}"
                    yield f"{margin}for ({first}; {name} {sign} {self._integer(end)}; {name}{change}) {{"
                    yield from self._lines(inner, depth + 1)
                    yield f"{margin}}}"
                case While(test, inner):
                    yield f"{margin}while ({self.text(test)}) {{"
                    yield from self._lines(inner, depth + 1)
                    yield f"{margin}}}"

    def _declared(self, variable: Variable, restrict: str = "") -> str:
        assert variable.type is not None
        if variable.is_pointer:
            return f"const {self.c_type(variable.type)} *{restrict}{variable.name}"
        return self.declaration(variable.type, variable.name)

    def _let(self, each: Let) -> str:
        variable, value = each.variable, each.value
        if value is None:
            return self._declared(variable)
        if variable.is_pointer:
            return f"{self._declared(variable)} = {self.address(value)}"
        if variable.type == INTEGER and variable.constant is not None:
            return f"const {'int' if self.fixed else 'int64_t'} {variable.name} = {self._integer(value)}"
        constant = "const " if each.is_constant and not isinstance(variable.type, Array) else ""
        return f"{constant}{self._declared(variable)} = {self.text(value)}"

    def _branch(self, branch: If, depth: int) -> Iterator[str]:
        margin = "    " * depth
        yield f"{margin}if ({self.text(branch.test)}) {{"
        yield from self._lines(branch.body, depth + 1)
        if len(branch.orelse) == 1 and isinstance(branch.orelse[0], If):
            first, *others = self._branch(branch.orelse[0], depth)
            yield f"{margin}}} else {first.lstrip()}"
            yield from others
            return
        others = list(self._lines(branch.orelse, depth + 1))
        yield from [f"{margin}}} else {{", *others] if others else []
        yield f"{margin}}}"

    def definition(self, function: Function) -> str:
        """Return the definition of a function, with its comment."""
        restrict = "" if self.fixed else "restrict "  # records never change, nor overlap with what does
        declared = [self._declared(argument, restrict) for argument in function.arguments]
        self._used = set()
        lines = [f"    (void){argument.name};" for argument in function.arguments if self.fixed]
        lines += self._lines(function.body, 1)
        # compilers of firmware warn of what is unused
        needless = {f"(void){name};" for name in self._used}
        lines = [line for line in lines if line.lstrip() not in needless]
        head = f"void {function.name}" if function.result is None else self.declaration(function.result, function.name)
        lines[:0] = [f"{'static inline' if self.fixed else 'KERNEL'} {head}({', '.join(declared) or 'void'})", "{"]
        lines.append("}")
        if not self.fixed:
            return "\n".join(lines) + "\n"
        comment = comment_lines(inspect.getdoc(function.kernel.function) or "")
        return comment + "\n".join(part for line in lines for part in wrapped_code(line)) + "\n"


def _rank(node: Node) -> int:
    """Return how tightly the outermost operator of an expression binds."""
    if node.kind == "operator":
        return UNARY if len(node.parts) == 1 else RANKS[node.name]
    if node.kind in ("real", "integer") or (node.kind == "number" and node.constant < 0):
        return UNARY
    return CHOICE if node.kind == "choice" else PRIMARY


def _is_of_constants(node: Node) -> bool:
    inner = node.kind == "operator" and all(map(_is_of_constants, node.parts))
    return inner or node.kind in ("number", "constant")


def _simple(text: str) -> str:
    return text if text.isidentifier() or text.isdigit() else f"({text})"


def _open_name(kind: Array) -> str:
    """Return the name of the struct of arrays whose sizes are known at run time: address and sizes, as in numpy."""
    return f"{kind.element.kind.capitalize()}Array{len(kind.shape)}"
