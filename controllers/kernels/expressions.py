"""Expressions of kernels, read into a typed tree: names, numbers, elements, operators."""

import ast
import math
import operator
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from controllers.kernels.record import meaning
from controllers.kernels.sources import Constant, Kernel, resolve
from controllers.kernels.text import RESERVED
from controllers.kernels.tree import Function, Let, Node, Statement, Variable, number
from controllers.kernels.types import BOOLEAN, INTEGER, REAL, Array, Line, Record, Scalar, Symbols, Type, is_within_word

ARITHMETIC: dict[type, tuple[str, Callable[[Any, Any], Any]]] = {
    ast.Mult: ("*", operator.mul),
    ast.Div: ("/", operator.truediv),
    ast.Add: ("+", operator.add),
    ast.Sub: ("-", operator.sub),
}
ROUNDED: dict[type, tuple[str, str]] = {ast.Mod: ("%", "floored_rest"), ast.FloorDiv: ("/", "floored_quotient")}
COMPARISONS: dict[type, tuple[str, Callable[[Any, Any], bool]]] = {
    ast.Lt: ("<", operator.lt),
    ast.Gt: (">", operator.gt),
    ast.LtE: ("<=", operator.le),
    ast.GtE: (">=", operator.ge),
    ast.Eq: ("==", operator.eq),
    ast.NotEq: ("!=", operator.ne),
}


