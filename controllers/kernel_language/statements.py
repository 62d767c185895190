"""Statements of kernels."""

import ast
from dataclasses import dataclass, field
from typing import Any

from llvmlite import ir

from controllers.kernel_language.expressions import Expressions
from controllers.kernel_language.filling import fill
from controllers.kernel_language.kinds import INTEGER, WORD, Array, Kind, Line, Pointer, Record
from controllers.kernel_language.values import Value, Variable, constant


@dataclass(frozen=True)
class Loop:
    """A loop around what is translated now.

    Attributes
    ----------
    following, end : object
        Blocks that a turn goes on to, and that it may break off to.
    turns, breaks : list of set of str
        Variables that have a value where it does the one or the other.
    """

    following: Any
    end: Any
    turns: list[set[str]] = field(default_factory=list)
    breaks: list[set[str]] = field(default_factory=list)


class Statements:
    """Translates the statements of one kernel.

    Parameters
    ----------
    expressions : Expressions
        Translates its expressions.
    result : Kind, optional
        What it returns in a register; none where it returns something else, at an address.
    place : object
        That address.

    Attributes
    ----------
    result : Kind, optional
        What it returns, once a return statement has been translated.
    """

    def __init__(self, expressions: Expressions, result: Kind | None, place: Any) -> None:
        self.expressions, self.body, self.kernel = expressions, expressions.body, expressions.kernel
        self.result, self._target = result, place
        self._loops: list[Loop] = []
        self._within = 0
        self._gives_nothing = False

    def translate(self) -> None:
        """Translate the whole kernel."""
        statements = self.kernel.tree.body
        first = statements[0]
        is_docstring = isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant)
        self._block(statements[is_docstring:])
        if not self.body.ended:
            self._return_nothing(self.kernel.tree)

    def _block(self, statements: list[ast.stmt]) -> None:
        for statement in statements:
            if self.body.ended:
                return  # nothing comes here
            self._statement(statement)

    def _statement(self, statement: ast.stmt) -> None:
        match statement:
            case ast.If():
                self._if(statement)
            case ast.For():
                self._for(statement)
            case ast.While():
                self._while(statement)
            case ast.Return():
                self._return(statement)
            case ast.Assign(targets=[target]):
                self._assign(target, statement.value)
            case ast.Assign(targets=targets):
                value = self.body.copy(self.expressions.translate(statement.value))
                for target in targets:
                    self._store(target, value)
            case ast.AnnAssign(target=target, value=ast.expr() as value):
                self._assign(target, value)
            case ast.AugAssign():
                self._augmented(statement)
            case ast.Expr(value=ast.Call() as call):
                self.expressions.translate(call)
            case ast.Break() if self._loops:
                self._loops[-1].breaks.append(self.expressions.given)
                self.body.builder.branch(self._loops[-1].end)
            case ast.Continue() if self._loops:
                self._loops[-1].turns.append(self.expressions.given)
                self.body.builder.branch(self._loops[-1].following)
            case ast.Pass():
                pass
            case _:
                raise self._refusal(statement, "has no translation")

    def _refusal(self, statement: ast.stmt, problem: str) -> Exception:
        shown = ast.unparse(statement).partition("\n")[0]
        return self.kernel.refusal(statement, f"{shown!r} {problem}")

    def _if(self, statement: ast.If) -> None:
        test = self.expressions.condition(statement.test)
        if test.constant is not None:
            self._block(statement.body if test.constant else statement.orelse)
            return
        body, end = self.body, None
        then = body.block()
        other = body.block() if statement.orelse else (end := body.block())
        body.builder.cbranch(test.content, then, other)
        ends, before, given = [], self.expressions.given, []
        self._within += 1
        for statements, block in ((statement.body, then), (statement.orelse, other)):
            if not statements:
                given.append(before)
                continue
            body.continue_in(block)
            self.expressions.given = set(before)
            self._block(statements)
            if not body.ended:
                ends.append(body.builder.block)
                given.append(self.expressions.given)
        self._within -= 1
        self.expressions.given = set.intersection(*given) if given else before
        if end is None and ends:
            end = body.block()
        for block in ends:
            body.continue_in(block)
            body.go_on_to(end)
        if end is not None:
            body.continue_in(end)

    def _for(self, statement: ast.For) -> None:
        start, stop, stride = self._range(statement)
        body, target = self.body, statement.target
        assert isinstance(target, ast.Name)
        counter = body.room(INTEGER)
        body.write(start, counter)
        head, inner, following, end = (body.block() for _ in range(4))
        body.builder.branch(head)
        body.continue_in(head)
        now = Value(INTEGER, body.builder.load(counter), natural=start.natural and stride > 0)
        body.builder.cbranch(
            body.builder.icmp_signed("<" if stride > 0 else ">", now.content, stop.content), inner, end
        )
        body.continue_in(inner)
        before, loop = set(self.expressions.given), Loop(following, end)
        self._repeat(statement.body, loop, {target.id: now})
        body.continue_in(following)
        step = ir.Constant(WORD, stride)
        body.builder.store(body.builder.add(body.builder.load(counter), step, flags=["nsw"]), counter)
        body.builder.branch(head)
        body.continue_in(end)
        known = start.constant is not None and stop.constant is not None
        begins = known and (stop.constant - start.constant) * stride > 0
        self._leave(before, [*(loop.turns if begins and loop.turns else [before]), *loop.breaks])

    def _range(self, statement: ast.For) -> tuple[Value, Value, int]:
        call = statement.iter
        if not isinstance(call, ast.Call) or not self._is_range(call) or not isinstance(statement.target, ast.Name):
            raise self._refusal(statement, "has no translation; write for i in range(...)")
        ends = self.expressions.spread(call.args)
        stride = ends[2].constant if len(ends) == 3 else 1
        are_integers = 1 <= len(ends) <= 3 and all(end.kind is INTEGER for end in ends)
        if not are_integers or stride not in (1, -1) or statement.orelse:
            raise self._refusal(statement, "has no translation; a range must be of integers, by 1 or -1, without else")
        return (ends[0] if len(ends) > 1 else constant(0)), ends[min(len(ends) - 1, 1)], stride

    def _is_range(self, call: ast.Call) -> bool:
        is_global = not call.keywords and self.expressions.is_global(call.func)
        return is_global and self.expressions.resolved(call.func) is range

    def _while(self, statement: ast.While) -> None:
        if statement.orelse:
            raise self._refusal(statement, "has no translation with else")
        body = self.body
        head, inner, end = (body.block() for _ in range(3))
        body.builder.branch(head)
        body.continue_in(head)
        body.repeated += 1
        test = self.expressions.condition(statement.test)
        body.repeated -= 1
        body.builder.cbranch(test.content, inner, end)
        body.continue_in(inner)
        before, loop = set(self.expressions.given), Loop(head, end)
        self._repeat(statement.body, loop, {})
        body.continue_in(end)
        if test.constant is not True:
            self._leave(before, [before, *loop.breaks])
        elif loop.breaks:
            self._leave(before, loop.breaks)
        else:
            body.builder.unreachable()

    def _repeat(self, statements: list[ast.stmt], loop: Loop, counters: dict[str, Value]) -> None:
        """Translate the statements of a loop."""
        self._loops.append(loop)
        self.body.repeated += 1
        for name, value in counters.items():
            self._bind(name, value, statements[0])
        self._block(statements)
        if not self.body.ended:
            loop.turns.append(self.expressions.given)
        self.body.go_on_to(loop.following)
        self.body.repeated -= 1
        self._loops.pop()

    def _leave(self, before: set[str], ways: list[set[str]]) -> None:
        """Forget the variables that a loop gives no value on one of the ways out of it, or none that outlasts it."""
        places = self.expressions.variables
        given = {name for name in set.intersection(*ways) if isinstance(places[name], Variable)}
        self.expressions.given = before | given

    def _assign(self, target: ast.expr, node: ast.expr) -> None:
        if isinstance(target, ast.Subscript) and _is_full_slice(target.slice):
            value = self.expressions.translate(node)
            fill(self.body, target, self.expressions.translate(target.value), node, value)
        elif not isinstance(target, ast.Tuple):
            self._store(target, self.expressions.translate(node))
        else:
            if isinstance(node, ast.Tuple):
                values = [self.body.copy(value) for value in self.expressions.spread(node.elts)]
            else:
                values = self.expressions.items(node, self.expressions.translate(node))
            if len(values) != len(target.elts):
                raise self.kernel.refusal(target, f"{ast.unparse(target)}: there must be a value for each")
            for item, value in zip(target.elts, values, strict=True):
                self._store(item, value)

    def _store(self, target: ast.expr, value: Value) -> None:
        """Give a variable or an element of an array a value."""
        if isinstance(target, ast.Name):
            self._bind(target.id, value, target)
        else:
            place, kind = self._place(target)
            self.body.write(self.body.like(target, value, kind), place)

    def _place(self, target: ast.expr) -> tuple[Any, Kind]:
        """Return where an element of an array lies, and its kind."""
        shown = ast.unparse(target)
        if isinstance(target, ast.Tuple | ast.List | ast.Starred):
            raise self.kernel.refusal(target, f"{shown} cannot be one of several targets; write a statement for each")
        if not isinstance(target, ast.Subscript):
            raise self.kernel.refusal(target, f"{shown} cannot be assigned to; make a new NamedTuple")
        if any(isinstance(part, ast.Slice) for part in _parts(target.slice)):
            raise self.kernel.refusal(target, f"{shown} is a slice; write a loop over a range")
        owner = self.expressions.translate(target.value)
        if not isinstance(owner.kind, Array | Pointer):
            raise self.kernel.refusal(target, f"{shown} cannot be assigned to; make a new tuple")
        place = self.expressions.place(target, owner, self.expressions.indices(target))
        return place, owner.kind.element

    def _augmented(self, statement: ast.AugAssign) -> None:
        if isinstance(statement.target, ast.Name):
            old = self.expressions.translate(ast.copy_location(ast.Name(statement.target.id, ast.Load()), statement))
            value = self.expressions.translate(statement.value)
            self._bind(statement.target.id, self.expressions.combined(statement, statement.op, old, value), statement)
            return
        place, kind = self._place(statement.target)
        old = self.body.read(kind, place)
        new = self.expressions.combined(statement, statement.op, old, self.expressions.translate(statement.value))
        self.body.write(self.body.like(statement, new, kind), place)

    def _bind(self, name: str, value: Value, node: ast.AST) -> None:
        """Give a variable a value; what has only one ever, from here to the end, needs no place in memory."""
        if name == "_":
            return
        self.expressions.given.add(name)
        known = self.expressions.variables.get(name)
        if known is None:
            held = value.lasting or not isinstance(value.kind, Line | Record)
            once = self.expressions.stores[name] == 1
            if value.kind is None or (once and held and not self._is_passed_by):
                self.expressions.variables[name] = value
                return
            natural = value.natural and (once or self.expressions.counted[name] == self.expressions.stores[name])
            known = Variable(value.kind, self.body.room(value.kind), natural)
            self.expressions.variables[name] = known
        if not isinstance(known, Variable):
            raise self.kernel.refusal(node, f"{name} gets a value once more, and cannot; give each a name of its own")
        self.body.write(self.body.like(node, value, known.kind), known.place)

    @property
    def _is_passed_by(self) -> bool:
        """Whether what is translated now may be left out or repeated."""
        return self._within > 0 or self.body.repeated > 0

    def _return_nothing(self, node: ast.AST) -> None:
        if self._target is None or self.result is not None:
            raise self.kernel.refusal(node, "it must return a value at its end, as it does elsewhere")
        self._gives_nothing = True
        self.body.builder.ret_void()

    def _return(self, statement: ast.Return) -> None:
        node = statement.value
        if node is None or (isinstance(node, ast.Constant) and node.value is None):
            self._return_nothing(statement)
            return
        value = self.expressions.translate(node)
        if self.result is None:
            self.result = value.kind
        if self.result is None or self._gives_nothing:
            raise self._refusal(statement, "must return what other returns do, and that must have a value")
        value = self.body.like(node, value, self.result)
        if self._target is None:
            self.body.builder.ret(value.content)
        else:
            self.body.write(value, self.body.builder.bitcast(self._target, self.result.memory.as_pointer()))
            self.body.builder.ret_void()


def _is_full_slice(node: ast.expr) -> bool:
    return all(ast.unparse(part) == ":" for part in _parts(node))


def _parts(node: ast.expr) -> list[ast.expr]:
    return node.elts if isinstance(node, ast.Tuple) else [node]
