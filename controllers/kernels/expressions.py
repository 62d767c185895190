"""Expressions of kernels in C: numbers, names, what stands behind a dot or in brackets, and what all others need."""

import ast
from typing import Any

from controllers.kernels.scope import Later, Scope
from controllers.kernels.sources import Constant
from controllers.kernels.types import (
    BOOLEAN,
    INTEGER,
    REAL,
    Array,
    Line,
    Record,
    Type,
    is_within_word,
    passed_by_pointer,
)
from controllers.kernels.unit import Unit
from controllers.kernels.values import PRIMARY, PRODUCT, UNARY, Value


class Expressions:
    """Translates the expressions of one function."""

    def __init__(self, unit: Unit, scope: Scope) -> None:
        self.unit = unit
        self.scope = scope
        self.kernel = scope.kernel
        self.refusal = scope.kernel.refusal
        self._reading: list[ast.AST] = []
        self._ordered: set[int] = set()

    def open_statement(self, statement: ast.stmt) -> None:
        """Note what a statement reads and calls: C leaves open in which order parts of an expression are computed."""
        self._reading = [node for node in ast.walk(statement) if isinstance(node, ast.Call | ast.Subscript)]
        self._ordered = set()
        in_place = isinstance(statement, ast.AugAssign) and isinstance(statement.target, ast.Subscript)
        open_parts: list[ast.AST | None] = [None if in_place else getattr(statement, "value", None)]
        while open_parts:  # what and, or and not join is computed in the order of Python
            node = open_parts.pop()
            self._ordered.add(id(node))
            open_parts += node.values if isinstance(node, ast.BoolOp) else []
            open_parts += [node.operand] if isinstance(node, ast.UnaryOp) else []

    def check_order(self, node: ast.Call, name: str) -> None:
        """Refuse a call that changes arrays in the midst of an expression that reads elements or calls others."""
        own = {id(part) for part in ast.walk(node)}
        others = [part for part in self._reading if id(part) not in own and not self._encloses(part, node)]
        if id(node) not in self._ordered and others:
            raise self.refusal(node, f"{name} changes arrays in place; give its result a name in a line before")

    def _encloses(self, part: ast.AST, node: ast.AST) -> bool:
        return any(child is node for child in ast.walk(part))

    def translate(self, node: ast.expr) -> Value:
        """Return an expression in C; ``NotTranslatable`` where it has none."""
        method = getattr(self, f"_{type(node).__name__.lower()}", None)
        if method is None:
            allowed = "numbers, names, fields, elements, + - * / **, comparisons, and/or/not, if-else and calls"
            raise self.refusal(node, f"{ast.unparse(node)!r} has no translation; use {allowed}")
        value: Value = method(node)
        return value

    def as_real(self, node: ast.AST, value: Value) -> Value:
        """Return a number as a real one; an integer is converted explicitly."""
        if value.type == REAL:
            return value
        if value.type != INTEGER:
            raise self.refusal(node, "{} is no number")
        if value.constant is not None and value.text.lstrip("-").isdigit():
            return Value(self.unit.precision.literal(float(value.constant)), REAL, value.rank)
        return Value(f"({self.unit.precision.real}){value.within(UNARY)}", REAL, UNARY)

    def condition(self, node: ast.expr) -> Value:
        """Return an expression that must be a truth value."""
        value = self.translate(node)
        if value.type != BOOLEAN:
            raise self.refusal(node, "{} is no truth value; compare it, as in x != 0.0")
        return value

    def address(self, node: ast.AST, value: Value) -> str:
        """Return a pointer to a record; what is no place in memory gets one."""
        if value.pointer:
            return value.text
        if value.root:
            return f"&{value.within(UNARY)}"
        return f"&{self.hoisted(node, value)}"

    def hoisted(self, node: ast.AST, value: Value) -> str:
        """Give a value a name on a line of its own before the statement; return the name."""
        if self.scope.conditional:
            raise self.refusal(
                node, f"{value.text} stands where it may not be computed; give it a name in a line before"
            )
        kind = value.type
        wish = kind.name.lower() if isinstance(kind, Record) else "value"
        name = self.scope.fresh(wish.rpartition("_")[2] if wish.endswith("_result") else wish)
        assert kind is not None
        constant = "" if isinstance(kind, Array) else "const "
        self.scope.emit(f"{constant}{self.unit.declaration(kind, name)} = {value.content};")
        # what it is passed to may be known at translation
        self.scope.lines.append((self.scope.depth, Later(name, declares=False)))
        return name

    def placed(self, node: ast.AST, value: Value) -> Value:
        """Return a value that is a place in memory, with a name of its own where it was none."""
        return value if value.root else self.named(node, value)

    def named(self, node: ast.AST, value: Value) -> Value:
        """Return a value under a name of its own."""
        name = self.hoisted(node, value)
        return Value(name, value.type, root=name, natural=value.natural)

    def passed(self, node: ast.AST, value: Value) -> str:
        """Return a value as an argument."""
        kind: Type | None = value.type
        if kind is None:
            raise self.refusal(node, f"{value.text} cannot be passed; pass its elements")
        return self.address(node, value) if passed_by_pointer(kind) else value.content

    def _constant(self, node: ast.Constant) -> Value:
        if not isinstance(node.value, bool | int | float):
            raise self.refusal(node, f"{node.value!r} is no number and has no translation; pass numbers")
        where = f"{self.kernel.path}:{node.lineno}: {node.value}"
        return self._literal(node, node.value, where)

    def _literal(self, node: ast.AST, number: bool | int | float, where: str = "a number") -> Value:
        if isinstance(number, bool):
            return Value(self.unit.precision.literal(number), BOOLEAN, constant=number)
        if isinstance(number, int):
            self._check_word(node, number)
            number = int(number)
            rank = UNARY if number < 0 else PRIMARY
            return Value(self.unit.precision.literal(number), INTEGER, rank, number, natural=number >= 0)
        return Value(self.unit.precision.literal(float(number), where), REAL, constant=number)

    def _check_word(self, node: ast.AST, number: int) -> None:
        if not is_within_word(number):
            raise self.refusal(node, "{} is beyond the 64 bits of integers; write a real number")

    def _name(self, node: ast.Name) -> Value:
        if self.scope.stores[node.id] and node.id == "_":
            raise self.refusal(node, "_ keeps no value; give the variable a name")
        if self.scope.stores[node.id] and node.id not in self.scope.given:
            raise self.refusal(node, f"{node.id} has no value here; give it one before the branch or loop")
        if node.id in self.scope.variables:
            return self.scope.value(node.id)
        return self.known(node, self.unit.resolved(self.kernel, node))

    def is_global(self, node: ast.expr) -> bool:
        """Tell whether an expression is a name of the module, or a member of what is one."""
        while isinstance(node, ast.Attribute):
            node = node.value
        is_name = isinstance(node, ast.Name)
        return is_name and node.id not in self.scope.variables and not self.scope.stores[node.id]  # type: ignore[attr-defined]

    def known(self, node: ast.AST, found: Any) -> Value:
        """Return a constant of a module."""
        number = found.value if isinstance(found, Constant) else found
        if not isinstance(number, bool | int | float):
            raise self.refusal(node, "{} is no number; pass it as an argument")
        if not isinstance(found, Constant):
            return self._literal(node, number)
        kind = BOOLEAN if isinstance(number, bool) else INTEGER if isinstance(number, int) else REAL
        if kind == INTEGER:
            self._check_word(node, number)  # type: ignore[arg-type]
        folded = number if kind != REAL else None
        natural = kind == INTEGER and number >= 0
        return Value(self.unit.constant_name(found), kind, constant=folded, natural=natural)

    def _attribute(self, node: ast.Attribute) -> Value:
        if self.is_global(node):
            return self.known(node, self.unit.resolved(self.kernel, node))
        owner = self.translate(node.value)
        if isinstance(owner.type, Array) and node.attr in ("size", "shape"):
            return self.extent(owner, node.attr)
        try:
            return owner.member(node.attr)
        except (TypeError, KeyError) as error:
            raise self.refusal(node, f"{ast.unparse(node.value)} has no field {node.attr}") from error

    def extent(self, owner: Value, attribute: str) -> Value:
        """Return ``size`` or ``shape`` of an array."""
        sizes = [owner.size(axis) for axis in range(len(owner.array.shape))]
        if attribute == "shape":
            return Value("", None, constant=tuple(sizes))
        if owner.array.is_open:
            rank = PRIMARY if len(sizes) == 1 else PRODUCT
            return Value(" * ".join(size.text for size in sizes), INTEGER, rank, natural=True)
        count = 1
        for size in sizes:
            count *= size.constant
        return Value(str(count), INTEGER, constant=count, natural=True)

    def _subscript(self, node: ast.Subscript) -> Value:
        return self.element_of(node, self.translate(node.value))

    def element_of(self, node: ast.Subscript, owner: Value) -> Value:
        """Return the element that a subscript takes out of what stands before it."""
        indices = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        if any(isinstance(index, ast.Slice) for index in indices):
            raise self.refusal(node, "{} is a slice; write a loop over a range")
        for index in indices:
            owner = self._element(node, owner, index)
        return owner

    def _element(self, node: ast.Subscript, owner: Value, index: ast.expr) -> Value:
        place = self.translate(index)
        if place.type != INTEGER:
            raise self.refusal(node, f"index {ast.unparse(index)} must be an integer")
        if owner.type is None or isinstance(owner.type, Record):
            return self._item(node, owner, place)
        if not isinstance(owner.type, Line | Array):
            raise self.refusal(node, "{}: there are no elements in a number")
        if not owner.root and (isinstance(owner.type, Line) or len(owner.type.shape) > 1):
            owner = self.placed(node, owner)
        return owner.element(self._from_start(node, owner, place))

    def _from_start(self, node: ast.Subscript, owner: Value, place: Value) -> str:
        """Return an index, which counts from the end where it is negative, from the start."""
        is_line = isinstance(owner.type, Line)
        size = Value("", INTEGER, constant=owner.type.length) if is_line else owner.size(0)  # type: ignore[union-attr]
        length = size.constant
        if place.constant is None:
            if is_line and length == 1 and not self.unit.fixed:
                return "0"  # a computed place would keep compilers from making registers of all around it
            if place.natural:
                return place.text
            return self.unit.helper("from_start", place.text, size.text or str(length))
        if length is not None and not -length <= place.constant < length:
            raise self.refusal(node, f"{{}} is outside of its {length} elements")
        if place.constant >= 0:
            return place.text
        return f"{size.text} - {-place.constant}" if length is None else str(length + place.constant)

    def _item(self, node: ast.Subscript, owner: Value, place: Value) -> Value:
        """Return an item of a shape or a record, whose place must be known."""
        items = owner.type.fields if isinstance(owner.type, Record) else owner.constant or ()
        if place.constant is None or not -len(items) <= place.constant < len(items):
            raise self.refusal(node, f"{{}} must have one constant place, within its {len(items)} items")
        item: Any = items[place.constant]
        found: Value = owner.member(item[0]) if isinstance(owner.type, Record) else item
        return found

    def spread(self, nodes: list[ast.expr]) -> list[Value]:
        """Return values of expressions one by one, also of those with a star, which stand for several."""
        values: list[Value] = []
        for node in nodes:
            values += self._spread(node.value) if isinstance(node, ast.Starred) else [self.translate(node)]
        return values

    def _spread(self, node: ast.expr) -> list[Value]:
        """Return the elements of a tuple, or of a slice of one with constant ends."""
        ends: list[int | None] = [None, None]
        if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Slice) and node.slice.step is None:
            for place, end in enumerate((node.slice.lower, node.slice.upper)):
                ends[place] = None if end is None else self.translate(end).constant
                if end is not None and ends[place] is None:
                    raise self.refusal(node, "{}: the ends of a slice must be constants")
            node = node.value
        return self.items(node, self.translate(node))[slice(*ends)]

    def items(self, node: ast.AST, owner: Value) -> list[Value]:
        """Return all items of a tuple."""
        if not isinstance(owner.type, Line | Record):
            raise self.refusal(node, "{} is no tuple")
        owner = self.placed(node, owner)
        if isinstance(owner.type, Record):
            return [owner.member(name) for name, _ in owner.type.fields]
        return [owner.element(str(place)) for place in range(owner.type.length)]  # type: ignore[union-attr]

    def _tuple(self, node: ast.Tuple) -> Value:
        """Return a tuple of values of one type; those that a function returns are made by its return statement."""
        values = self.spread(node.elts)
        kinds = {value.type for value in values}
        if len(kinds) != 1 or None in kinds:
            raise self.refusal(node, "{}: a tuple must hold values of one type; use a NamedTuple")
        kind = kinds.pop()
        assert kind is not None
        line = Line(kind, len(values))
        return Value(f"({self.unit.c_type(line)}){{{{{', '.join(value.content for value in values)}}}}}", line)
