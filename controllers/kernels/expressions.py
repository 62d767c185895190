"""Expressions of kernels in C: numbers, names, and what all other expressions need."""

import ast
from typing import Any

from controllers.kernels.scope import Scope, Unused
from controllers.kernels.sources import Constant
from controllers.kernels.types import BOOLEAN, INTEGER, REAL, Array, Record, Type, is_within_word, passed_by_pointer
from controllers.kernels.unit import Unit
from controllers.kernels.values import PRIMARY, UNARY, Value


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

    def real(self, node: ast.expr) -> Value:
        """Return an expression as a real number."""
        return self.as_real(node, self.translate(node))

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
        self.scope.lines.append((self.scope.depth, Unused(name)))  # what it is passed to may be known at translation
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
        if isinstance(found, Constant) and isinstance(number, tuple) and not hasattr(number, "_fields"):
            return Value(self.unit.constant_name(found), None, constant=number)
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
