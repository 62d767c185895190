"""Statements of kernels, read into a typed tree: which variables there are, where they have a value, what is given."""

import ast
import re
from collections import Counter
from functools import cache
from typing import Any

from controllers.kernels.calls import Calls
from controllers.kernels.expressions import ARITHMETIC
from controllers.kernels.text import c_name, plain, section
from controllers.kernels.tree import Do, For, Function, Give, If, Let, Node, Statement, Variable, While, number
from controllers.kernels.types import BOOLEAN, INTEGER, REAL, Array, Line, Record, Type, passed_by_pointer

ANNOTATED = {"float": REAL, "int": INTEGER, "bool": BOOLEAN}
"""What a kernel returns, by its annotation."""


class Statements(Calls):
    """Reads one function."""

    def function(self, kinds: tuple[Type, ...], constants: tuple[Any, ...], name: str) -> Function:
        """Return the function for arguments of some types, some of them known."""
        tree = self.kernel.tree
        arguments = tree.args
        if arguments.vararg or arguments.kwarg or arguments.posonlyargs:
            raise self.refusal(tree, "its arguments must be named one by one")
        self.name = name
        self.result: Type | None = ANNOTATED.get(ast.unparse(tree.returns) if tree.returns else "")
        self.returned: list[Node] = []
        self.ended = False  # whether nothing can follow here
        # those around this place, innermost last: variables that have a value where each goes on, and breaks off
        self.loops: list[tuple[list[set[str]], list[set[str]]]] = []
        self.declared: dict[str, Variable] = {}
        self.counters = Counter(ast.unparse(node.target) for node in self.kernel.nodes if isinstance(node, ast.For))
        self.comments = dict(self.kernel.comments) if self.symbols.fixed else {}  # those that are not written yet
        given_all = zip([*arguments.args, *arguments.kwonlyargs], kinds, constants, strict=True)
        taken = [self._argument(argument.arg, kind, known) for argument, kind, known in given_all]
        first = tree.body[0]
        has_docstring = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant)
        self._sequence(tree.body[has_docstring:])
        if not self.ended and self.result is not None:
            raise self.refusal(tree, "it must return a value at its end, as it does elsewhere")
        constant, natural = None, self.result == INTEGER and all(value.natural for value in self.returned)
        if len(self.returned) == 1 and not self.writes and self.result == self.returned[0].type != REAL:
            constant = self.returned[0].constant
        return Function(name, self.kernel, taken, self.result, self.body, self.writes > 0, constant, natural)

    def _argument(self, name: str, kind: Type, known: Any) -> Variable:
        self.symbols.note(kind)
        changes = self.stores[name] > 0
        if name == "_" and changes:
            raise self.refusal(self.kernel.tree, "_ keeps no value; give the argument a name")
        variable = self.variables[name] = self.declared[name] = Variable(c_name(name), kind)
        self.given.add(name)
        if passed_by_pointer(kind) and changes:
            given = Variable(self.fresh(f"given_{name}"), kind, is_pointer=True)
            self.let(variable, given.value, False)
            return given
        variable.is_pointer = passed_by_pointer(kind)
        if kind in (INTEGER, REAL) and not changes and known is not None:
            variable.constant = known if isinstance(known, int | float) else None
            variable.natural = kind == INTEGER and (variable.constant is None or variable.constant >= 0)
        return variable

    def _inner(self, statements: list[ast.stmt]) -> list[Statement]:
        """Return the statements of a body of their own."""
        outer, self.body = self.body, []
        self._sequence(statements)
        body, self.body = self.body, outer
        return body

    def _sequence(self, statements: list[ast.stmt]) -> None:
        """Read the statements of a sequence, up to one behind which nothing comes."""
        for statement in statements:
            if self.ended:
                return
            self._comments_above(statement)
            head = getattr(statement, "test", getattr(statement, "iter", None))
            self.statement = ast.Expr(head) if head else statement
            if isinstance(statement, ast.If):
                self._if(statement)
                continue
            if isinstance(statement, ast.For | ast.While):
                self._announce(statement)
            start = len(self.body)
            self._statement(statement)
            self._comment_beside(statement, start)

    def _statement(self, statement: ast.stmt) -> None:
        match statement:
            case ast.Return():
                self._return(statement)
            case ast.Assign(targets=[target], value=value) | ast.AnnAssign(target=target, value=ast.expr() as value):
                self._assign(target, value)
            case ast.AugAssign():
                self._augment(statement)
            case ast.Expr(value=ast.Call() as call):
                self.body.append(Do(self.read(call)))
            case ast.For():
                self._for(statement)
            case ast.While() if not self.symbols.fixed:
                self._while(statement)
            case ast.Break() | ast.Continue() if self.loops:
                self.loops[-1][isinstance(statement, ast.Break)].append(set(self.given))
                self.body.append(f"{ast.unparse(statement)};")
                self.ended = True
            case ast.Pass():
                pass
            case _:
                shown = ast.unparse(statement).partition("\n")[0]
                allowed = "assignments, if, for over a range, return and calls; write a statement for each target"
                if isinstance(statement, ast.While):
                    allowed += "; in firmware a loop over a range replaces while"
                raise self.refusal(statement, f"{shown!r} has no translation; there are {allowed}")

    def _announce(self, statement: ast.If | ast.For | ast.While) -> None:
        """Declare variables that get their first value within a statement and are used outside of its bodies."""
        inner = [Counter(_names(body)) for body in (statement.body, statement.orelse)]
        for name in _names([statement], ast.Store):
            is_new = name != "_" and name not in self.declared and self.counters[name] < self.stores[name]
            if is_new and all(body[name] < self.uses[name] for body in inner):  # a loop declares its counter
                self.declared[name] = Variable(c_name(name), None)
                self.body.append(Let(self.declared[name]))

    def _comments_above(self, statement: ast.stmt) -> None:
        line, found = statement.lineno - 1, list[Statement]()
        while self.comments.get(line, ("", False))[1]:
            found.insert(0, f"/* {plain(self.comments.pop(line)[0])} */")
            line -= 1
        self.body += found

    def _comment_beside(self, statement: ast.stmt, start: int) -> None:
        """Note the comment beside a statement, above what it became."""
        last = statement.lineno if isinstance(statement, ast.For | ast.If) else statement.end_lineno
        lines = [line for line in range(statement.lineno, (last or 0) + 1) if line in self.comments]
        texts = "; ".join(plain(self.comments.pop(line)[0]) for line in lines)
        if texts and len(self.body) > start:
            self.body.insert(start, f"/* {texts} */")

    def _assign(self, target: ast.expr, node: ast.expr) -> None:
        if isinstance(target, ast.Tuple):
            self._unpack(target, node)
            return
        writes, value = self.writes, self.read(node)  # before the place where it goes, as Python does
        inner = any(isinstance(part, ast.Call | ast.Subscript) and part is not target for part in ast.walk(target))
        if self.writes > writes and inner:
            value = self._kept(node, value)
        if isinstance(value.type, Record | Line) and isinstance(target, ast.Subscript):
            self._give_row(target, node, value)
        else:
            self._give(target, value)

    def _give(self, target: ast.expr, value: Node) -> None:
        """Give a target, perhaps one of several, its value."""
        if isinstance(target, ast.Name):
            self._bind(target, value)
            return
        if isinstance(target, ast.Tuple | ast.List | ast.Starred):
            raise self.refusal(target, "{} cannot be one of several targets; write a statement for each")
        place = self._place(target)
        value = self.agreeing(target, value, place.type)
        if place.type != value.type:
            raise self.refusal(target, "{} must be given a value of the array's type")
        self.body.append(Give(place, value))

    def _place(self, target: ast.expr) -> Node:
        """Return an element of an array that is to be changed."""
        if not isinstance(target, ast.Subscript):
            raise self.refusal(target, "{} cannot be assigned to; make a new NamedTuple")
        base = self.read(target.value)
        if not isinstance(base.type, Array):
            raise self.refusal(target, "{} cannot be assigned to; make a new tuple")
        place = self.element_of(target, self.placed(target, base))
        if isinstance(place.type, Array):
            raise self.refusal(target, "{} is no number of an array; give an index for each dimension")
        self.writes += 1
        return place

    def _give_row(self, target: ast.Subscript, node: ast.expr, value: Node) -> None:
        """Give the numbers of a tuple to a row of an array, one after another."""
        row = self.element_of(target, self.read(target.value))
        if not isinstance(row.type, Array) or len(row.type.shape) != 1:
            raise self.refusal(target, "{} cannot be given a tuple; only a row of an array can")
        self.writes += 1
        for place, item in enumerate(self.items(node, value)):
            given = self.agreeing(node, item, row.type.element)
            if given.type != row.type.element:
                raise self.refusal(node, "{} holds what are no numbers of the array's type")
            self.body.append(Give(row.element(number(place)), given))

    def _bind(self, target: ast.Name, value: Node) -> None:
        """Give a variable a value, and declare it where that is its first."""
        name, kind = target.id, value.type
        if name == "_":
            return
        if kind is None:
            raise self.refusal(target, f"{name}: a shape or a tuple of constants has no value; use its items")
        known = self.variables.get(name)
        if known is not None and known.type != kind:
            if (known.type, kind) != (REAL, INTEGER):
                raise self.refusal(target, f"{name} changes its type; begin with 0.0 for a real number")
            value = self.as_real(target, value)
        self.given.add(name)
        once = self.stores[name] == 1
        if name in self.declared:
            variable = self.variables.setdefault(name, self.declared[name])
            if known is None:
                variable.type = kind
                variable.natural = value.natural and (once or self.counters[name] == self.stores[name])
            self.body.append(Give(variable.value, value))
            return
        variable = self.variables[name] = self.declared[name] = Variable(c_name(name), kind)
        variable.natural = value.natural and once
        if once and passed_by_pointer(kind):
            variable.is_pointer = value.root is not None and value.root.is_pointer
        elif once and kind in (INTEGER, REAL):
            variable.constant = value.constant
        self.let(variable, value, once)

    def _unpack(self, target: ast.Tuple, node: ast.expr) -> None:
        if isinstance(node, ast.Tuple):
            values = self.spread(node.elts)
            if len(values) != len(target.elts):
                raise self.refusal(target, "{}: there must be a value for each")
            if _overlap(target, node):
                values = [self._kept(node, value) for value in values]
        else:
            values = self.items(node, self.read(node), len(target.elts))
        for item, value in zip(target.elts, values, strict=True):
            self._give(item, value)

    def _kept(self, node: ast.expr, value: Node) -> Node:
        if isinstance(value.type, Array) and not value.type.is_open:
            raise self.refusal(node, "{}: give arrays their names one by one")
        return self.named(node, value)

    def _augment(self, statement: ast.AugAssign) -> None:
        target, shown = statement.target, ast.unparse(statement.target)
        if type(statement.op) not in ARITHMETIC:
            raise self.refusal(statement, "{}: there are += -= *= and /=")
        sign = ARITHMETIC[type(statement.op)][0]
        place = self.read(target) if isinstance(target, ast.Name) else self._place(target)
        value = self.read(statement.value)
        if place.type not in (REAL, INTEGER):
            raise self.refusal(statement, f"{shown} is no number")
        if place.type == INTEGER and (value.type != INTEGER or sign == "/"):
            raise self.refusal(statement, f"{shown} changes its type; begin with 0.0")
        self.body.append(Give(place, self.agreeing(statement.value, value, place.type), sign))

    def _if(self, statement: ast.If) -> None:
        test = self.condition(statement.test)
        if test.constant is not None:  # sizes decide it: the other branch is for other sizes
            self._sequence(statement.body if test.constant else statement.orelse)
            return
        self._announce(statement)
        before, ways, bodies = self.given, [], []
        for body in (statement.body, statement.orelse):
            self.given = set(before)
            bodies.append(self._inner(body))
            ways += [] if self.ended else [self.given]
            self.ended = False
        self.body.append(If(test, *bodies))
        self._comment_beside(statement, len(self.body) - 1)
        self._go_on(ways, before)

    def _go_on(self, ways: list[set[str]], before: set[str]) -> None:
        """Note which variables have a value behind a statement that is left on some ways, or on none."""
        self.given, self.ended = set.intersection(*ways) if ways else before, not ways

    def _for(self, statement: ast.For) -> None:
        counter, start, end, stride = self._header(statement)
        assert isinstance(statement.target, ast.Name)
        name, before, runs = statement.target.id, set(self.given), None
        if start.constant is not None and end.constant is not None:
            runs = (end.constant - start.constant) * stride > 0
        outer, self.variables[name] = self.variables.get(name), counter
        self.given.add(name)
        if runs is False:
            self.given = before
        else:
            body, turns, breaks = self._repeat(statement)
            self.body.append(For(counter, start, end, stride, body))
            self.given = set.intersection(*(turns if runs and turns else [before]), *breaks)
        self.given.discard(name)  # a counter is that of its loop
        del self.variables[name]
        if outer is not None:
            self.variables[name] = outer

    def _header(self, statement: ast.For) -> tuple[Variable, Node, Node, int]:
        """Return a loop's counter, its start, its end and its stride.

        Python evaluates the range once, C its end each time: what the end depends on must stay as it is in the loop.
        """
        call, shown = statement.iter, ast.unparse(statement).partition("\n")[0]
        if not isinstance(call, ast.Call) or not self._is_range(call) or not isinstance(statement.target, ast.Name):
            raise self.refusal(statement, f"{shown!r} has no translation; write for i in range(...)")
        ends, target = self.spread(call.args), statement.target.id
        stride = ends[2].constant if len(ends) == 3 else 1
        are_integers = 1 <= len(ends) <= 3 and all(end.type == INTEGER for end in ends)
        if not are_integers or stride not in (1, -1) or statement.orelse:
            rule = "a range must be of integers, by 1 or -1, without else"
            raise self.refusal(statement, f"{shown!r} has no translation; {rule}")
        changed = {target, *_names(call.args)} & set(_names(statement.body, ast.Store)) - {"_"}
        if changed:
            names = ", ".join(sorted(changed))
            raise self.refusal(statement, f"{names} may not change in the loop over {ast.unparse(call)}")
        start, end = ends[:2] if len(ends) > 1 else (number(0), ends[0])
        name = self.fresh("turn") if target == "_" and target in self.variables else c_name(target)
        is_natural = start.natural if stride == 1 else end.natural or end.constant == -1
        is_int = start.constant is not None or (start.variable is not None and start.variable.is_int)
        return Variable(name, INTEGER, natural=is_natural, is_int=self.symbols.fixed and is_int), start, end, stride

    def _is_range(self, call: ast.Call) -> bool:
        return not call.keywords and self.is_global(call.func) and self.resolved(call.func) is range

    def _while(self, statement: ast.While) -> None:
        self.conditional += 1  # nothing may be computed before a test that is made anew each time
        test = self.condition(statement.test)
        self.conditional -= 1
        if statement.orelse:
            raise self.refusal(statement, "while has no translation with else")
        before = set(self.given)
        if test.constant is False:
            return
        body, _, breaks = self._repeat(statement)
        self.body.append(While(test, body))
        self._go_on([*([] if test.constant is True else [before]), *breaks], before)

    def _repeat(self, statement: ast.For | ast.While) -> tuple[list[Statement], list[set[str]], list[set[str]]]:
        """Return the statements of a loop, and what has a value where it goes on and where it breaks off."""
        turns, breaks = list[set[str]](), list[set[str]]()
        self.loops.append((turns, breaks))
        body = self._inner(statement.body)
        self.loops.pop()
        if not self.ended:
            turns.append(self.given)
        self.ended = False
        return body, turns, breaks

    def _return(self, statement: ast.Return) -> None:
        node = statement.value
        self.ended = True
        if node is None or (isinstance(node, ast.Constant) and node.value is None):
            raise self.refusal(statement, "a return without a value: put what follows into the other branch of an if")
        if isinstance(node, ast.Tuple) and not any(isinstance(item, ast.Starred) for item in node.elts):
            value = self._several(statement, [self.read(item) for item in node.elts])
        else:
            value = self.read(node)
            if isinstance(value.type, Record) and value.type.origin is None:  # what another function returned
                value = self._several(statement, self.items(node, value))
        if value.type is None:
            raise self.refusal(statement, "a shape or a tuple of constants cannot be returned")
        if self.result is None:
            self.result = value.type
        elif self.result != value.type and (self.result, value.type) != (REAL, INTEGER):
            raise self.refusal(statement, f"{ast.unparse(statement)!r}: all returns must give values of the same types")
        self.returned.append(value)
        self.body.append(Do(self.agreeing(node, value, self.result), "return "))

    def _several(self, statement: ast.Return, values: list[Node]) -> Node:
        if isinstance(self.result, Record) and len(self.result.fields) == len(values):
            kinds = [kind for _, kind in self.result.fields]
            values = [self.agreeing(statement, value, kind) for kind, value in zip(kinds, values, strict=True)]
        return self.record(statement, f"{self.name}_result", self._result_names(values), values)

    def _result_names(self, values: list[Node]) -> list[str]:
        """Return names of several values after the docstring's returns, the variables returned, or what they are."""
        documented = list(section(self.kernel.function, "Returns"))
        if len(documented) == len(values) and all(name.isidentifier() for name in documented):
            return [c_name(name) for name in documented]
        returned = [node.value for node in self.kernel.nodes if isinstance(node, ast.Return)]
        names: list[str] = []
        for place, value in enumerate(values):
            items = [node.elts[place] for node in returned if isinstance(node, ast.Tuple) and place < len(node.elts)]
            candidates = {item.id if isinstance(item, ast.Name) else "" for item in items} - {"", *names}
            name = f"value{place + 1}"
            if len(candidates) == 1:
                name = candidates.pop()
            elif isinstance(value.type, Record) and value.type.origin is not None:
                name = re.findall(r"[A-Z][a-z0-9]*", value.type.name)[-1].lower()
            names.append(c_name(name if name not in names else f"value{place + 1}"))
        return names


def _names(nodes: list[Any], context: type = ast.expr_context) -> list[str]:
    """Return the names in some nodes, as often as they stand there."""
    return [name.id for each in nodes for name in _within(each) if isinstance(name.ctx, context)]


@cache
def _within(node: ast.AST) -> list[ast.Name]:
    return [each for each in ast.walk(node) if isinstance(each, ast.Name)]


def _overlap(target: ast.Tuple, node: ast.Tuple) -> bool:
    """Tell whether a value may depend on a target before it: Python computes all values first."""
    stored = {item.id for item in target.elts if isinstance(item, ast.Name)}
    elements = any(isinstance(item, ast.Subscript) for item in target.elts)
    later = [leaf for value in node.elts[1:] for leaf in ast.walk(value)]
    read = elements and any(isinstance(leaf, ast.Subscript | ast.Call) for leaf in later)
    return read or any(isinstance(leaf, ast.Name) and leaf.id in stored for leaf in later)
