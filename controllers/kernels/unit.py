"""A translation unit: the kernels that are asked for, what they call and what that needs, in an order that C takes."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from controllers.kernels.printer import Printer
from controllers.kernels.sources import Kernel, read_kernel
from controllers.kernels.statements import Statements
from controllers.kernels.text import Precision, comment_lines, function_name
from controllers.kernels.tree import Function
from controllers.kernels.types import Symbols, Type

Known = float | str | None
"""What is known of a number at translation: its value, ``natural`` where it is not negative, or nothing."""

Key = tuple[Callable[..., Any], tuple[Type, ...], tuple[Known, ...]]
"""A kernel with the types of its arguments, and what is known of them."""


class Unit(Printer):
    """Translates kernels, and those that they call, each once for types of arguments."""

    def __init__(self, precision: Precision, prefix: str, *, fixed: bool) -> None:
        super().__init__(precision, prefix, fixed=fixed)
        self.functions: dict[Key, Function] = {}
        self.symbols = Symbols(fixed=fixed)
        self.files: set[Path] = set()
        self.meanings: dict[tuple[str, str], str] = {}
        self._origins: dict[str, Callable[..., Any]] = {}  # what each name in C stands for
        self._pending: list[Callable[..., Any]] = []

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
            reader = Statements(kernel, self.symbols, self.function)
            read = reader.function(kinds, key[2], self._function_name(function))
            for kind in self.symbols.types:
                self.struct(kind)
            self.symbols.types.clear()
            text, files = self.definition(read), frozenset(reader.files)
            self.functions[key] = replace(read, text=text, files=files, meanings=reader.meanings)
            self._pending.pop()
        made = self.functions[key]
        self.files |= made.files
        self.meanings |= made.meanings
        return made

    def _function_name(self, function: Callable[..., Any]) -> str:
        name = function_name(function.__name__)
        if self._origins.get(name, function) is not function:
            name = f"{function.__module__.rpartition('.')[2]}_{name}"
        count, base = 1, name
        while name in self._origins:
            count += 1
            name = f"{base}_{count}"
        self._origins[name] = function
        return name

    def definitions(self) -> str:
        """Return all constants, in firmware with what is said of them, of those that stand together once."""
        lines, last = [], ""
        for name, constant in sorted(self.symbols.constants.items()):
            if self.fixed and constant.doc and constant.doc != last:
                lines += comment_lines(constant.doc).splitlines()
            last = constant.doc
            text = self.precision.literal(constant.value, name)
            lines.append(f"#define {name} {f'({text})' if text.startswith('-') else text}")
        return "\n".join(lines)

    def called_in(self, code: str) -> list[Function]:
        """Return the functions that some code needs, callees first; of those that give a known number it needs none."""
        made = {function.name: function for function in self.functions.values()}
        pending, used = [code], set[str]()
        while pending:
            code = re.sub(r"/\*.*?\*/", "", pending.pop(), flags=re.DOTALL)
            new = {name for name in re.findall(r"\b(\w+)\(", code) if name in made} - used
            used |= new
            pending += [made[name].text for name in new]
        return [function for name, function in made.items() if name in used]
