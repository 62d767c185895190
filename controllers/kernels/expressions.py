"""Expressions of kernels in C."""

import ast
import operator
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from controllers.kernels.scope import Scope
from controllers.kernels.sources import Constant
from controllers.kernels.subscripts import Subscripts
from controllers.kernels.types import (
    BOOLEAN,
    INTEGER,
    REAL,
    Array,
    Line,
    Record,
    Scalar,
    Type,
    is_within_word,
    passed_by_pointer,
)
from controllers.kernels.values import (
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

if TYPE_CHECKING:
    from controllers.kernels.unit import Unit

ARITHMETIC: dict[type, tuple[str, int, Callable[[Any, Any], Any]]] = {
    ast.Mult: ("*", PRODUCT, operator.mul),
    ast.Div: ("/", PRODUCT, operator.truediv),
    ast.Add: ("+", SUM, operator.add),
    ast.Sub: ("-", SUM, operator.sub),
}
ROUNDED: dict[type, str] = {ast.Mod: "floored_rest", ast.FloorDiv: "floored_quotient"}
COMPARISONS: dict[type, tuple[str, int, Callable[[Any, Any], bool]]] = {
    ast.Lt: ("<", ORDER, operator.lt),
    ast.Gt: (">", ORDER, operator.gt),
    ast.LtE: ("<=", ORDER, operator.le),
    ast.GtE: (">=", ORDER, operator.ge),
    ast.Eq: ("==", EQUALITY, operator.eq),
    ast.NotEq: ("!=", EQUALITY, operator.ne),
}


class Expressions(Subscripts):
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
            raise self.kernel.refusal(node, f"{name} changes arrays in place; give its result a name in a line before")

    def _encloses(self, part: ast.AST, node: ast.AST) -> bool:
        return any(child is node for child in ast.walk(part))

    def translate(self, node: ast.expr) -> Value:
        """Return an expression in C; ``NotTranslatable`` where it has none."""
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
            raise self.kernel.refusal(node, f"{ast.unparse(node)} is no number")
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

    def placed(self, node: ast.AST, value: Value) -> Value:
        """Return a value that is a place in memory, with a name of its own where it was none."""
        if value.root:
            return value
        name = self.hoisted(node, value)
        return Value(name, value.type, root=name, natural=value.natural)

    def _constant(self, node: ast.Constant) -> Value:
        if not isinstance(node.value, bool | int | float):
            raise self.kernel.refusal(node, f"{node.value!r} is no number and has no translation; pass numbers")
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
            problem = f"{ast.unparse(node)} is beyond the 64 bits of integers; write a real number"
            raise self.kernel.refusal(node, problem)

    def _name(self, node: ast.Name) -> Value:
        if self.scope.stores[node.id] and node.id == "_":
            raise self.kernel.refusal(node, "_ keeps no value; give the variable a name")
        if self.scope.stores[node.id] and node.id not in self.scope.given:
            raise self.kernel.refusal(node, f"{node.id} has no value here; give it one before the branch or loop")
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
        if isinstance(found, Constant) and isinstance(number, tuple) and not hasattr(number, "_fields"):
            return Value(self.unit.constant_name(found), None, constant=number)
        if not isinstance(number, bool | int | float):
            raise self.kernel.refusal(node, f"{ast.unparse(node)} is no number; pass it as an argument")
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
            raise self.kernel.refusal(node, f"{ast.unparse(node.value)} has no field {node.attr}") from error

    def _binop(self, node: ast.BinOp) -> Value:
        return self.combined(node, node.op, self.translate(node.left), self.translate(node.right))

    def combined(self, node: ast.AST, operation: ast.operator, left: Value, right: Value) -> Value:
        """Return a sum, difference, product, quotient or power."""
        if isinstance(operation, ast.Pow):
            return self._power(node, left, right)
        both = left.type == right.type == INTEGER
        if type(operation) in ROUNDED and both:
            if left.natural and (right.constant or 0) > 0:  # C rounds to zero, which is down here
                sign, rank, _ = ARITHMETIC[ast.Div]
                sign = sign if isinstance(operation, ast.FloorDiv) else "%"
                return Value(f"{left.within(rank)} {sign} {right.within(rank + 1)}", INTEGER, rank, natural=True)
            text = self.unit.helper(ROUNDED[type(operation)], left.text, right.text)
            natural = right.natural and (left.natural or isinstance(operation, ast.Mod))
            return Value(text, INTEGER, natural=natural)
        if type(operation) not in ARITHMETIC:
            allowed = "+ - * / and **, and // and % of integers; use math on reals"
            raise self.kernel.refusal(node, f"{ast.unparse(node)}: there are {allowed}")
        sign, rank, fold = ARITHMETIC[type(operation)]
        if both and sign != "/":
            text = f"{left.within(rank)} {sign} {right.within(rank + 1)}"
            natural = left.natural and right.natural and sign != "-"
            if left.constant is None or right.constant is None:
                return Value(text, INTEGER, rank, natural=natural)
            result = fold(left.constant, right.constant)
            self._check_word(node, result)
            named = not (left.text + right.text).isdigit()
            known = self._literal(node, result)
            return Value(text, INTEGER, rank, result, natural=result >= 0) if named else known
        left, right = self.as_real(node, left), self.as_real(node, right)
        # C and Python both group from the left; parentheses keep the grouping of the tree exactly
        return Value(f"{left.within(rank)} {sign} {right.within(rank + 1)}", REAL, rank)

    def _power(self, node: ast.AST, base: Value, exponent: Value) -> Value:
        if exponent.type == INTEGER:
            if base.type != REAL or exponent.constant != 2:
                problem = f"{ast.unparse(node)}: write out powers other than the second as products"
                raise self.kernel.refusal(node, problem)
            return Value(self.unit.helper("square", base.text), REAL)
        base, exponent = self.as_real(node, base), self.as_real(node, exponent)
        return Value(self.unit.library("pow", base.text, exponent.text), REAL)

    def _unaryop(self, node: ast.UnaryOp) -> Value:
        if isinstance(node.op, ast.Not):
            value = self.condition(node.operand)
            known = None if value.constant is None else not value.constant
            return Value(f"!{value.within(UNARY)}", BOOLEAN, UNARY, known)
        if isinstance(node.op, ast.USub) and isinstance(node.operand, ast.Constant) and type(node.operand.value) is int:
            return self._literal(node, -node.operand.value)
        value = self.translate(node.operand)
        if not isinstance(node.op, ast.USub) or value.type not in (REAL, INTEGER):
            raise self.kernel.refusal(node, f"{ast.unparse(node)} has no translation; write a number or its negative")
        known = None if value.constant is None else -value.constant
        if known is not None and value.type == INTEGER:
            self._check_word(node, known)
        natural = value.type == INTEGER and known is not None and known >= 0
        return Value(f"-{value.within(UNARY + 1)}", value.type, UNARY, known, natural=natural)

    def _boolop(self, node: ast.BoolOp) -> Value:
        conjunction = isinstance(node.op, ast.And)
        sign, rank = ("&&", CONJUNCTION) if conjunction else ("||", DISJUNCTION)
        values = []
        for place, operand in enumerate(node.values):
            self.scope.conditional += place > 0
            value = self.condition(operand)
            self.scope.conditional -= place > 0
            if value.constant is None:
                values.append(value)
            elif bool(value.constant) != conjunction:  # decides it, whatever stands to the left: that has no effects
                return self._literal(node, bool(value.constant))
        if not values:
            return self._literal(node, conjunction)
        if len(values) == 1:
            return values[0]
        inner = [value.within(ORDER - 1 if value.rank in (CONJUNCTION, DISJUNCTION) else rank) for value in values]
        return Value(f" {sign} ".join(inner), BOOLEAN, rank)

    def _compare(self, node: ast.Compare) -> Value:
        if any(type(operation) not in COMPARISONS for operation in node.ops):
            raise self.kernel.refusal(node, f"{ast.unparse(node)}: there are < > <= >= == and !=")
        parts, known = [], []
        right = self.translate(node.left)
        for place, (operation, item) in enumerate(zip(node.ops, node.comparators, strict=True)):
            left, writes = right, self.scope.writes
            self.scope.conditional += place > 0
            right = self.translate(item)
            if place + 1 < len(node.ops) and self.scope.writes > writes:
                right = self.placed(item, right)  # it is compared twice, and changes something once
            self.scope.conditional -= place > 0
            text, decided = self._comparison(node, operation, left, right)
            parts.append(text)
            known.append(decided)
        if None not in known:
            return self._literal(node, all(known))
        rank = COMPARISONS[type(node.ops[0])][1] if len(parts) == 1 else CONJUNCTION
        return Value(" && ".join(parts), BOOLEAN, rank)

    def _comparison(
        self, node: ast.Compare, operation: ast.cmpop, left: Value, right: Value
    ) -> tuple[str, bool | None]:
        """Return two values compared in C, and what comes of it where that is known."""
        sign, rank, compare = COMPARISONS[type(operation)]
        decided = None
        if {left.type, right.type} <= {INTEGER, REAL} and None not in (left.constant, right.constant):
            decided = compare(left.constant, right.constant)
        if left.type != right.type:
            left, right = self.as_real(node, left), self.as_real(node, right)
        if not isinstance(left.type, Scalar):
            raise self.kernel.refusal(node, f"{ast.unparse(node)} compares what are no numbers")
        return f"{left.within(rank + 1)} {sign} {right.within(rank + 1)}", decided

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
        natural = first.natural and second.natural
        return Value(f"{test.within(CHOICE + 1)} ? {texts[0]} : {texts[1]}", first.type, CHOICE, natural=natural)

    def _tuple(self, node: ast.Tuple) -> Value:
        """Return a tuple of values of one type; those that a function returns are made by its return statement."""
        values = self.spread(node.elts)
        kinds = {value.type for value in values}
        if len(kinds) != 1 or None in kinds:
            raise self.kernel.refusal(
                node, f"{ast.unparse(node)}: a tuple must hold values of one type; use a NamedTuple"
            )
        kind = kinds.pop()
        assert kind is not None
        line = Line(kind, len(values))
        return Value(f"({self.unit.c_type(line)}){{{{{', '.join(value.content for value in values)}}}}}", line)

    def _call(self, node: ast.Call) -> Value:
        return self.unit.calls.translate(self, node)

    def passed(self, node: ast.AST, value: Value) -> str:
        """Return a value as an argument."""
        kind: Type | None = value.type
        if kind is None:
            raise self.kernel.refusal(node, f"{value.text} cannot be passed; pass its elements")
        return self.address(node, value) if passed_by_pointer(kind) else value.content
