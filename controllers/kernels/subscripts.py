"""Fields, elements, rows, sizes and items in C: what stands behind a dot or in brackets, or is spread by a star."""

import ast

from controllers.kernels.expressions import Expressions
from controllers.kernels.types import INTEGER, Array, Line, Record
from controllers.kernels.values import PRIMARY, PRODUCT, Value


class Subscripts(Expressions):
    """Translates what takes values out of others, and tuples."""

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
        """Return an item of a tuple of constants, a shape or a record, whose place must be known."""
        items = owner.type.fields if isinstance(owner.type, Record) else owner.constant or ()
        if place.constant is None or not -len(items) <= place.constant < len(items):
            raise self.refusal(node, f"{{}} must have one constant place, within its {len(items)} items")
        item = items[place.constant]
        if isinstance(owner.type, Record):
            return owner.member(item[0])
        if isinstance(item, Value):
            return item
        number = self.known(node, item)
        text = f"{owner.text}_{place.constant % len(items)}" if owner.text else number.text
        return Value(text, number.type, constant=number.constant if number.type == INTEGER else None)

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
