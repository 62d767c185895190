"""Statements of kernels in C."""

import ast

from adaptive_ff.export.comments import plain
from adaptive_ff.export.expressions import ARITHMETIC, Expressions
from adaptive_ff.export.loops import loop_header
from adaptive_ff.export.names import c_name
from adaptive_ff.export.results import ResultNames
from adaptive_ff.export.scope import Path, Scope, Variable
from adaptive_ff.export.types import BOOLEAN, INTEGER, REAL, Array, Line, Record, Type, passed_by_pointer
from adaptive_ff.export.values import Value


class Statements:
    """Translates the body of one function.

    Parameters
    ----------
    expressions : Expressions
        Translates its expressions.
    names : ResultNames
        Names of what it returns, where that is several values.
    """

    def __init__(self, expressions: Expressions, names: ResultNames) -> None:
        self.expressions = expressions
        self.unit = expressions.unit
        self.scope: Scope = expressions.scope
        self.kernel = expressions.kernel
        self.names = names
        self.result: Type | None = None
        self.constants: list[int | None] = []
        self._commented: set[int] = set()

    def body(self) -> None:
        """Translate all statements after the docstring."""
        statements = self.kernel.tree.body
        first = statements[0]
        if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
            self._commented.update(range(first.lineno, (first.end_lineno or first.lineno) + 1))
            statements = statements[1:]
        self.block(statements, ())

    @property
    def constant(self) -> int | None:
        """What the function returns, where it does nothing else and that is known."""
        return self.constants[0] if len(self.constants) == 1 and not self.scope.writes else None

    def block(self, statements: list[ast.stmt], path: Path) -> None:
        """Translate the statements of a block."""
        for statement in statements:
            self._own_comments(statement)
            if isinstance(statement, ast.If):
                self._if(statement, path)
                continue
            if isinstance(statement, ast.For):
                self.scope.announce(statement, path)
            start = len(self.scope.lines)
            if not isinstance(statement, ast.For):
                self.expressions.open_statement(statement)
            self._statement(statement, path)
            self._trailing_comment(statement, start)

    def _statement(self, statement: ast.stmt, path: Path) -> None:
        match statement:
            case ast.Return():
                self._return(statement)
            case ast.Assign(targets=[target]):
                self._assign(target, statement.value)
            case ast.Assign(targets=[*targets]) if all(isinstance(target, ast.Name) for target in targets):
                self._bind_all(targets, statement.value)
            case ast.AnnAssign(target=target, value=ast.expr() as value):
                self._assign(target, value)
            case ast.AugAssign():
                self._augmented(statement)
            case ast.Expr(value=ast.Call() as call):
                self.scope.emit(f"{self.expressions.translate(call).text};")
            case ast.For():
                self._for(statement, path)
            case ast.Break() | ast.Continue():
                self.scope.emit(f"{ast.unparse(statement)};")
            case ast.Pass():
                pass
            case _:
                shown = ast.unparse(statement).partition("\n")[0]
                allowed = "assignments, if, for over a range, return and calls; a loop over a range replaces while"
                raise self.kernel.refusal(statement, f"{shown!r} has no translation; there are {allowed}")

    def _own_comments(self, statement: ast.stmt) -> None:
        """Write the comment lines that stand above a statement."""
        line, found = statement.lineno - 1, []
        while line in self.kernel.comments and self.kernel.comments[line][1] and line not in self._commented:
            self._commented.add(line)
            found.append(self.kernel.comments[line][0])
            line -= 1
        for text in reversed(found):
            self.scope.emit(f"/* {plain(text)} */")

    def _trailing_comment(self, statement: ast.stmt, start: int) -> None:
        """Write the comment beside a statement, above what it became."""
        last = statement.lineno if isinstance(statement, ast.For | ast.If) else statement.end_lineno
        texts = []
        for line in range(statement.lineno, (last or statement.lineno) + 1):
            if line in self.kernel.comments and line not in self._commented:
                self._commented.add(line)
                texts.append(plain(self.kernel.comments[line][0]))
        if texts and len(self.scope.lines) > start:
            self.scope.lines.insert(start, (self.scope.depth, f"/* {'; '.join(texts)} */"))

    def _if(self, statement: ast.If, path: Path) -> None:
        self.expressions.open_statement(ast.Expr(statement.test))
        test = self.expressions.condition(statement.test)
        if test.constant is not None:  # sizes decide it: the other branch is for other sizes
            self.scope.folded.add(id(statement))
            branch, name = (statement.body, "body") if test.constant else (statement.orelse, "orelse")
            self.block(branch, (*path, (id(statement), name)))
            return
        self.scope.announce(statement, path)
        start = len(self.scope.lines)
        self.scope.emit(f"if ({test.text}) {{")
        self._trailing_comment(statement, start)
        self._indented(statement.body, (*path, (id(statement), "body")))
        if statement.orelse:
            self._else(statement, path)
        self.scope.emit("}")

    def _else(self, statement: ast.If, path: Path) -> None:
        start = len(self.scope.lines)
        self._indented(statement.orelse, (*path, (id(statement), "orelse")))
        lines = self.scope.lines[start:]
        if not lines:
            return
        first = lines[0][1]
        single = len(statement.orelse) == 1 and isinstance(statement.orelse[0], ast.If)
        if single and isinstance(first, str) and first.startswith("if ("):
            lines = [(depth - 1, text) for depth, text in lines[:-1]]  # its own closing brace serves both
            self.scope.lines[start:] = [(self.scope.depth, f"}} else {first}"), *lines[1:]]
        else:
            self.scope.lines[start:] = [(self.scope.depth, "} else {"), *lines]

    def _indented(self, statements: list[ast.stmt], path: Path) -> None:
        self.scope.depth += 1
        self.block(statements, path)
        self.scope.depth -= 1

    def _for(self, statement: ast.For, path: Path) -> None:
        header, runs = loop_header(self.expressions, statement)
        if not runs:
            return
        assert isinstance(statement.target, ast.Name)
        name = statement.target.id
        outer = self.scope.variables.get(name)
        self.scope.variables[name] = Variable(c_name(name), INTEGER)
        self.scope.emit(header)
        self._indented(statement.body, (*path, (id(statement), "body")))
        self.scope.emit("}")
        del self.scope.variables[name]
        if outer is not None:
            self.scope.variables[name] = outer

    def _assign(self, target: ast.expr, node: ast.expr) -> None:
        match target:
            case ast.Tuple():
                self._unpack(target, node)
            case ast.Name():
                self._bind(target, self.expressions.translate(node))
            case ast.Subscript() if _is_full_slice(target.slice):
                self._fill(target, node)
            case _:
                self._store(target, self.expressions.translate(node))

    def _bind_all(self, targets: list[ast.expr], node: ast.expr) -> None:
        """Give several variables one value."""
        value = self.expressions.translate(node)
        if value.constant is None and not isinstance(node, ast.Name):
            value = self._kept(node, value)
        for target in targets:
            assert isinstance(target, ast.Name)
            self._bind(target, value)

    def _store(self, target: ast.expr, value: Value) -> None:
        """Assign to an element of an array."""
        if not isinstance(target, ast.Subscript):
            raise self.kernel.refusal(target, f"{ast.unparse(target)} cannot be assigned to; make a new NamedTuple")
        base = self.expressions.translate(target.value)
        place = self.expressions.element_of(target, base)
        if not isinstance(base.type, Array):
            raise self.kernel.refusal(
                target, f"{ast.unparse(target)} cannot be assigned to; only arrays change in place"
            )
        if place.type == REAL:
            value = self.expressions.as_real(target, value)
        if place.type != value.type or isinstance(place.type, Array):
            raise self.kernel.refusal(target, f"{ast.unparse(target)} must be given a number, element by element")
        self.scope.writes = True
        self.scope.emit(f"{place.text} = {value.text};")

    def _fill(self, target: ast.Subscript, node: ast.expr) -> None:
        """Assign to all elements of an array, a number or those of another one."""
        array, value = self.expressions.translate(target.value), self.expressions.translate(node)
        if not isinstance(array.type, Array):
            raise self.kernel.refusal(target, f"{ast.unparse(target)}: only an array can be filled")
        if isinstance(value.type, Array) and value.type != array.type:
            raise self.kernel.refusal(target, f"{ast.unparse(target)} and {ast.unparse(node)} must be of one shape")
        self.scope.writes = True
        depth = self.scope.depth
        for extent in array.type.shape:
            name = self.scope.fresh("place")
            self.scope.emit(f"for (int {name} = 0; {name} < {extent}; {name}++) {{")
            self.scope.depth += 1
            array = array.element(name)
            if isinstance(value.type, Array):
                value = value.element(name)
        if array.type == REAL:
            value = self.expressions.as_real(node, value)
        self.scope.emit(f"{array.text} = {value.text};")
        while self.scope.depth > depth:
            self.scope.depth -= 1
            self.scope.emit("}")

    def _bind(self, target: ast.Name, value: Value) -> None:
        """Give a variable a value, and declare it where that is its first."""
        name = target.id
        if name == "_":
            return
        if value.type is None:
            raise self.kernel.refusal(target, f"{name}: a shape or a tuple of constants has no value; use its items")
        known = self.scope.variables.get(name)
        if known is not None and known.type != value.type:
            if known.type == REAL and value.type == INTEGER:
                value = self.expressions.as_real(target, value)
            else:
                raise self.kernel.refusal(target, f"{name} changes its type; begin with 0.0 for a real number")
        if self.scope.is_declared(name):
            if known is None:
                assert value.type is not None
                self.scope.variables[name] = Variable(c_name(name), value.type)
            self.scope.emit(f"{c_name(name)} = {value.content};")
            return
        self.scope.declare(name)
        self._declare(name, value, once=self.scope.stores[name] == 1)

    def _declare(self, name: str, value: Value, once: bool) -> None:
        kind = value.type
        assert kind is not None
        text = c_name(name)
        if once and passed_by_pointer(kind) and value.root and self.scope.is_constant(value.root):
            self.scope.variables[name] = Variable(text, kind, pointer=True)
            pointer = value.text if value.pointer else f"&{value.text}"
            self.scope.emit(f"const {self.unit.c_type(kind)} *{text} = {pointer};")
        elif once and kind == INTEGER and value.constant is not None:
            self.scope.variables[name] = Variable(text, kind, constant=value.constant)
            named = value.text == value.text.upper()  # of constants of modules alone, not of variables
            self.scope.emit(f"const int {text} = {value.text if named else value.constant};")
        else:
            self.scope.variables[name] = Variable(text, kind)
            constant = "const " if once and not isinstance(kind, Array) else ""
            self.scope.emit(f"{constant}{self.unit.declaration(kind, text)} = {value.content};")
        self.scope.note_declaration(name)

    def _unpack(self, target: ast.Tuple, node: ast.expr) -> None:
        if isinstance(node, ast.Tuple):
            if len(node.elts) != len(target.elts):
                raise self.kernel.refusal(target, f"{ast.unparse(target)}: there must be a value for each")
            values = [self.expressions.translate(item) for item in node.elts]
            if self._overlap(target, node):
                values = [self._kept(item, value) for item, value in zip(node.elts, values, strict=True)]
        else:
            values = self._items(node, self.expressions.translate(node), len(target.elts))
        for item, value in zip(target.elts, values, strict=True):
            if isinstance(item, ast.Name):
                self._bind(item, value)
            else:
                self._store(item, value)

    def _items(self, node: ast.expr, value: Value, count: int) -> list[Value]:
        """Return the items of a value, of which there must be so many."""
        length = len(value.type.fields) if isinstance(value.type, Record) else 0
        length = value.type.length if isinstance(value.type, Line) else length
        if length != count:
            raise self.kernel.refusal(node, f"{ast.unparse(node)} gives {length} values, not {count}")
        if not value.root:
            name = self.expressions.hoisted(node, value)
            value = Value(name, value.type, root=name)
        if isinstance(value.type, Record):
            return [value.member(name) for name, _ in value.type.fields]
        return [value.element(str(place)) for place in range(count)]

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
        if isinstance(value.type, Array):
            raise self.kernel.refusal(node, f"{ast.unparse(node)}: give arrays their names one by one")
        name = self.expressions.hoisted(node, value)
        return Value(name, value.type, root=name)

    def _augmented(self, statement: ast.AugAssign) -> None:
        if type(statement.op) not in ARITHMETIC:
            raise self.kernel.refusal(statement, f"{ast.unparse(statement)}: there are += -= *= and /=")
        operator = ARITHMETIC[type(statement.op)][0]
        place, value = self._augmented_place(statement.target), self.expressions.translate(statement.value)
        if place.type == INTEGER and (value.type != INTEGER or operator == "/"):
            raise self.kernel.refusal(statement, f"{ast.unparse(statement.target)} changes its type; begin with 0.0")
        if place.type == REAL:
            value = self.expressions.as_real(statement.value, value)
        self.scope.emit(f"{place.text} {operator}= {value.text};")

    def _augmented_place(self, target: ast.expr) -> Value:
        if isinstance(target, ast.Name):
            return self.expressions.translate(target)
        if isinstance(target, ast.Subscript):
            base = self.expressions.translate(target.value)
            place = self.expressions.element_of(target, base)
            if isinstance(base.type, Array):
                self.scope.writes = True
                return place
        raise self.kernel.refusal(target, f"{ast.unparse(target)} cannot be assigned to; make a new NamedTuple")

    def _return(self, statement: ast.Return) -> None:
        node = statement.value
        if node is None or (isinstance(node, ast.Constant) and node.value is None):
            self.scope.emit("return;")
            return
        if isinstance(node, ast.Tuple) and not any(isinstance(item, ast.Starred) for item in node.elts):
            values = [self.expressions.translate(item) for item in node.elts]
            self._return_several(statement, values)
            return
        value = self.expressions.translate(node)
        if isinstance(value.type, Record) and value.type.origin is None:  # what another function returned
            self._return_several(statement, self._items(node, value, len(value.type.fields)))
            return
        if value.type is None:
            raise self.kernel.refusal(statement, "a shape or a tuple of constants cannot be returned")
        self._agree(statement, value.type)
        self.constants.append(value.constant if value.type in (INTEGER, BOOLEAN) else None)
        if self.result == REAL:
            value = self.expressions.as_real(node, value)
        self.scope.emit(f"return {value.content};")

    def _return_several(self, statement: ast.Return, values: list[Value]) -> None:
        if isinstance(self.result, Record) and len(self.result.fields) == len(values):
            pairs = zip(self.result.fields, values, strict=True)
            values = [self.expressions.as_real(statement, v) if k == REAL else v for (_, k), v in pairs]
        record = self.names.record(self.kernel, values)
        self._agree(statement, record)
        self.scope.emit(f"return {self.unit.compound(record, values)};")

    def _agree(self, statement: ast.Return, kind: Type) -> None:
        if self.result is None:
            self.result = kind
        elif self.result != kind and not (self.result == REAL and kind == INTEGER):
            raise self.kernel.refusal(statement, "all returns must give values of the same types")


def _is_full_slice(node: ast.expr) -> bool:
    parts = node.elts if isinstance(node, ast.Tuple) else [node]
    return all(isinstance(p, ast.Slice) and p.lower is None and p.upper is None and p.step is None for p in parts)
