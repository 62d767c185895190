"""Assignments of kernels in C: to variables, to elements, to whole arrays."""

import ast

from controllers.kernels.calls import ARITHMETIC, Calls
from controllers.kernels.literals import c_name
from controllers.kernels.scope import Later, Variable
from controllers.kernels.types import INTEGER, REAL, Array, Line, Record, passed_by_pointer
from controllers.kernels.values import Value


class Assignments(Calls):
    """Gives variables and elements their values."""

    def assign(self, target: ast.expr, node: ast.expr) -> None:
        """Translate an assignment to one target."""
        if isinstance(target, ast.Tuple):
            self._unpack(target, node)
        elif isinstance(target, ast.Name):
            self._bind(target, self.translate(node))
        else:
            value = self._before(target, node)
            if isinstance(value.type, Record | Line) and isinstance(target, ast.Subscript):
                self._spread_over(target, node, value)
            else:
                self._give(target, value)

    def _give(self, target: ast.expr, value: Value) -> None:
        """Give a target, perhaps one of several, its value."""
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
        self.scope.lines.append((self.scope.depth, Later(name, declares=False)))

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
