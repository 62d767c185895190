"""Statements of kernels in C."""

import ast
import re

from controllers.kernels.assignments import Assignments
from controllers.kernels.comments import plain, section
from controllers.kernels.literals import c_name
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
                allowed = "assignments, if, for over a range, return and calls; write a statement for each target"
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
        header, counter, natural, runs = self._loop_header(statement)
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

    def _loop_header(self, statement: ast.For) -> tuple[str, str, bool, bool | None]:
        """Return a loop's first line, its counter in C, whether that is natural, and whether it runs if that is known.

        Python evaluates the range once, C its end each time: what the end depends on must stay as it is in the loop.
        """
        start, end, stride, read = self._range(statement)
        assert isinstance(statement.target, ast.Name)
        target = statement.target.id
        inside = [node for part in statement.body for node in ast.walk(part) if isinstance(node, ast.Name)]
        changed = {node.id for node in inside if isinstance(node.ctx, ast.Store)}
        if fixed := (read | {target}) & changed - {"_"}:
            names = ", ".join(sorted(fixed))
            raise self.refusal(statement, f"{names} may not change in the loop over {ast.unparse(statement.iter)}")
        runs: bool | None = None
        if start.constant is not None and end.constant is not None:
            runs = start.constant < end.constant if stride == 1 else start.constant > end.constant
        name = self.scope.fresh("turn") if target == "_" and target in self.scope.variables else c_name(target)
        is_int = self.unit.fixed and (start.constant is not None or start.root in self.scope.counters)
        if is_int:
            self.scope.counters.add(target)
        natural = start.natural if stride == 1 else end.natural or end.constant == -1
        sign, change = ("<", "++") if stride == 1 else (">", "--")
        first = f"{'int' if is_int else 'int64_t'} {name} = {_literal(start)}"
        return f"for ({first}; {name} {sign} {_literal(end)}; {name}{change}) {{", name, natural, runs

    def _range(self, statement: ast.For) -> tuple[Value, Value, int, set[str]]:
        """Return start, end and stride of a range, and the names that these depend on."""
        call, shown = statement.iter, ast.unparse(statement).partition("\n")[0]
        if not isinstance(call, ast.Call) or not self._is_range(call) or not isinstance(statement.target, ast.Name):
            raise self.refusal(statement, f"{shown!r} has no translation; write for i in range(...)")
        ends = self.spread(call.args)
        stride = ends[2].constant if len(ends) == 3 else 1
        are_integers = 1 <= len(ends) <= 3 and all(end.type == INTEGER for end in ends)
        if not are_integers or stride not in (1, -1) or statement.orelse:
            rule = "a range must be of integers, by 1 or -1, without else"
            raise self.refusal(statement, f"{shown!r} has no translation; {rule}")
        read = {node.id for argument in call.args for node in ast.walk(argument) if isinstance(node, ast.Name)}
        start = ends[0] if len(ends) > 1 else Value("0", INTEGER, constant=0, natural=True)
        return start, ends[min(len(ends) - 1, 1)], stride, read

    def _is_range(self, call: ast.Call) -> bool:
        is_global = not call.keywords and self.is_global(call.func)
        return is_global and self.unit.resolved(self.kernel, call.func) is range

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
            raise self.refusal(statement, "a return without a value: put what follows into the other branch of an if")
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
            fields = zip(self.result.fields, values, strict=True)
            values = [self.as_real(statement, v) if k == REAL else v for (_, k), v in fields]
        for value in values:
            if value.type is None:
                raise self.refusal(self.kernel.tree, f"{value.text} cannot be returned; return its items")
        pairs = zip(self._names(values), values, strict=True)
        record = Record(f"{self.name}_result", tuple((name, value.type) for name, value in pairs))  # type: ignore[misc]
        self._agree(statement, record)
        self.scope.emit(f"return {self.unit.compound(record, values)};")

    def _agree(self, statement: ast.Return, kind: Type) -> None:
        if self.result is None:
            self.result = kind
        elif self.result != kind and not (self.result == REAL and kind == INTEGER):
            raise self.refusal(statement, f"{ast.unparse(statement)!r}: all returns must give values of the same types")

    def _names(self, values: list[Value]) -> list[str]:
        """Return names of several values after the docstring's returns, the variables returned, or what they are."""
        documented = list(section(self.kernel.function, "Returns"))
        if len(documented) == len(values) and all(name.isidentifier() for name in documented):
            return [c_name(name) for name in documented]
        returned = [node.value for node in ast.walk(self.kernel.tree) if isinstance(node, ast.Return)]
        names: list[str] = []
        for place, value in enumerate(values):
            items = [node.elts[place] for node in returned if isinstance(node, ast.Tuple) and place < len(node.elts)]
            candidates = {item.id if isinstance(item, ast.Name) else "" for item in items} - {"", *names}
            if len(candidates) == 1:
                name = candidates.pop()
            elif isinstance(value.type, Record) and value.type.origin is not None:
                name = re.findall(r"[A-Z][a-z0-9]*", value.type.name)[-1].lower()
            else:
                name = f"value{place + 1}"
            names.append(c_name(name if name not in names else f"value{place + 1}"))
        return names


def _literal(value: Value) -> str:
    """Return the text of an integer, of a known one as such, but for constants of modules, whose names say more."""
    plain = value.constant is None or value.text == value.text.upper()
    return value.text if plain else str(value.constant)
