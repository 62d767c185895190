"""One kernel as a function in C."""

import inspect
import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from controllers.kernels.comments import comment_lines, wrapped_code
from controllers.kernels.literals import c_name, function_name
from controllers.kernels.scope import Later, Scope, Variable
from controllers.kernels.sources import Kernel, read_kernel
from controllers.kernels.statements import Statements
from controllers.kernels.types import INTEGER, Line, Record, Type, passed_by_pointer
from controllers.kernels.unit import Function, Known, Unit


class Translator(Unit):
    """A unit that translates the kernels that it is asked for, and those that they call."""

    def function(
        self,
        function: Callable[..., Any],
        kinds: tuple[Type, ...],
        constants: tuple[Known, ...] = (),
        caller: tuple[Kernel, Any] | None = None,
    ) -> Function:
        """Return a kernel in C for arguments of some types; it is translated when it is first met.

        Arguments that are known integers, such as sizes, decide branches within it, as they do at the call.
        """
        key = (function, kinds, constants or (None,) * len(kinds))
        if key not in self.functions:
            kernel = read_kernel(function)
            if function in self._pending and caller is not None:
                raise caller[0].refusal(caller[1], f"{kernel.name} calls itself; write a loop over a range")
            self._pending.append(function)
            outer, self.files, self.meanings = (self.files, self.meanings), {kernel.file}, {}
            made = _translated(self, kernel, kinds, key[2], self._function_name(function))
            self.functions[key] = replace(made, files=frozenset(self.files), meanings=self.meanings)
            self.files, self.meanings = outer
            self._pending.pop()
        made = self.functions[key]
        self.files |= made.files
        self.meanings |= made.meanings
        return made

    def _function_name(self, function: Callable[..., Any]) -> str:
        taken = {made.name: origin for (origin, _, _), made in self.functions.items()}
        name = function_name(function.__name__)
        if name in taken and taken[name] is not function:
            name = f"{function.__module__.rpartition('.')[2]}_{name}"
        count, base = 1, name
        while name in taken:
            count += 1
            name = f"{base}_{count}"
        return name


def _translated(unit: Unit, kernel: Kernel, kinds: tuple[Type, ...], constants: tuple[Any, ...], name: str) -> Function:
    """Translate a kernel for arguments of some types, some of them known; ``NotTranslatable`` where it cannot be."""
    arguments = kernel.tree.args
    if arguments.vararg or arguments.kwarg or arguments.posonlyargs:
        raise kernel.refusal(kernel.tree, "its arguments must be named one by one")
    scope = Scope(kernel)
    declared, opening = [], []
    given_all = zip([*arguments.args, *arguments.kwonlyargs], kinds, constants, strict=True)
    restrict = "" if unit.fixed else "restrict "  # records never change, nor overlap with what does
    for argument, kind, known in given_all:
        wish = c_name(argument.arg)
        if argument.arg == "_" and scope.stores["_"]:
            raise kernel.refusal(kernel.tree, "_ keeps no value; give the argument a name")
        if not passed_by_pointer(kind):
            declared.append(unit.declaration(kind, wish))
            changes, is_value = scope.stores[argument.arg] > 0, isinstance(known, int | float)
            constant = known if is_value and not changes else None
            natural = kind == INTEGER and not changes and known is not None and (not is_value or known >= 0)
            scope.variables[argument.arg] = Variable(wish, kind, constant=constant, natural=natural)
        elif scope.stores[argument.arg]:
            given = scope.fresh(f"given_{argument.arg}")
            declared.append(f"const {unit.c_type(kind)} *{restrict}{given}")
            opening.append((1, f"{unit.c_type(kind)} {wish} = *{given};"))
            scope.variables[argument.arg] = Variable(wish, kind)
        else:
            declared.append(f"const {unit.c_type(kind)} *{restrict}{wish}")
            scope.variables[argument.arg] = Variable(wish, kind, pointer=True)
        scope.declared.add(argument.arg)
        scope.given.add(argument.arg)
    statements = Statements(unit, scope, name)
    statements.body()
    code = [item for _, item in scope.lines if isinstance(item, str) and not item.startswith("/*")]
    texts = code + [text for _, text in opening]
    for argument in [*arguments.args, *arguments.kwonlyargs] if unit.fixed else []:  # compilers warn of what is unused
        if not _uses(texts, c_name(argument.arg)):
            opening.append((1, f"(void){c_name(argument.arg)};"))
    result = statements.result
    returned = "void" if result is None else unit.c_type(result) if isinstance(result, Record | Line) else ""
    head = f"{returned} {name}" if returned else unit.declaration(result, name) if result else name
    static = "static inline" if unit.fixed else "KERNEL"
    lines = [f"{static} {head}({', '.join(declared) or 'void'})", "{"]
    lines += [f"{'    ' * depth}{text}" for depth, text in opening]
    for depth, item in scope.lines:
        if isinstance(item, Later) and item.declares:
            variable = scope.variables.get(item.name)
            if variable is None:
                continue  # its only values are in branches for other sizes
            item = f"{unit.declaration(variable.type, variable.name)};"
        elif isinstance(item, Later):
            if not unit.fixed or _uses(texts, c_name(item.name)) > 1:
                continue  # its declaration is one
            item = f"(void){c_name(item.name)};"
        lines.append(f"{'    ' * depth}{item}")
    lines.append("}")
    if unit.fixed:
        lines = [part for line in lines for part in wrapped_code(line)]
    text = "\n".join(lines) + "\n"
    comment = comment_lines(inspect.getdoc(kernel.function) or "") if unit.fixed else ""
    natural = result == INTEGER and statements.natural
    return Function(name, result, kernel, comment + text, scope.writes > 0, statements.constant, natural)


def _uses(texts: list[str], name: str) -> int:
    """Return how many lines name a variable, which a field of the same name does not."""
    return sum(bool(re.search(rf"(?<![.>\w]){name}\b", text)) for text in texts)
