"""Assignments of kernels in C: to variables, to elements, to whole arrays."""

import ast

from controllers.kernels.calls import Calls
from controllers.kernels.names import c_name
from controllers.kernels.operators import ARITHMETIC
from controllers.kernels.scope import Unused, Variable
from controllers.kernels.types import INTEGER, REAL, Array, Line, Record, passed_by_pointer
from controllers.kernels.values import Value


class Assignments(Calls):
    """Gives variables and elements their values."""

    def assign(self, target: ast.expr, node: ast.expr) -> None:
        """Translate an assignment to one target."""
        match target:
            case ast.Tuple():
                self._unpack(target, node)
            case ast.Name():
                self._bind(target, self.translate(node))
            case ast.List() | ast.Starred():
                self._give(target, self.translate(node))
            case ast.Subscript() if _is_full_slice(target.slice):
                self._fill(target, node)
            case _:
                value = self._before(target, node)
                if isinstance(value.type, Record | Line) and isinstance(target, ast.Subscript):
                    self._spread_over(target, node, value)
                else:
                    self._store(target, value)

    def assign_all(self, targets: list[ast.expr], node: ast.expr) -> None:
        """Give several targets one value."""
        value = self.translate(node)
        if value.constant is None and not isinstance(node, ast.Name):
            value = self._kept(node, value)
        for target in targets:
            self._give(target, value)

    def _give(self, target: ast.expr, value: Value) -> None:
        """Give one of several targets its value."""
        if isinstance(target, ast.Name):
            self._bind(target, value)
        elif isinstance(target, ast.Tuple | ast.List | ast.Starred):
            raise self.refusal(target, "{} cannot be one of several targets; write a statement for each")
        else:
            self._store(target, value)

    def _before(self, target: ast.expr, node: ast.expr) -> Value:
        """Return a value that is computed before the place where it goes, as Python does."""
        writes = self.scope.writes
        value = self.translate(node)
        inner = [part for part in ast.walk(target) if isinstance(part, ast.Call | ast.Subscript) and part is not target]
        if self.scope.writes > writes and inner:
            return self._kept(node, value)
        return value

    def _place(self, target: ast.expr) -> Value:
        """Return an element of an array that is to be changed."""
        if not isinstance(target, ast.Subscript):
            raise self.refusal(target, "{} cannot be assigned to; make a new NamedTuple")
        base = self.translate(target.value)
        if not isinstance(base.type, Array):
            raise self.refusal(target, "{} cannot be assigned to; make a new tuple")
        if not base.root:
            base = self.placed(target, base)
        place = self.element_of(target, base)
        if isinstance(place.type, Array):
            raise self.refusal(target, "{} is no number of an array; give an index for each dimension")
        self.scope.writes += 1
        return place

    def _store(self, target: ast.expr, value: Value) -> None:
        """Assign to an element of an array."""
        place = self._place(target)
        if place.type == REAL:
            value = self.as_real(target, value)
        if place.type != value.type:
            raise self.refusal(target, "{} must be given a value of the array's type")
        self.scope.emit(f"{place.text} = {value.text};")

    def _spread_over(self, target: ast.Subscript, node: ast.expr, value: Value) -> None:
        """Assign the numbers of a tuple to a row of an array, one after another."""
        base = self.translate(target.value)
        row = self.element_of(target, base)
        if not isinstance(row.type, Array) or len(row.type.shape) != 1:
            raise self.refusal(target, "{} cannot be given a tuple; only a row of an array can")
        self.scope.writes += 1
        for place, item in enumerate(self.items(node, value)):
            if row.type.element == REAL:
                item = self.as_real(node, item)
            if item.type != row.type.element:
                raise self.refusal(node, "{} holds what are no numbers of the array's type")
            self.scope.emit(f"{row.element(str(place)).text} = {item.text};")

    def _fill(self, target: ast.Subscript, node: ast.expr) -> None:
        """Assign to all elements of an array a number or those of another one, which is computed first."""
        value = self._before(target, node)
        array = self.translate(target.value)
        if not isinstance(array.type, Array):
            raise self.refusal(target, "{}: only an array can be filled")
        if isinstance(target.slice, ast.Tuple) and len(target.slice.elts) > len(array.type.shape):
            raise self.refusal(target, "{} has more places than the array has dimensions; write [:]")
        if isinstance(value.type, Array) and value.type != array.type:
            raise self.refusal(target, "{} must be given a number or an array like it, of one shape")
        self.scope.writes += 1
        if not isinstance(value.type, Array):
            if array.type.element == REAL:
                value = self.as_real(node, value)
            if value.type != array.type.element:
                raise self.refusal(target, f"{ast.unparse(node)} is no number of the array's type")
            if any(isinstance(part, ast.Call | ast.Subscript) for part in ast.walk(node)):
                value = self._kept(node, value)
        if array.type.is_open:
            self._fill_open(node, array, value)
        else:
            self._fill_fixed(array, value)

    def _fill_fixed(self, array: Value, value: Value) -> None:
        depth = self.scope.depth
        for extent in array.array.shape:
            name = self.scope.fresh("place")
            self.scope.emit(f"for (int {name} = 0; {name} < {extent}; {name}++) {{")
            self.scope.depth += 1
            array = array.element(name)
            if isinstance(value.type, Array):
                value = value.element(name)
        self.scope.emit(f"{array.text} = {value.text};")
        while self.scope.depth > depth:
            self.scope.depth -= 1
            self.scope.emit("}")

    def _fill_open(self, node: ast.expr, array: Value, value: Value) -> None:
        array = self._whole(node, array)
        axes = range(len(array.array.shape))
        if isinstance(value.type, Array):
            value = self._whole(node, value)
            sizes = (f"(const int64_t[]){{{', '.join(each.size(k).text for k in axes)}}}" for each in (array, value))
            given = f"{array.text}.data, {next(sizes)}, {value.text}.data, {next(sizes)}"
            width = f"sizeof *{array.text}.data"
            self.scope.emit(f"{self.unit.helper('copy_array', given, str(len(axes)), width)};")
            return
        name, count = self.scope.fresh("place"), " * ".join(array.size(k).text for k in axes)
        self.scope.emit(f"for (int64_t {name} = 0; {name} < {count}; {name}++) {{")
        self.scope.lines.append((self.scope.depth + 1, f"{array.text}.data[{name}] = {value.text};"))
        self.scope.emit("}")

    def _whole(self, node: ast.AST, array: Value) -> Value:
        """Return an array of open sizes that has an address of its own, a row as well."""
        return array if array.root and not array.part else self.named(node, array)

    def _bind(self, target: ast.Name, value: Value) -> None:
        """Give a variable a value, and declare it where that is its first."""
        name = target.id
        if name == "_":
            return
        if value.type is None:
            raise self.refusal(target, f"{name}: a shape or a tuple of constants has no value; use its items")
        known = self.scope.variables.get(name)
        if known is not None and known.type != value.type:
            if known.type == REAL and value.type == INTEGER:
                value = self.as_real(target, value)
            else:
                raise self.refusal(target, f"{name} changes its type; begin with 0.0 for a real number")
        self.scope.given.add(name)
        once = self.scope.stores[name] == 1
        if name in self.scope.declared:
            if known is None:
                assert value.type is not None
                natural = value.natural and (once or self.scope.counted[name] == self.scope.stores[name])
                self.scope.variables[name] = Variable(c_name(name), value.type, natural=natural)
            self.scope.emit(f"{c_name(name)} = {value.content};")
            return
        self.scope.declared.add(name)
        self._declare(name, value, once)

    def _declare(self, name: str, value: Value, once: bool) -> None:
        kind = value.type
        assert kind is not None
        text = c_name(name)
        owner = self.scope.variables.get(value.root)
        if once and passed_by_pointer(kind) and owner is not None and owner.pointer:
            self.scope.variables[name] = Variable(text, kind, pointer=True)
            pointer = value.text if value.pointer else f"&{value.text}"
            self.scope.emit(f"const {self.unit.c_type(kind)} *{text} = {pointer};")
        elif once and kind == INTEGER and value.constant is not None:
            self.scope.variables[name] = Variable(text, kind, constant=value.constant, natural=value.natural)
            named = value.text == value.text.upper()  # of constants of modules alone, not of variables
            integer = "int" if self.unit.fixed else "int64_t"
            self.scope.emit(f"const {integer} {text} = {value.text if named else value.constant};")
        else:
            known = value.constant if once and kind == REAL else None
            self.scope.variables[name] = Variable(text, kind, constant=known, natural=value.natural and once)
            constant = "const " if once and not isinstance(kind, Array) else ""
            self.scope.emit(f"{constant}{self.unit.declaration(kind, text)} = {value.content};")
        self.scope.lines.append((self.scope.depth, Unused(name)))

    def _unpack(self, target: ast.Tuple, node: ast.expr) -> None:
        if isinstance(node, ast.Tuple):
            values = self.spread(node.elts)
            if len(values) != len(target.elts):
                raise self.refusal(target, "{}: there must be a value for each")
            if self._overlap(target, node):
                values = [self._kept(node, value) for value in values]
        else:
            values = self.so_many(node, self.translate(node), len(target.elts))
        for item, value in zip(target.elts, values, strict=True):
            self._give(item, value)

    def so_many(self, node: ast.expr, value: Value, count: int) -> list[Value]:
        """Return the items of a value, of which there must be so many."""
        values = self.items(node, value)
        if len(values) != count:
            raise self.refusal(node, f"{{}} gives {len(values)} values, not {count}: there must be a value for each")
        return values

    def _overlap(self, target: ast.Tuple, node: ast.Tuple) -> bool:
        """Tell whether a value may depend on a target before it: Python computes all values first."""
        later = [leaf for value in node.elts[1:] for leaf in ast.walk(value)]
        stored = {item.id for item in target.elts if isinstance(item, ast.Name)}
        elements = any(isinstance(item, ast.Subscript) for item in target.elts)
        return any(
            (isinstance(leaf, ast.Name) and leaf.id in stored)
            or (elements and isinstance(leaf, ast.Subscript | ast.Call))
            for leaf in later
        )

    def _kept(self, node: ast.expr, value: Value) -> Value:
        if isinstance(value.type, Array) and not value.type.is_open:
            raise self.refusal(node, "{}: give arrays their names one by one")
        if value.type is None:
            raise self.refusal(node, "{} has no value; use its items")
        return self.named(node, value)

    def augment(self, statement: ast.AugAssign) -> None:
        """Translate ``+=`` and its like."""
        target, operation = statement.target, statement.op
        if type(operation) not in ARITHMETIC:
            raise self.refusal(statement, "{}: there are += -= *= and /=")
        operator = ARITHMETIC[type(operation)][0]
        if isinstance(target, ast.Subscript) and any(isinstance(leaf, ast.Slice) for leaf in ast.walk(target)):
            raise self.refusal(target, "{} is a slice; write a loop over a range")
        is_name = isinstance(target, ast.Name)
        place = self.translate(target) if is_name else self._place(target)
        value = self.translate(statement.value)
        if place.type not in (REAL, INTEGER):
            raise self.refusal(statement, f"{ast.unparse(target)} is no number")
        if place.type == INTEGER and (value.type != INTEGER or operator == "/"):
            raise self.refusal(statement, f"{ast.unparse(target)} changes its type; begin with 0.0")
        if place.type == REAL:
            value = self.as_real(statement.value, value)
        self.scope.emit(f"{place.text} {operator}= {value.text};")


def _is_full_slice(node: ast.expr) -> bool:
    parts = node.elts if isinstance(node, ast.Tuple) else [node]
    return all(isinstance(p, ast.Slice) and p.lower is None and p.upper is None and p.step is None for p in parts)
