"""Expressions of kernels."""

import ast
import operator
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

from llvmlite import ir

from controllers.kernel_language.body import Body
from controllers.kernel_language.calls import translate_call
from controllers.kernel_language.kinds import (
    BIT,
    BOOLEAN,
    INTEGER,
    REAL,
    WORD,
    Array,
    Line,
    Pointer,
    Record,
    Scalar,
    array_of,
    is_within_word,
    tuple_of,
)
from controllers.kernel_language.meanings import meaning
from controllers.kernel_language.sources import Constant, resolve
from controllers.kernel_language.values import Value, Variable, constant

if TYPE_CHECKING:
    from controllers.kernel_language.unit import Unit

COMPARISONS: dict[type, tuple[str, Callable[[Any, Any], bool]]] = {
    ast.Lt: ("<", operator.lt),
    ast.Gt: (">", operator.gt),
    ast.LtE: ("<=", operator.le),
    ast.GtE: (">=", operator.ge),
    ast.Eq: ("==", operator.eq),
    ast.NotEq: ("!=", operator.ne),
}

ON_INTEGERS: dict[type, tuple[str, Callable[[Any, Any], Any]]] = {
    ast.Add: ("add", operator.add),
    ast.Sub: ("sub", operator.sub),
    ast.Mult: ("mul", operator.mul),
}

ON_REALS: dict[type, str] = {ast.Add: "fadd", ast.Sub: "fsub", ast.Mult: "fmul", ast.Div: "fdiv"}


