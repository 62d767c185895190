"""All functions of LLVM that an entry point needs, each kernel once for the kinds of its arguments."""

import ast
import inspect
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from llvmlite import ir

from controllers.kernel_language.body import Body
from controllers.kernel_language.expressions import Expressions
from controllers.kernel_language.kinds import (
    ADDRESS,
    BOOLEAN,
    DOUBLE,
    INTEGER,
    REAL,
    Array,
    Kind,
    Line,
    Pointer,
    Record,
    Scalar,
    record_of,
)
from controllers.kernel_language.sources import Kernel, read_kernel
from controllers.kernel_language.statements import Statements
from controllers.kernel_language.values import Value, Variable

DIRECT = {"float": REAL, "int": INTEGER, "bool": BOOLEAN}
"""Kinds that a kernel returns in a register, by its annotation."""


@dataclass(frozen=True)
class Function:
    """A translated kernel.

    Attributes
    ----------
    function : llvmlite function
        The function; it takes records and tuples by their address, arrays by their address and sizes.
    result : Kind, optional
        What it returns.
    direct : bool
        Whether it returns that in a register, not at the address that is its first argument.
    """

    function: Any
    result: Kind | None
    direct: bool


class Unit:
    """The functions of one entry point.

    Parameters
    ----------
    name : str
        Name of the entry point.

    Attributes
    ----------
    module : llvmlite module
        The functions.
    files : set of Path
        Files that the kernels stand in.
    meanings : dict
        What each global name that they ask for stands for, by module and name.
    """

    def __init__(self, name: str) -> None:
        self.module: Any = ir.Module(name)
        self.files: set[Path] = set()
        self.meanings: dict[tuple[str, str], str] = {}
        self._functions: dict[tuple[Any, ...], Function | None] = {}

    def mathematics(self, body: Body, name: str, *numbers: Any) -> Any:
        """Return what a function of real numbers gives."""
        kind = ir.FunctionType(DOUBLE, [DOUBLE] * len(numbers))
        function = self.module.globals.get(name)
        if function is None:
            function = ir.Function(self.module, kind, name)
            if name == "pow":  # LLVM would make roots, quotients and powers of two of it, with other last bits
                function.attributes.add("nobuiltin")
        return body.builder.call(function, numbers)

    def function(
        self, kernel: Callable[..., Any], kinds: tuple[Any, ...], caller: tuple[Kernel, ast.AST] | None = None
    ) -> Function:
        """Return a kernel for arguments of some kinds; it is translated when it is first met.

        Raises
        ------
        NotTranslatable
            It has no translation.
        """
        key = (kernel, *kinds)
        if key not in self._functions:
            self._functions[key] = None
            self._functions[key] = self._translated(read_kernel(kernel), kinds)
        made = self._functions[key]
        if made is None:
            assert caller is not None
            raise caller[0].refusal(caller[1], f"{kernel.__name__} calls itself; write a loop over a range")
        return made

    def _translated(self, kernel: Kernel, kinds: tuple[Kind, ...]) -> Function:
        self.files.add(kernel.file)
        returns = kernel.tree.returns
        direct = DIRECT.get(ast.unparse(returns) if returns else "")
        taken = [] if direct else [ADDRESS]
        for kind in kinds:
            taken += _taken(kind)
        signature = ir.FunctionType(direct.register if direct else ir.VoidType(), taken)
        function = ir.Function(self.module, signature, f"{kernel.name}.{len(self._functions)}")
        function.linkage = "internal"
        function.attributes.add("nounwind")
        function.attributes.add("alwaysinline")
        arguments = list(function.args)
        place = None if direct else arguments.pop(0)
        expressions = Expressions(self, Body(function, kernel))
        self._take(expressions, kinds, arguments)
        statements = Statements(expressions, direct, place)
        statements.translate()
        expressions.body.close()
        return Function(function, statements.result, direct is not None)

    def _take(self, expressions: Expressions, kinds: tuple[Kind, ...], arguments: list[Any]) -> None:
        """Make variables of the arguments of a function."""
        for name, kind in zip(inspect.signature(expressions.kernel.function).parameters, kinds, strict=True):
            if isinstance(kind, Array):
                value = Value(kind, tuple(arguments[: 1 + kind.ndim]))
                del arguments[: 1 + kind.ndim]
            else:
                value = Value(kind, arguments.pop(0), lasting=True)
            if isinstance(kind, Record | Line):
                value.content.attributes.add("noalias")
            expressions.variables[name] = value
            expressions.given.add(name)
            if expressions.stores[name]:
                if name == "_":
                    raise expressions.refusal(expressions.kernel.tree, "_ keeps no value; give the argument a name")
                variable = Variable(kind, expressions.body.room(kind))
                expressions.body.write(value, variable.place)
                expressions.variables[name] = variable

    def entry(self, kernel: Callable[..., Any], kinds: tuple[Kind, ...], name: str) -> Kind | None:
        """Add a function for C, ``void name(arguments, result)``, that calls a kernel; return what it gives.

        Arguments are the fields of a struct, as is the result.
        """
        made, taken = self.function(kernel, kinds), record_of(None, kinds)
        function = self._function_for_c(name, [ADDRESS, ADDRESS])
        body = Body(function, read_kernel(kernel))
        given, result = function.args
        record = Value(taken, body.builder.bitcast(given, taken.memory.as_pointer()))
        arguments: list[Any] = []
        for place, kind in enumerate(kinds):
            content = body.member(record, place).content
            arguments += content if isinstance(kind, Array) else [content]
        if made.direct:
            assert made.result is not None
            value = Value(made.result, body.builder.call(made.function, arguments))
            body.write(value, body.builder.bitcast(result, made.result.memory.as_pointer()))
        else:
            body.builder.call(made.function, [result, *arguments])
        body.builder.ret_void()
        body.close()
        return made.result

    def exported(self, kernel: Callable[..., Any], kinds: tuple[Kind, ...], name: str) -> None:
        """Add a function for C, ``void name(arguments...)``, that calls a kernel which returns nothing."""
        made = self.function(kernel, kinds)
        taken = [part for kind in kinds for part in _taken(kind)]
        function = self._function_for_c(name, taken)
        builder = ir.IRBuilder(function.append_basic_block())
        builder.call(made.function, [ir.Constant(ADDRESS, None), *function.args])
        builder.ret_void()

    def _function_for_c(self, name: str, taken: list[Any]) -> Any:
        """Return a function without a body that returns nothing; what its arguments point to is reached by them alone.

        Without that promise all of parameters and state would be read, or kept, anew after each number that is written
        to an array.
        """
        function = ir.Function(self.module, ir.FunctionType(ir.VoidType(), taken), name)
        for argument in function.args:
            if argument.type.is_pointer:
                argument.attributes.add("noalias")
        return function


def _taken(kind: Kind) -> list[Any]:
    """Return types of the arguments of a function that stand for one of a kernel."""
    if isinstance(kind, Array):
        return list(kind.parts)
    if isinstance(kind, Scalar):
        return [kind.register]
    return [kind.memory] if isinstance(kind, Pointer) else [kind.memory.as_pointer()]