class Expressions:
    """Reads the expressions of one function; what must be computed before a statement goes into the body before it."""

    def __init__(self, kernel: Kernel, symbols: Symbols, translate: Callable[..., Function]) -> None:
        self.kernel = kernel
        self.symbols = symbols
        self.translate = translate  # gives the kernels that this one calls
        self.refusal = kernel.refusal
        self.files = {kernel.file}  # of the kernel and of those that it calls
        self.meanings: dict[tuple[str, str], str] = {}  # what the global names in them stand for
        self.variables: dict[str, Variable] = {}  # those with a value, by their names in Python
        self.given: set[str] = set()  # variables that have a value here, by whatever way it is reached
        self.body: list[Statement] = []  # statements so far
        self.statement: ast.stmt = kernel.tree  # the one that is read
        self.writes = 0  # how often arrays are changed in place so far
        self.conditional = 0  # how many expressions are open of which C may leave out a part
        names = [node for node in kernel.nodes if isinstance(node, ast.Name)]
        self.uses = Counter(node.id for node in names)
        self.stores = Counter(node.id for node in names if isinstance(node.ctx, ast.Store))
        arguments = kernel.tree.args
        self._taken = {*self.uses, *(each.arg for each in (*arguments.args, *arguments.kwonlyargs))}

    def fresh(self, wish: str) -> str:
        """Return a name that is not in use, like the one wished for."""
        name, count = wish, 1
        while name in self._taken or name in RESERVED:
            count += 1
            name = f"{wish}{count}"
        self._taken.add(name)
        return name

    def read(self, node: ast.expr) -> Node:
        """Return an expression of the tree; ``NotTranslatable`` where it has no translation."""
        method = getattr(self, f"_{type(node).__name__.lower()}", None)
        if method is None:
            allowed = "numbers, names, fields, elements, + - * / **, comparisons, and/or/not, if-else and calls"
            raise self.refusal(node, f"{ast.unparse(node)!r} has no translation; use {allowed}")
        value: Node = method(node)
        return value

    def as_real(self, node: ast.AST, value: Node) -> Node:
        """Return a number as a real one; an integer is converted explicitly."""
        if value.type == REAL:
            return value
        if value.type != INTEGER:
            raise self.refusal(node, "{} is no number")
        return number(float(value.constant)) if value.kind == "number" else Node("real", REAL, (value,))

    def agreeing(self, node: ast.AST, value: Node, kind: Type | None) -> Node:
        """Return a number as a real one where that is wanted."""
        return self.as_real(node, value) if kind == REAL else value

    def condition(self, node: ast.expr) -> Node:
        """Return an expression that must be a truth value."""
        value = self.read(node)
        if value.type != BOOLEAN:
            raise self.refusal(node, "{} is no truth value; compare it, as in x != 0.0")
        return value

    def named(self, node: ast.AST, value: Node) -> Node:
        """Give a value a name of its own before the statement."""
        if self.conditional:
            raise self.refusal(node, "{} stands where it may not be computed; give it a name in a line before")
        kind = value.type
        if kind is None:
            raise self.refusal(node, "{} has no value; use its items")
        wish = kind.name.lower() if isinstance(kind, Record) else "value"
        name = self.fresh(wish.rpartition("_")[2] if wish.endswith("_result") else wish)
        variable = Variable(name, kind, natural=value.natural)
        self.let(variable, value, True)
        return variable.value

    def let(self, variable: Variable, value: Node, is_constant: bool) -> None:
        """Declare a variable with its first value."""
        assert variable.type is not None
        self.symbols.note(variable.type)
        self.body.append(Let(variable, value, is_constant))

    def placed(self, node: ast.AST, value: Node) -> Node:
        """Return a value that is a place in memory, with a name of its own where it was none."""
        return self.named(node, value) if value.root is None else value

    def _constant(self, node: ast.Constant) -> Node:
        if not isinstance(node.value, bool | int | float):
            raise self.refusal(node, f"{node.value!r} is no number and has no translation; pass numbers")
        return self._number(node, node.value, f"{self.kernel.path}:{node.lineno}: {node.value}")

    def _number(self, node: ast.AST, value: bool | int | float, where: str = "") -> Node:
        if isinstance(value, int) and not is_within_word(value):
            raise self.refusal(node, "{} is beyond the 64 bits of integers; write a real number")
        return number(value, where)

    def _name(self, node: ast.Name) -> Node:
        if self.stores[node.id] and node.id == "_":
            raise self.refusal(node, "_ keeps no value; give the variable a name")
        if self.stores[node.id] and node.id not in self.given:
            raise self.refusal(node, f"{node.id} has no value here; give it one before the branch or loop")
        if node.id not in self.variables:
            return self.known(node, self.resolved(node))
        return self.variables[node.id].value

    def is_global(self, node: ast.expr) -> bool:
        """Tell whether an expression is a name of the module, or a member of what is one."""
        while isinstance(node, ast.Attribute):
            node = node.value
        return isinstance(node, ast.Name) and node.id not in self.variables and not self.stores[node.id]

    def resolved(self, node: ast.expr) -> Any:
        """Return what a global name stands for; the translation holds for no other meaning of it."""
        found = resolve(self.kernel, node)
        if not self.symbols.fixed:
            module, name = self.kernel.function.__module__, ast.unparse(node)
            if (module, name) not in self.meanings:
                self.meanings[module, name] = meaning(self.kernel.function.__globals__, name)
        return found

    def known(self, node: ast.AST, found: Any) -> Node:
        """Return a constant of a module, or a default."""
        value = found.value if isinstance(found, Constant) else found
        if not isinstance(value, bool | int | float):
            raise self.refusal(node, "{} is no number; pass it as an argument")
        known = self._number(node, value)
        if not isinstance(found, Constant):
            return known
        folded = known.constant if known.type != REAL else None
        return replace(known, kind="constant", name=self.symbols.constant_name(found), constant=folded)

    def _attribute(self, node: ast.Attribute) -> Node:
        if self.is_global(node):
            return self.known(node, self.resolved(node))
        owner = self.read(node.value)
        if isinstance(owner.type, Array) and node.attr in ("size", "shape"):
            sizes = [owner.size(axis) for axis in range(len(owner.type.shape))]
            return Node("shape", None, tuple(sizes)) if node.attr == "shape" else self._product(sizes)
        try:
            return owner.member(node.attr)
        except KeyError as error:
            raise self.refusal(node, f"{ast.unparse(node.value)} has no field {node.attr}") from error

    def _product(self, sizes: list[Node]) -> Node:
        if any(size.constant is None for size in sizes):
            return sizes[0] if len(sizes) == 1 else Node("operator", INTEGER, tuple(sizes), "*", natural=True)
        return number(math.prod(size.constant for size in sizes))

    def _subscript(self, node: ast.Subscript) -> Node:
        return self.element_of(node, self.read(node.value))

    def element_of(self, node: ast.Subscript, owner: Node) -> Node:
        """Return the element that a subscript takes out of what stands before it."""
        indices = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        if any(isinstance(index, ast.Slice) for index in indices):
            raise self.refusal(node, "{} is a slice; write a loop over a range")
        for index in indices:
            owner = self._element(node, owner, index)
        return owner

    def _element(self, node: ast.Subscript, owner: Node, index: ast.expr) -> Node:
        place = self.read(index)
        if place.type != INTEGER:
            raise self.refusal(node, f"index {ast.unparse(index)} must be an integer")
        if isinstance(owner.type, Record) or owner.kind == "shape":
            count = len(owner.items)
            if place.constant is None or not -count <= place.constant < count:
                raise self.refusal(node, f"{{}} must have one constant place, within its {count} items")
            found: Node = owner.items[place.constant]
            return found
        if not isinstance(owner.type, Line | Array):
            raise self.refusal(node, "{}: there are no elements in a number")
        if isinstance(owner.type, Line) or len(owner.type.shape) > 1:
            owner = self.placed(node, owner)
        return owner.element(self._from_start(node, owner, place))

    def _from_start(self, node: ast.Subscript, owner: Node, place: Node) -> Node:
        """Return an index, which counts from the end where it is negative, from the start."""
        size = number(owner.type.length) if isinstance(owner.type, Line) else owner.size(0)
        length = size.constant
        if place.constant is None:
            if isinstance(owner.type, Line) and length == 1 and not self.symbols.fixed:
                return number(0)  # a computed place would keep compilers from making registers of all around it
            return place if place.natural else Node("call", INTEGER, (place, size), "from_start")
        if length is not None and not -length <= place.constant < length:
            raise self.refusal(node, f"{{}} is outside of its {length} elements")
        if place.constant >= 0:
            return place
        if length is None:
            return Node("operator", INTEGER, (size, number(-place.constant)), "-")
        return number(length + place.constant)

    def spread(self, nodes: list[ast.expr]) -> list[Node]:
        """Return values of expressions one by one, also of those with a star, which stand for several."""
        values: list[Node] = []
        for node in nodes:
            values += self._spread(node.value) if isinstance(node, ast.Starred) else [self.read(node)]
        return values

    def _spread(self, node: ast.expr) -> list[Node]:
        """Return the elements of a tuple, or of a slice of one with constant ends."""
        ends: list[int | None] = [None, None]
        if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Slice) and node.slice.step is None:
            for place, end in enumerate((node.slice.lower, node.slice.upper)):
                ends[place] = None if end is None else self.read(end).constant
                if end is not None and ends[place] is None:
                    raise self.refusal(node, "{}: the ends of a slice must be constants")
            node = node.value
        return self.items(node, self.read(node))[slice(*ends)]

    def items(self, node: ast.AST, owner: Node, count: int | None = None) -> list[Node]:
        """Return all items of a tuple, of which there must be so many."""
        if not isinstance(owner.type, Line | Record):
            raise self.refusal(node, "{} is no tuple")
        found = self.placed(node, owner).items
        if count not in (None, len(found)):
            raise self.refusal(node, f"{{}} gives {len(found)} values, not {count}: there must be a value for each")
        return found

    def _tuple(self, node: ast.Tuple) -> Node:
        """Return a tuple of values of one type; those that a function returns are made by its return statement."""
        values = self.spread(node.elts)
        kinds = {value.type for value in values}
        kind = kinds.pop() if len(kinds) == 1 else None
        if kind is None:
            raise self.refusal(node, "{}: a tuple must hold values of one type; use a NamedTuple")
        return self.made(Line(kind, len(values)), values)

    def record(self, node: ast.AST, name: str, names: Sequence[str], values: list[Node], origin: Any = None) -> Node:
        """Return a record of some values, by the names of its fields."""
        typed = ((each, value.type) for each, value in zip(names, values, strict=True))
        fields = tuple((each, kind) for each, kind in typed if kind is not None)
        if len(fields) < len(values):
            raise self.refusal(node, "{}: a shape or a tuple of constants has no value; use its items")
        return self.made(Record(name, fields, origin), values)

    def made(self, kind: Record | Line, values: list[Node]) -> Node:
        """Return a value of a struct."""
        self.symbols.note(kind)
        return Node("make", kind, tuple(values))

    def _binop(self, node: ast.BinOp) -> Node:
        left, right, operation = self.read(node.left), self.read(node.right), type(node.op)
        if operation is ast.Pow:
            return self._power(node, left, right)
        both = left.type == right.type == INTEGER
        if operation in ROUNDED and both:
            sign, name = ROUNDED[operation]
            if left.natural and (right.constant or 0) > 0:  # C rounds to zero, which is down here
                return Node("operator", INTEGER, (left, right), sign, natural=True)
            is_natural = right.natural and (left.natural or operation is ast.Mod)
            return Node("call", INTEGER, (left, right), name, natural=is_natural)
        if operation not in ARITHMETIC:
            raise self.refusal(node, "{}: there are + - * / and **, and // and % of integers; use math on reals")
        sign, fold = ARITHMETIC[operation]
        if not both or sign == "/":
            return Node("operator", REAL, (self.as_real(node, left), self.as_real(node, right)), sign)
        if left.constant is None or right.constant is None:
            is_natural = left.natural and right.natural and sign != "-"
            return Node("operator", INTEGER, (left, right), sign, natural=is_natural)
        return self._folded(node, fold(left.constant, right.constant), sign, left, right)

    def _folded(self, node: ast.AST, value: int | float, sign: str, *parts: Node) -> Node:
        """Return what an operation gives, as a plain number where it is of such, else as the operation."""
        known = self._number(node, value)
        if all(part.kind == "number" and part.natural for part in parts):
            return known
        return replace(known, kind="operator", parts=parts, name=sign)

    def _power(self, node: ast.AST, base: Node, exponent: Node) -> Node:
        if exponent.type != INTEGER:
            return Node("math", REAL, (self.as_real(node, base), self.as_real(node, exponent)), "pow")
        if base.type != REAL or exponent.constant != 2:
            raise self.refusal(node, "{}: write out powers other than the second as products")
        return Node("call", REAL, (base,), "square")

    def _unaryop(self, node: ast.UnaryOp) -> Node:
        if isinstance(node.op, ast.Not):
            value = self.condition(node.operand)
            return Node("operator", BOOLEAN, (value,), "!", None if value.constant is None else not value.constant)
        if isinstance(node.op, ast.USub) and isinstance(node.operand, ast.Constant) and type(node.operand.value) is int:
            return self._number(node, -node.operand.value)
        value = self.read(node.operand)
        if not isinstance(node.op, ast.USub) or value.type not in (REAL, INTEGER):
            raise self.refusal(node, "{} has no translation; write a number or its negative")
        if value.constant is None:
            return Node("operator", value.type, (value,), "-")
        return self._folded(node, -value.constant, "-", value)

    def _boolop(self, node: ast.BoolOp) -> Node:
        conjunction, values = isinstance(node.op, ast.And), []
        for place, operand in enumerate(node.values):
            self.conditional += place > 0
            value = self.condition(operand)
            self.conditional -= place > 0
            if value.constant is None:
                values.append(value)
            elif bool(value.constant) != conjunction:  # decides it, whatever stands to the left: that has no effects
                return number(not conjunction)
        if not values:
            return number(conjunction)
        sign = "&&" if conjunction else "||"
        return values[0] if len(values) == 1 else Node("operator", BOOLEAN, tuple(values), sign)

    def _compare(self, node: ast.Compare) -> Node:
        if any(type(operation) not in COMPARISONS for operation in node.ops):
            raise self.refusal(node, "{}: there are < > <= >= == and !=")
        parts, right = [], self.read(node.left)
        for place, (operation, item) in enumerate(zip(node.ops, node.comparators, strict=True)):
            left, writes = right, self.writes
            self.conditional += place > 0
            right = self.read(item)
            if place + 1 < len(node.ops) and self.writes > writes:
                right = self.placed(item, right)  # it is compared twice, and changes something once
            self.conditional -= place > 0
            parts.append(self._comparison(node, operation, left, right))
        if all(part.constant is not None for part in parts):
            return number(all(part.constant for part in parts))
        return parts[0] if len(parts) == 1 else Node("operator", BOOLEAN, tuple(parts), "&&")

    def _comparison(self, node: ast.Compare, operation: ast.cmpop, left: Node, right: Node) -> Node:
        """Return two values compared, with what comes of it where that is known."""
        sign, compare = COMPARISONS[type(operation)]
        decided = None
        if {left.type, right.type} <= {INTEGER, REAL} and None not in (left.constant, right.constant):
            decided = compare(left.constant, right.constant)
        if left.type != right.type:
            left, right = self.as_real(node, left), self.as_real(node, right)
        if not isinstance(left.type, Scalar):
            raise self.refusal(node, "{} compares what are no numbers")
        return Node("operator", BOOLEAN, (left, right), sign, decided)

    def _ifexp(self, node: ast.IfExp) -> Node:
        test = self.condition(node.test)
        if test.constant is not None:
            return self.read(node.body if test.constant else node.orelse)
        self.conditional += 1
        first, second = self.read(node.body), self.read(node.orelse)
        self.conditional -= 1
        if first.type != second.type:
            first, second = self.as_real(node.body, first), self.as_real(node.orelse, second)
        return Node("choice", first.type, (test, first, second), natural=first.natural and second.natural)