class Expressions:
    """Translates the expressions of one kernel.

    Parameters
    ----------
    unit : Unit
        Knows the other functions.
    body : Body
        The function of LLVM.

    Attributes
    ----------
    variables : dict
        Variables by their names: where they lie, or the only value that they ever have.
    given : set of str
        Variables that have a value at the present place, by whatever way it is reached.
    stores : Counter
        How many statements give each variable a value.
    counted : Counter
        How many of these are loops that count from zero.
    """

    def __init__(self, unit: "Unit", body: Body) -> None:
        self.unit, self.body, self.kernel = unit, body, body.kernel
        self.variables: dict[str, Variable | Value] = {}
        self.given: set[str] = set()
        names = [node for node in ast.walk(self.kernel.tree) if isinstance(node, ast.Name)]
        self.stores = Counter(node.id for node in names if isinstance(node.ctx, ast.Store))
        self.counted = _counted(self.kernel.tree)

    def translate(self, node: ast.expr) -> Value:
        """Return the value of an expression.

        Raises
        ------
        NotTranslatable
            It has none.
        """
        method = getattr(self, f"_{type(node).__name__.lower()}", None)
        if method is None:
            raise self.refusal(node, f"{ast.unparse(node)!r} has no translation")
        value: Value = method(node)
        return value

    def refusal(self, node: ast.AST, problem: str) -> Exception:
        """Return the error for a node that has no translation."""
        return self.kernel.refusal(node, problem)

    def real(self, node: ast.expr) -> Value:
        """Return the value of an expression as a real number."""
        return self.body.real(node, self.translate(node))

    def condition(self, node: ast.expr) -> Value:
        """Return the value of an expression that must be a truth value."""
        value = self.translate(node)
        if value.kind is not BOOLEAN:
            raise self.refusal(node, f"{ast.unparse(node)} is no truth value; compare it, as in x != 0.0")
        return value

    def known(self, node: ast.AST, found: Any) -> Value:
        """Return a constant of a module as a value."""
        number = found.value if isinstance(found, Constant) else found
        if isinstance(number, tuple) and not hasattr(number, "_fields"):
            return Value(None, constant=number)
        if not isinstance(number, bool | int | float):
            raise self.refusal(node, f"{ast.unparse(node)} is no number; pass it as an argument")
        return self._folded(node, number)

    def _folded(self, node: ast.AST, number: bool | int | float) -> Value:
        if isinstance(number, int) and not is_within_word(number):
            raise self.refusal(node, f"{ast.unparse(node)} is beyond the 64 bits of integers; write a real number")
        return constant(number)

    def _constant(self, node: ast.Constant) -> Value:
        return self.known(node, node.value)

    def _name(self, node: ast.Name) -> Value:
        if self.stores[node.id] and node.id == "_":
            raise self.refusal(node, "_ keeps no value; give the variable a name")
        if self.stores[node.id] and node.id not in self.given:
            raise self.refusal(node, f"{node.id} has no value here; give it one before the branch or loop")
        found = self.variables.get(node.id)
        if isinstance(found, Variable):
            return replace(self.body.read(found.kind, found.place), natural=found.natural)
        if found is not None:
            return found
        return self.known(node, self.resolved(node))

    def resolved(self, node: ast.expr) -> Any:
        """Return what a global name stands for; the machine code holds for no other meaning of it."""
        found = resolve(self.kernel, node)
        function, name = self.kernel.function, ast.unparse(node)
        self.unit.meanings[function.__module__, name] = meaning(function.__globals__, name)
        return found

    def is_global(self, node: ast.expr) -> bool:
        """Tell whether a name, or what a field is asked of, is no variable."""
        while isinstance(node, ast.Attribute | ast.Subscript):
            node = node.value
        return isinstance(node, ast.Name) and node.id not in self.variables and not self.stores[node.id]

    def _attribute(self, node: ast.Attribute) -> Value:
        if self.is_global(node):
            return self.known(node, self.resolved(node))
        if node.attr == "data" and isinstance(node.value, ast.Attribute) and node.value.attr == "ctypes":
            return self._start(node.value)
        owner = self.translate(node.value)
        if isinstance(owner.kind, Array) and node.attr in ("size", "shape"):
            sizes = owner.content[1:]
            return Value(None, sizes, "shape") if node.attr == "shape" else self._product(sizes)
        if not isinstance(owner.kind, Record) or node.attr not in owner.kind.places:
            raise self.refusal(node, f"{ast.unparse(node.value)} has no field {node.attr}")
        return self.body.member(owner, owner.kind.places[node.attr])

    def _start(self, node: ast.Attribute) -> Value:
        owner = self.translate(node.value)
        if not isinstance(owner.kind, Array):
            raise self.refusal(node, f"{ast.unparse(node.value)} is no array")
        return Value(INTEGER, self.body.builder.ptrtoint(owner.content[0], WORD))

    def _product(self, sizes: tuple[Any, ...]) -> Value:
        product = sizes[0]
        for size in sizes[1:]:
            product = self.body.builder.mul(product, size)
        return Value(INTEGER, product, natural=True)

    def indices(self, node: ast.Subscript) -> list[Value]:
        """Return the indices of an element."""
        parts = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        values = [self.translate(part) for part in parts]
        if any(value.kind is not INTEGER for value in values):
            raise self.refusal(node, f"{ast.unparse(node)}: an index must be an integer")
        return values

    def _subscript(self, node: ast.Subscript) -> Value:
        if isinstance(node.slice, ast.Slice):
            raise self.refusal(node, f"{ast.unparse(node)} is a slice; write a loop over a range")
        owner, indices = self.translate(node.value), self.indices(node)
        if isinstance(owner.kind, Array) and len(indices) < owner.kind.ndim:
            row = array_of(owner.kind.element, owner.kind.ndim - len(indices))
            return Value(row, (self.body.address(owner, indices), *owner.content[1 + len(indices) :]))
        if isinstance(owner.kind, Array | Pointer):
            return self.body.read(owner.kind.element, self.place(node, owner, indices))
        if isinstance(owner.kind, Line) and len(indices) == 1:
            return self.body.element(node, owner, indices[0])
        return self._item(node, owner, indices)

    def place(self, node: ast.Subscript, owner: Value, indices: list[Value]) -> Any:
        """Return where an element of an array lies."""
        count = owner.kind.ndim if isinstance(owner.kind, Array) else 1 if isinstance(owner.kind, Pointer) else None
        if len(indices) != count:
            raise self.refusal(node, f"{ast.unparse(node)} is no number of an array; give an index for each dimension")
        return self.body.address(owner, indices)

    def _item(self, node: ast.Subscript, owner: Value, indices: list[Value]) -> Value:
        """Return an item of a record, a shape or a tuple of constants, whose place must be known."""
        items: Any = owner.kind.kinds if isinstance(owner.kind, Record) else ()
        if owner.kind is None:
            items = owner.content or owner.constant or ()
        place = indices[0].constant
        if place is None or len(indices) != 1 or not -len(items) <= place < len(items):
            raise self.refusal(node, f"{ast.unparse(node)} must have one constant place, within what there is")
        if isinstance(owner.kind, Record):
            return self.body.member(owner, place % len(items))
        if owner.constant == "shape":
            return Value(INTEGER, items[place], natural=True)
        return self.known(node, items[place])

    def _binop(self, node: ast.BinOp) -> Value:
        return self.combined(node, node.op, self.translate(node.left), self.translate(node.right))

    def combined(self, node: ast.AST, operation: ast.operator, left: Value, right: Value) -> Value:
        """Return a sum, difference, product, quotient or power."""
        builder, both = self.body.builder, left.kind is right.kind is INTEGER
        if isinstance(operation, ast.Pow):
            return self._power(node, left, right)
        if both and type(operation) in ON_INTEGERS:
            name, fold = ON_INTEGERS[type(operation)]
            if left.constant is not None and right.constant is not None:
                return self._folded(node, fold(left.constant, right.constant))
            natural = left.natural and right.natural and not isinstance(operation, ast.Sub)
            return Value(INTEGER, getattr(builder, name)(left.content, right.content), natural=natural)
        if both and isinstance(operation, ast.FloorDiv | ast.Mod):
            return self._divided(operation, left, right)
        if type(operation) not in ON_REALS:
            raise self.refusal(node, f"{ast.unparse(node)}: there are + - * / and **, and // and % of integers")
        left, right = self.body.real(node, left), self.body.real(node, right)
        return Value(REAL, getattr(builder, ON_REALS[type(operation)])(left.content, right.content))

    def _divided(self, operation: ast.operator, left: Value, right: Value) -> Value:
        """Return quotient or rest of integers, rounded down as in Python; of a division by zero, zero."""
        builder, zero = self.body.builder, ir.Constant(WORD, 0)
        by_zero = builder.icmp_signed("==", right.content, zero)
        least = builder.icmp_signed("==", left.content, ir.Constant(WORD, -(2**63)))
        too_large = builder.and_(least, builder.icmp_signed("==", right.content, ir.Constant(WORD, -1)))
        divisor = builder.select(builder.or_(by_zero, too_large), ir.Constant(WORD, 1), right.content)
        quotient, rest = builder.sdiv(left.content, divisor), builder.srem(left.content, divisor)
        if not (left.natural and right.natural):  # rounded towards zero so far
            signs = builder.icmp_signed("<", builder.xor(rest, divisor), zero)
            down = builder.and_(signs, builder.icmp_signed("!=", rest, zero))
            quotient = builder.select(down, builder.sub(quotient, ir.Constant(WORD, 1)), quotient)
            rest = builder.select(down, builder.add(rest, divisor), rest)
        content = builder.select(by_zero, zero, rest if isinstance(operation, ast.Mod) else quotient)
        natural = right.natural and (left.natural or isinstance(operation, ast.Mod))
        return Value(INTEGER, content, natural=natural)

    def _power(self, node: ast.AST, base: Value, exponent: Value) -> Value:
        if exponent.kind is REAL:
            base = self.body.real(node, base)
            return Value(REAL, self.unit.mathematics(self.body, "pow", base.content, exponent.content))
        if base.kind is not REAL or exponent.constant != 2:
            raise self.refusal(node, f"{ast.unparse(node)}: write out powers other than the second as products")
        return Value(REAL, self.body.builder.fmul(base.content, base.content))

    def _unaryop(self, node: ast.UnaryOp) -> Value:
        builder = self.body.builder
        if isinstance(node.op, ast.Not):
            value = self.condition(node.operand)
            return (
                Value(BOOLEAN, builder.not_(value.content)) if value.constant is None else constant(not value.constant)
            )
        if isinstance(node.op, ast.USub) and isinstance(node.operand, ast.Constant) and type(node.operand.value) is int:
            return self._folded(node, -node.operand.value)
        value = self.translate(node.operand)
        if not isinstance(node.op, ast.USub) or value.kind not in (REAL, INTEGER):
            raise self.refusal(node, f"{ast.unparse(node)} has no translation; write a number or its negative")
        if value.kind is INTEGER:
            known = value.constant is not None
            return self._folded(node, -value.constant) if known else Value(INTEGER, builder.neg(value.content))
        if isinstance(value.content, ir.Constant):
            return constant(-value.content.constant)
        return Value(REAL, builder.fneg(value.content))

    def _boolop(self, node: ast.BoolOp) -> Value:
        conditions = [partial(self.condition, operand) for operand in node.values]
        return self._together(conditions, isinstance(node.op, ast.And))

    def _compare(self, node: ast.Compare) -> Value:
        if any(type(operation) not in COMPARISONS for operation in node.ops):
            raise self.refusal(node, f"{ast.unparse(node)}: there are < > <= >= == and !=")
        values = [self.translate(node.left)]

        def compared(operation: ast.cmpop, operand: ast.expr) -> Value:
            values.append(self.translate(operand))
            return self._comparison(node, operation, *values[-2:])

        pairs = zip(node.ops, node.comparators, strict=True)
        return self._together([partial(compared, *pair) for pair in pairs], conjunction=True)

    def _together(self, conditions: Sequence[Callable[[], Value]], conjunction: bool) -> Value:
        """Return what conditions, joined by and or by or, make; each is computed where those before decide nothing."""
        body, end, value = self.body, None, constant(conjunction)
        decided = []
        for condition in conditions:
            if value.constant is None:
                end = end or body.block()
                following = body.block()
                decided.append(body.builder.block)
                body.builder.cbranch(value.content, *((following, end) if conjunction else (end, following)))
                body.continue_in(following)
            value = condition()
            if value.constant is not None and bool(value.constant) != conjunction:
                break
        if end is None:
            return value
        last = body.builder.block
        body.builder.branch(end)
        body.continue_in(end)
        result = body.builder.phi(BIT)
        for block in decided:
            result.add_incoming(ir.Constant(BIT, int(not conjunction)), block)
        result.add_incoming(value.content, last)
        return Value(BOOLEAN, result)

    def _comparison(self, node: ast.Compare, operation: ast.cmpop, left: Value, right: Value) -> Value:
        sign, compare = COMPARISONS[type(operation)]
        builder = self.body.builder
        if left.kind is not right.kind:
            left, right = self.body.real(node, left), self.body.real(node, right)
        if left.kind is REAL:
            chosen = builder.fcmp_unordered if sign == "!=" else builder.fcmp_ordered
            return Value(BOOLEAN, chosen(sign, left.content, right.content))
        if not isinstance(left.kind, Scalar):
            raise self.refusal(node, f"{ast.unparse(node)} compares what are no numbers")
        if left.constant is not None and right.constant is not None:
            return constant(compare(left.constant, right.constant))
        compare_bits = builder.icmp_unsigned if left.kind is BOOLEAN else builder.icmp_signed  # a bit has no sign
        return Value(BOOLEAN, compare_bits(sign, left.content, right.content))

    def _ifexp(self, node: ast.IfExp) -> Value:
        test = self.condition(node.test)
        if test.constant is not None:
            return self.translate(node.body if test.constant else node.orelse)
        body, parts = self.body, (node.body, node.orelse)
        blocks, end = (body.block(), body.block()), body.block()
        body.builder.cbranch(test.content, *blocks)
        values, ends = [], []
        for part, block in zip(parts, blocks, strict=True):
            body.continue_in(block)
            values.append(self.translate(part))
            ends.append(body.builder.block)
        kind = values[0].kind if values[0].kind is values[1].kind else REAL
        room = None if kind is None or isinstance(kind, Scalar) else body.room(kind)
        for k, part in enumerate(parts):
            body.continue_in(ends[k])
            values[k] = body.like(part, values[k], kind or REAL)
            if room is not None:
                body.write(values[k], room)
            body.builder.branch(end)
        body.continue_in(end)
        assert kind is not None
        if room is not None:
            return body.read(kind, room, not body.repeated)
        result = body.builder.phi(kind.register)  # type: ignore[attr-defined]
        for value, block in zip(values, ends, strict=True):
            result.add_incoming(value.content, block)
        return Value(kind, result, natural=all(value.natural for value in values))

    def _tuple(self, node: ast.Tuple) -> Value:
        items = self.spread(node.elts)
        kinds = [item.kind for item in items if item.kind is not None]
        if len(kinds) < len(items) or not items:
            raise self.refusal(node, f"{ast.unparse(node)}: a tuple must hold numbers, arrays and tuples of them")
        return self.body.record(tuple_of(tuple(kinds)), items)

    def spread(self, nodes: list[ast.expr]) -> list[Value]:
        """Return values of expressions one by one, also of those with a star, which stand for several."""
        values: list[Value] = []
        for node in nodes:
            values += self._items(node.value) if isinstance(node, ast.Starred) else [self.translate(node)]
        return values

    def _items(self, node: ast.expr) -> list[Value]:
        """Return the items of a tuple, or of a slice of one with constant ends."""
        ends: list[int | None] = [None, None]
        if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Slice) and node.slice.step is None:
            for place, end in enumerate((node.slice.lower, node.slice.upper)):
                ends[place] = None if end is None else self.translate(end).constant
                if end is not None and ends[place] is None:
                    raise self.refusal(node, f"{ast.unparse(node)}: the ends of a slice must be constants")
            node = node.value
        return self.items(node, self.translate(node))[slice(*ends)]

    def items(self, node: ast.AST, owner: Value) -> list[Value]:
        """Return all items of a tuple."""
        if not isinstance(owner.kind, Line | Record):
            raise self.refusal(node, f"{ast.unparse(node)} is no tuple")
        count = owner.kind.length if isinstance(owner.kind, Line) else len(owner.kind.kinds)
        return [self.body.member(owner, place) for place in range(count)]

    def _call(self, node: ast.Call) -> Value:
        return translate_call(self, node)


def _counted(tree: ast.FunctionDef) -> Counter[str]:
    loops = [node for node in ast.walk(tree) if isinstance(node, ast.For)]
    return Counter(ast.unparse(loop.target) for loop in loops if _has_one_end(loop.iter))


def _has_one_end(node: ast.expr) -> bool:
    return isinstance(node, ast.Call) and len(node.args) == 1 and not isinstance(node.args[0], ast.Starred)
