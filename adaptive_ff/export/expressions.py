"""Expressions of kernels in C."""

import ast
from typing import TYPE_CHECKING, Any

from adaptive_ff.export.scope import Scope
from adaptive_ff.export.types import BOOLEAN, INTEGER, REAL, Array, Line, Record, Scalar, Type, passed_by_pointer
from adaptive_ff.export.values import (
    CHOICE,
    CONJUNCTION,
    DISJUNCTION,
    EQUALITY,
    ORDER,
    PRIMARY,
    PRODUCT,
    SUM,
    UNARY,
    Value,
)
from controllers.kernel_language.sources import Constant, resolve

if TYPE_CHECKING:
    from adaptive_ff.export.unit import Unit

ARITHMETIC: dict[type, tuple[str, int]] = {
    ast.Mult: ("*", PRODUCT),
    ast.Div: ("/", PRODUCT),
    ast.Add: ("+", SUM),
    ast.Sub: ("-", SUM),
}
ROUNDED: dict[type, str] = {ast.Mod: "floored_rest", ast.FloorDiv: "floored_quotient"}
COMPARISONS: dict[type, tuple[str, int]] = {
    ast.Lt: ("<", ORDER),
    ast.Gt: (">", ORDER),
    ast.LtE: ("<=", ORDER),
    ast.GtE: (">=", ORDER),
    ast.Eq: ("==", EQUALITY),
    ast.NotEq: ("!=", EQUALITY),
}
COMPARED = {
    "<": lambda a, b: a < b,
    ">": lambda a, b: a > b,
    "<=": lambda a, b: a <= b,
    ">=": lambda a, b: a >= b,
    "==": lambda a, b: a == b,
    "!=": lambda a, b: a != b,
}
COMBINED = {"+": lambda a, b: a + b, "-": lambda a, b: a - b, "*": lambda a, b: a * b}


