"""Statements of kernels in C."""

import ast

from controllers.kernels.assignments import Assignments
from controllers.kernels.comments import plain
from controllers.kernels.loops import loop_header
from controllers.kernels.results import result_of
from controllers.kernels.scope import Loop, Path, Scope, Variable
from controllers.kernels.types import BOOLEAN, INTEGER, REAL, Record, Type
from controllers.kernels.unit import Unit
from controllers.kernels.values import Value

ANNOTATED = {"float": REAL, "int": INTEGER, "bool": BOOLEAN}
"""What a kernel returns, by its annotation."""


class Statements(Assignments):
    """Translates the body of one function."""

    def __init__(self, unit: Unit, scope: Scope, name: str) -> None:
        super().__init__(unit, scope)
        self.name = name
        returns = self.kernel.tree.returns
        self.result: Type | None = ANNOTATED.get(ast.unparse(returns) if returns else "")
        self.constants: list[int | None] = []
        self.natural = True
        self._gives_nothing = False
        self._commented: set[int] = set()

    def body(self) -> None:
        """Translate all statements after the docstring."""
        statements = self.kernel.tree.body
        first = statements[0]
        if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant):
            self._commented.update(range(first.lineno, (first.end_lineno or first.lineno) + 1))
            statements = statements[1:]
        self.sequence(statements, ())
        if not self.scope.ended and self.result is not None:
            raise self.refusal(self.kernel.tree, "it must return a value at its end, as it does elsewhere")

    @property
    def constant(self) -> int | None:
        """What the function returns, where it does nothing else and that is known."""
        return self.constants[0] if len(self.constants) == 1 and not self.scope.writes else None

    def sequence(self, statements: list[ast.stmt], path: Path) -> None:
        """Translate the statements of a sequence, up to one behind which nothing comes."""
        for statement in statements:
            if self.scope.ended:
                return
            self._own_comments(statement)
            if isinstance(statement, ast.If):
                self._if(statement, path)
                continue
            if isinstance(statement, ast.For | ast.While):
                self.scope.announce(statement, path)
            start = len(self.scope.lines)
            if not isinstance(statement, ast.For | ast.While):
                self.open_statement(statement)
            self._statement(statement, path)
            self._trailing_comment(statement, start)

    def _statement(self, statement: ast.stmt, path: Path) -> None:
        match statement:
            case ast.Return():
                self._return(statement)
            case ast.Assign(targets=[target]):
                self.assign(target, statement.value)
            case ast.Assign(targets=targets):
                self.assign_all(targets, statement.value)
            case ast.AnnAssign(target=target, value=ast.expr() as value):
                self.assign(target, value)
            case ast.AugAssign():
                self.augment(statement)
            case ast.Expr(value=ast.Call() as call):
                self.scope.emit(f"{self.translate(call).text};")
            case ast.For():
                self._for(statement, path)
            case ast.While() if not self.unit.fixed:
                self._while(statement, path)
            case ast.Break() | ast.Continue() if self.scope.loops:
                loop = self.scope.loops[-1]
                (loop.breaks if isinstance(statement, ast.Break) else loop.turns).append(set(self.scope.given))
                self.scope.emit(f"{ast.unparse(statement)};")
                self.scope.ended = True
            case ast.Pass():
                pass
            case _:
                shown = ast.unparse(statement).partition("\n")[0]
                allowed = "assignments, if, for over a range, return and calls"
                if isinstance(statement, ast.While):
                    allowed += "; in firmware a loop over a range replaces while"
                raise self.refusal(statement, f"{shown!r} has no translation; there are {allowed}")

    def _own_comments(self, statement: ast.stmt) -> None:
        """Write the comment lines that stand above a statement."""
        if not self.unit.fixed:
            return
        line, found = statement.lineno - 1, []
        while line in self.kernel.comments and self.kernel.comments[line][1] and line not in self._commented:
            self._commented.add(line)
            found.append(self.kernel.comments[line][0])
            line -= 1
        for text in reversed(found):
            self.scope.emit(f"/* {plain(text)} */")

    def _trailing_comment(self, statement: ast.stmt, start: int) -> None:
        """Write the comment beside a statement, above what it became."""
        if not self.unit.fixed:
            return
        last = statement.lineno if isinstance(statement, ast.For | ast.If) else statement.end_lineno
        texts = []
        for line in range(statement.lineno, (last or statement.lineno) + 1):
            if line in self.kernel.comments and line not in self._commented:
                self._commented.add(line)
                texts.append(plain(self.kernel.comments[line][0]))
        if texts and len(self.scope.lines) > start:
            self.scope.lines.insert(start, (self.scope.depth, f"/* {'; '.join(texts)} */"))

    def _if(self, statement: ast.If, path: Path) -> None:
        self.open_statement(ast.Expr(statement.test))
        test = self.condition(statement.test)
        if test.constant is not None:  # sizes decide it: the other branch is for other sizes
            self.scope.folded.add(id(statement))
            branch, name = (statement.body, "body") if test.constant else (statement.orelse, "orelse")
            self.sequence(branch, (*path, (id(statement), name)))
            return
        self.scope.announce(statement, path)
        start, before = len(self.scope.lines), set(self.scope.given)
        self.scope.emit(f"if ({test.text}) {{")
        self._trailing_comment(statement, start)
        self._indented(statement.body, (*path, (id(statement), "body")))
        ways = [] if self.scope.ended else [self.scope.given]
        self.scope.given, self.scope.ended = set(before), False
        if statement.orelse:
            self._else(statement, path)
        ways += [] if self.scope.ended else [self.scope.given]
        self.scope.given, self.scope.ended = set.intersection(*ways) if ways else before, not ways
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
        self.sequence(statements, path)
        self.scope.depth -= 1

    def _for(self, statement: ast.For, path: Path) -> None:
        header, counter, natural, runs = loop_header(self, statement)
        assert isinstance(statement.target, ast.Name)
        name = statement.target.id
        outer, before = self.scope.variables.get(name), set(self.scope.given)
        self.scope.variables[name] = Variable(counter, INTEGER, natural=natural)
        self.scope.given.add(name)
        if runs is False:
            self.scope.given = before
        else:
            self.scope.emit(header)
            loop = self._repeat(statement, path)
            self.scope.emit("}")
            always = runs is True and bool(loop.turns)
            self.scope.given = set.intersection(*(loop.turns if always else [before]), *loop.breaks)
        self.scope.given.discard(name)  # a counter is that of its loop
        del self.scope.variables[name]
        if outer is not None:
            self.scope.variables[name] = outer

    def _while(self, statement: ast.While, path: Path) -> None:
        self.open_statement(ast.Expr(statement.test))
        self.scope.conditional += 1  # nothing may be computed before a test that is made anew each time
        test = self.condition(statement.test)
        self.scope.conditional -= 1
        if statement.orelse:
            raise self.refusal(statement, "while has no translation with else")
        before = set(self.scope.given)
        if test.constant is False:
            return
        self.scope.emit(f"while ({test.text}) {{")
        loop = self._repeat(statement, path)
        self.scope.emit("}")
        ways = [*([] if test.constant is True else [before]), *loop.breaks]
        self.scope.given, self.scope.ended = set.intersection(*ways) if ways else before, not ways

    def _repeat(self, statement: ast.For | ast.While, path: Path) -> Loop:
        """Translate the statements of a loop; return on which ways they are left."""
        loop = Loop()
        self.scope.loops.append(loop)
        self._indented(statement.body, (*path, (id(statement), "body")))
        self.scope.loops.pop()
        if not self.scope.ended:
            loop.turns.append(self.scope.given)
        self.scope.ended = False
        return loop

    def _return(self, statement: ast.Return) -> None:
        node = statement.value
        self.scope.ended = True
        if node is None or (isinstance(node, ast.Constant) and node.value is None):
            if self.result is not None:
                raise self.refusal(statement, "it must return a value at its end, as it does elsewhere")
            self._gives_nothing = True
            self.scope.emit("return;")
            return
        if self._gives_nothing:
            shown = ast.unparse(statement)
            raise self.refusal(statement, f"{shown!r} must return what other returns do, and that must have a value")
        if isinstance(node, ast.Tuple) and not any(isinstance(item, ast.Starred) for item in node.elts):
            values = [self.translate(item) for item in node.elts]
            self._return_several(statement, values)
            return
        value = self.translate(node)
        if isinstance(value.type, Record) and value.type.origin is None:  # what another function returned
            self._return_several(statement, self.so_many(node, value, len(value.type.fields)))
            return
        if value.type is None:
            raise self.refusal(statement, "a shape or a tuple of constants cannot be returned")
        self._agree(statement, value.type)
        self.constants.append(
            value.constant if self.result == value.type and value.type in (INTEGER, BOOLEAN) else None
        )
        self.natural = self.natural and value.natural
        if self.result == REAL:
            value = self.as_real(node, value)
        self.scope.emit(f"return {value.content};")

    def _return_several(self, statement: ast.Return, values: list[Value]) -> None:
        if isinstance(self.result, Record) and len(self.result.fields) == len(values):
            pairs = zip(self.result.fields, values, strict=True)
            values = [self.as_real(statement, v) if k == REAL else v for (_, k), v in pairs]
        record = result_of(self.kernel, self.name, values)
        self._agree(statement, record)
        self.scope.emit(f"return {self.unit.compound(record, values)};")

    def _agree(self, statement: ast.Return, kind: Type) -> None:
        if self.result is None:
            self.result = kind
        elif self.result != kind and not (self.result == REAL and kind == INTEGER):
            raise self.refusal(statement, f"{ast.unparse(statement)!r}: all returns must give values of the same types")
