"""One kernel as a function in C."""

import inspect
import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from adaptive_ff.export.comments import block_comment, wrapped_code
from adaptive_ff.export.expressions import Expressions
from adaptive_ff.export.names import c_name
from adaptive_ff.export.results import ResultNames
from adaptive_ff.export.scope import Declaration, Scope, Unused, Variable
from adaptive_ff.export.statements import Statements
from adaptive_ff.export.types import Line, Record, Type, passed_by_pointer
from controllers.kernel_language.sources import Kernel

if TYPE_CHECKING:
    from adaptive_ff.export.unit import Unit


@dataclass(frozen=True)
class Function:
    """A function of C.

    Attributes
    ----------
    name : str
        Its name.
    result : Type, optional
        What it returns; none for one that changes arrays in place only.
    kernel : Kernel
        What it was translated from.
    text : str
        Its definition with its comment.
    writes : bool
        Whether it changes arrays in place.
    constant : int, optional
        What it returns, where that is an integer or truth value that is known at translation.
    """

    name: str
    result: Type | None
    kernel: Kernel
    text: str
    writes: bool
    constant: int | None = None


def translate_function(
    unit: "Unit", kernel: Kernel, kinds: tuple[Type, ...], constants: tuple[int | None, ...], name: str
) -> Function:
    """Translate a kernel for arguments of some types, some of them known; ``NotExportable`` where it cannot be."""
    arguments = kernel.tree.args
    if arguments.vararg or arguments.kwarg or arguments.posonlyargs:
        raise kernel.refusal(kernel.tree, "its arguments must be named one by one")
    scope = Scope(kernel)
    declared, opening = [], []
    given_all = zip([*arguments.args, *arguments.kwonlyargs], kinds, constants, strict=True)
    for argument, kind, known in given_all:
        wish = c_name(argument.arg)
        if not passed_by_pointer(kind):
            declared.append(unit.declaration(kind, wish))
            scope.variables[argument.arg] = Variable(wish, kind, constant=None if scope.stores[argument.arg] else known)
        elif scope.stores[argument.arg]:
            given = scope.fresh(f"given_{argument.arg}")
            declared.append(f"const {unit.c_type(kind)} *{given}")
            opening.append((1, f"{unit.c_type(kind)} {wish} = *{given};"))
            scope.variables[argument.arg] = Variable(wish, kind)
        else:
            declared.append(f"const {unit.c_type(kind)} *{wish}")
            scope.variables[argument.arg] = Variable(wish, kind, pointer=True)
        scope.declare(argument.arg)
    statements = Statements(Expressions(unit, scope), ResultNames(name))
    statements.body()
    code = [item for _, item in scope.lines if isinstance(item, str) and not item.startswith("/*")]
    texts = code + [text for _, text in opening]
    for argument in [*arguments.args, *arguments.kwonlyargs]:
        if not _uses(texts, c_name(argument.arg)):
            opening.append((1, f"(void){c_name(argument.arg)};"))
    result = statements.result
    returned = "void" if result is None else unit.c_type(result) if isinstance(result, Record | Line) else ""
    head = f"{returned} {name}" if returned else unit.declaration(result, name) if result else name
    lines = [f"static inline {head}({', '.join(declared) or 'void'})", "{"]
    lines += [f"{'    ' * depth}{text}" for depth, text in opening]
    for depth, item in scope.lines:
        if isinstance(item, Unused):
            if _uses(texts, c_name(item.name)) > 1:
                continue  # its declaration is one
            item = f"(void){c_name(item.name)};"
        if isinstance(item, Declaration):
            variable = scope.variables.get(item.name)
            if variable is None:
                continue  # its only values are in branches for other sizes
            item = f"{unit.declaration(variable.type, variable.name)};"
        lines.append(f"{'    ' * depth}{item}")
    lines.append("}")
    text = "\n".join(piece for line in lines for piece in wrapped_code(line)) + "\n"
    comment = block_comment(inspect.getdoc(kernel.function) or "")
    return Function(name, result, kernel, comment + text, scope.writes, statements.constant)


def _uses(texts: list[str], name: str) -> int:
    """Return how many lines name a variable, which a field of the same name does not."""
    return sum(bool(re.search(rf"(?<![.>\w]){name}\b", text)) for text in texts)