class Expressions:
    """Translates the expressions of one function.

    Parameters
    ----------
    unit : Unit
        Knows structs, constants and the other functions.
    scope : Scope
        Variables of the function.
    """

    def __init__(self, unit: "Unit", scope: Scope) -> None:
        self.unit = unit
        self.scope = scope
        self.kernel = scope.kernel
        self._reading: list[ast.AST] = []
        self._ordered: set[int] = set()

    def open_statement(self, statement: ast.stmt) -> None:
        """Note what a statement reads and calls: C leaves open in which order parts of an expression are computed."""
        self._reading = [node for node in ast.walk(statement) if isinstance(node, ast.Call | ast.Subscript)]
        self._ordered = set()
        open_parts: list[ast.AST | None] = [getattr(statement, "value", None)]
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
            raise self.kernel.refusal(node, f"{name} changes arrays in place; give its result a name in a line before")

    def _encloses(self, part: ast.AST, node: ast.AST) -> bool:
        return any(child is node for child in ast.walk(part))

    def translate(self, node: ast.expr) -> Value:
        """Return an expression in C; ``NotExportable`` where it has none."""
        method = getattr(self, f"_{type(node).__name__.lower()}", None)
        if method is None:
            allowed = "numbers, names, fields, elements, + - * / **, comparisons, and/or/not, if-else and calls"
            raise self.kernel.refusal(node, f"{ast.unparse(node)!r} has no translation; use {allowed}")
        value: Value = method(node)
        return value

    def real(self, node: ast.expr) -> Value:
        """Return an expression as a real number."""
        return self.as_real(node, self.translate(node))

    def as_real(self, node: ast.AST, value: Value) -> Value:
        """Return a number as a real one; an integer is converted explicitly."""
        if value.type == REAL:
            return value
        if value.type != INTEGER:
            raise self.kernel.refusal(node, f"{value.text} is no number")
        if value.constant is not None and value.text.lstrip("-").isdigit():
            return Value(self.unit.precision.literal(float(value.constant)), REAL, value.rank)
        return Value(f"({self.unit.precision.real}){value.within(UNARY)}", REAL, UNARY)

    def condition(self, node: ast.expr) -> Value:
        """Return an expression that must be a truth value."""
        value = self.translate(node)
        if value.type != BOOLEAN:
            raise self.kernel.refusal(node, f"{ast.unparse(node)} is no truth value; compare it, as in x != 0.0")
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
            raise self.kernel.refusal(
                node, f"{value.text} stands where it may not be computed; give it a name in a line before"
            )
        kind = value.type
        wish = kind.name.lower() if isinstance(kind, Record) else "value"
        name = self.scope.fresh(wish.rpartition("_")[2] if wish.endswith("_result") else wish)
        assert kind is not None
        constant = "" if isinstance(kind, Array) else "const "
        self.scope.emit(f"{constant}{self.unit.declaration(kind, name)} = {value.content};")
        self.scope.note_declaration(name)  # what it is passed to may be known at translation
        return name

    def _constant(self, node: ast.Constant) -> Value:
        if not isinstance(node.value, bool | int | float):
            raise self.kernel.refusal(node, f"{node.value!r} has no translation; use numbers and truth values")
        kind = BOOLEAN if isinstance(node.value, bool) else INTEGER if isinstance(node.value, int) else REAL
        where = f"{self.kernel.path}:{node.lineno}: {node.value}"
        return Value(self.unit.precision.literal(node.value, where), kind, constant=node.value)

    def _name(self, node: ast.Name) -> Value:
        if node.id in self.scope.variables:
            return self.scope.value(node.id)
        if self.scope.stores[node.id]:
            raise self.kernel.refusal(node, f"{node.id} has no value here; give it one before the branch or loop")
        return self.known(node, resolve(self.kernel, node))

    def known(self, node: ast.AST, found: Any) -> Value:
        """Return a constant of a module."""
        if isinstance(found, Constant) and isinstance(found.value, tuple):
            return Value(self.unit.constant_name(found), None, constant=found.value)
        value = found.value if isinstance(found, Constant) else found
        if not isinstance(value, bool | int | float):
            raise self.kernel.refusal(node, f"{ast.unparse(node)} is no number; pass it as an argument")
        kind = BOOLEAN if isinstance(value, bool) else INTEGER if isinstance(value, int) else REAL
        if not isinstance(found, Constant):
            return Value(self.unit.precision.literal(value), kind, constant=value)
        folded = value if kind != REAL else None
        return Value(self.unit.constant_name(found), kind, constant=folded)

    def _attribute(self, node: ast.Attribute) -> Value:
        base = node.value
        while isinstance(base, ast.Attribute | ast.Subscript):
            base = base.value
        if isinstance(base, ast.Name) and base.id not in self.scope.variables and not self.scope.stores[base.id]:
            return self.known(node, resolve(self.kernel, node))
        owner = self.translate(node.value)
        if isinstance(owner.type, Array) and node.attr in ("size", "shape"):
            shape = owner.type.shape
            if node.attr == "shape":
                return Value("", None, constant=shape)
            size = 1
            for extent in shape:
                size *= extent
            return Value(str(size), INTEGER, constant=size)
        try:
            return owner.member(node.attr)
        except (TypeError, KeyError) as error:
            raise self.kernel.refusal(node, f"{ast.unparse(node.value)} has no field {node.attr}") from error

    def _subscript(self, node: ast.Subscript) -> Value:
        return self.element_of(node, self.translate(node.value))

    def element_of(self, node: ast.Subscript, owner: Value) -> Value:
        """Return the element that a subscript takes out of what stands before it."""
        indices = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        if any(isinstance(index, ast.Slice) for index in indices):
            raise self.kernel.refusal(node, f"{ast.unparse(node)} is a slice; write a loop over a range")
        for index in indices:
            owner = self._element(node, owner, index)
        return owner

    def _element(self, node: ast.Subscript, owner: Value, index: ast.expr) -> Value:
        place = self.translate(index)
        if place.type != INTEGER:
            raise self.kernel.refusal(node, f"index {ast.unparse(index)} must be an integer")
        if owner.type is None or isinstance(owner.type, Record):
            return self._item(node, owner, place)
        length = owner.type.length if isinstance(owner.type, Line) else self._extent(node, owner)
        text = place.text
        if place.constant is not None:
            if not -length <= place.constant < length:
                raise self.kernel.refusal(node, f"{ast.unparse(node)} is outside of its {length} elements")
            text = text if place.constant >= 0 else str(length + place.constant)
        if not owner.root and isinstance(owner.type, Line):
            name = self.hoisted(node, owner)
            owner = Value(name, owner.type, root=name)
        return owner.element(text)

    def _extent(self, node: ast.AST, owner: Value) -> int:
        if not isinstance(owner.type, Array) or not owner.type.shape:
            raise self.kernel.refusal(node, f"{owner.text} has no elements")
        return owner.type.shape[0]

    def _item(self, node: ast.AST, owner: Value, place: Value) -> Value:
        """Return an item of a tuple of constants, a shape or a record, whose place must be known."""
        if place.constant is None:
            raise self.kernel.refusal(node, f"the place {place.text} in {owner.text or 'a shape'} must be a constant")
        if isinstance(owner.type, Record):
            return owner.member(owner.type.fields[place.constant][0])
        item = owner.constant[place.constant]
        number = place.constant % len(owner.constant)
        kind = INTEGER if isinstance(item, int) else REAL
        text = f"{owner.text}_{number}" if owner.text else str(item)
        return Value(text, kind, constant=item if kind == INTEGER else None)

    def _binop(self, node: ast.BinOp) -> Value:
        if isinstance(node.op, ast.Pow):
            return self._power(node)
        left, right = self.translate(node.left), self.translate(node.right)
        if type(node.op) in ROUNDED and left.type == right.type == INTEGER:
            return Value(self.unit.helper(ROUNDED[type(node.op)], left.text, right.text), INTEGER)
        if type(node.op) not in ARITHMETIC:
            allowed = "+ - * / and **, and // and % of integers; use math on reals"
            raise self.kernel.refusal(node, f"{ast.unparse(node)}: there are {allowed}")
        operator, rank = ARITHMETIC[type(node.op)]
        if left.type == right.type == INTEGER and operator != "/":
            text = f"{left.within(rank)} {operator} {right.within(rank + 1)}"
            if left.constant is None or right.constant is None:
                return Value(text, INTEGER, rank)
            result = COMBINED[operator](left.constant, right.constant)
            named = not (left.text + right.text).isdigit()
            return Value(text if named else str(result), INTEGER, rank if named else PRIMARY, result)
        left, right = self.as_real(node.left, left), self.as_real(node.right, right)
        # C and Python both group from the left; parentheses keep the grouping of the tree exactly
        return Value(f"{left.within(rank)} {operator} {right.within(rank + 1)}", REAL, rank)

    def _power(self, node: ast.BinOp) -> Value:
        base, exponent = self.real(node.left), self.translate(node.right)
        if exponent.type == INTEGER and exponent.constant == 2:
            return Value(self.unit.helper("square", base.text), REAL)
        if exponent.type == INTEGER:
            raise self.kernel.refusal(node, f"{ast.unparse(node)}: write out powers other than the second as products")
        return Value(self.unit.library("pow", base.text, exponent.text), REAL)

    def _unaryop(self, node: ast.UnaryOp) -> Value:
        if isinstance(node.op, ast.Not):
            value = self.condition(node.operand)
            known = None if value.constant is None else not value.constant
            return Value(f"!{value.within(UNARY)}", BOOLEAN, UNARY, known)
        value = self.translate(node.operand)
        if isinstance(node.op, ast.UAdd) or value.type not in (REAL, INTEGER):
            raise self.kernel.refusal(node, f"{ast.unparse(node)} has no translation; write a number or its negative")
        known = None if value.constant is None else -value.constant
        return Value(f"-{value.within(UNARY + 1)}", value.type, UNARY, known)

    def _boolop(self, node: ast.BoolOp) -> Value:
        conjunction = isinstance(node.op, ast.And)
        operator, rank = ("&&", CONJUNCTION) if conjunction else ("||", DISJUNCTION)
        values = []
        for place, operand in enumerate(node.values):
            self.scope.conditional += place > 0
            value = self.condition(operand)
            self.scope.conditional -= place > 0
            if value.constant is None:
                values.append(value)
            elif bool(value.constant) != conjunction:  # decides it, whatever stands to the left: that has no effects
                return Value("true" if value.constant else "false", BOOLEAN, constant=bool(value.constant))
        if not values:
            return Value("true" if conjunction else "false", BOOLEAN, constant=conjunction)
        if len(values) == 1:
            return values[0]
        inner = [value.within(ORDER - 1 if value.rank in (CONJUNCTION, DISJUNCTION) else rank) for value in values]
        return Value(f" {operator} ".join(inner), BOOLEAN, rank)

    def _compare(self, node: ast.Compare) -> Value:
        nodes = [node.left, *node.comparators]
        values = [self.translate(item) for item in nodes]
        parts, known = [], []
        for place, operation in enumerate(node.ops):
            if type(operation) not in COMPARISONS:
                raise self.kernel.refusal(node, f"{ast.unparse(node)}: there are < > <= >= == and !=")
            operator, rank = COMPARISONS[type(operation)]
            left, right = values[place], values[place + 1]
            known.append(
                COMPARED[operator](left.constant, right.constant)
                if left.type == right.type == INTEGER and left.constant is not None and right.constant is not None
                else None
            )
            if left.type != right.type:
                left, right = self.as_real(node, left), self.as_real(node, right)
            if not isinstance(left.type, Scalar):
                raise self.kernel.refusal(node, f"{ast.unparse(node)} compares what are no numbers")
            parts.append(f"{left.within(rank + 1)} {operator} {right.within(rank + 1)}")
        if None not in known:
            return Value("true" if all(known) else "false", BOOLEAN, constant=all(known))
        rank = COMPARISONS[type(node.ops[0])][1] if len(parts) == 1 else CONJUNCTION
        return Value(" && ".join(parts), BOOLEAN, rank)

    def _ifexp(self, node: ast.IfExp) -> Value:
        test = self.condition(node.test)
        if test.constant is not None:
            return self.translate(node.body if test.constant else node.orelse)
        self.scope.conditional += 1
        first, second = self.translate(node.body), self.translate(node.orelse)
        self.scope.conditional -= 1
        if first.type != second.type:
            first, second = self.as_real(node.body, first), self.as_real(node.orelse, second)
        texts = [f"({value.content})" if value.rank <= CHOICE else value.content for value in (first, second)]
        return Value(f"{test.within(CHOICE + 1)} ? {texts[0]} : {texts[1]}", first.type, CHOICE)

    def _tuple(self, node: ast.Tuple) -> Value:
        """Return a tuple of values of one type; those that a function returns are made by its return statement."""
        values: list[Value] = []
        for item in node.elts:
            values += self._spread(item.value) if isinstance(item, ast.Starred) else [self.translate(item)]
        kinds = {value.type for value in values}
        if len(kinds) != 1 or None in kinds:
            raise self.kernel.refusal(
                node, f"{ast.unparse(node)}: a tuple must hold values of one type; use a NamedTuple"
            )
        kind = kinds.pop()
        assert kind is not None
        line = Line(kind, len(values))
        return Value(f"({self.unit.c_type(line)}){{{{{', '.join(value.content for value in values)}}}}}", line)

    def _spread(self, node: ast.expr) -> list[Value]:
        """Return the elements of a tuple, or of a slice of one with constant ends."""
        ends: list[int | None] = [None, None]
        if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Slice) and node.slice.step is None:
            for place, end in enumerate((node.slice.lower, node.slice.upper)):
                ends[place] = None if end is None else self.translate(end).constant
                if end is not None and ends[place] is None:
                    raise self.kernel.refusal(node, f"{ast.unparse(node)}: the ends of a slice must be constants")
            node = node.value
        owner = self.translate(node)
        if isinstance(owner.type, Record):
            return [owner.member(name) for name, _ in owner.type.fields][slice(*ends)]
        if not isinstance(owner.type, Line):
            raise self.kernel.refusal(node, f"*{ast.unparse(node)}: only a tuple can be spread")
        return [owner.element(str(place)) for place in range(owner.type.length)][slice(*ends)]

    def _call(self, node: ast.Call) -> Value:
        return self.unit.calls.translate(self, node)

    def passed(self, node: ast.AST, value: Value) -> str:
        """Return a value as an argument."""
        kind: Type | None = value.type
        if kind is None:
            raise self.kernel.refusal(node, f"{value.text} cannot be passed; pass its elements")
        return self.address(node, value) if passed_by_pointer(kind) else value.content
