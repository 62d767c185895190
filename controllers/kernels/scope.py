"""Variables of a function: where C declares them, and the lines written so far."""

import ast
from collections import Counter
from dataclasses import dataclass, field

from controllers.kernels.literals import RESERVED
from controllers.kernels.sources import Kernel
from controllers.kernels.types import Type
from controllers.kernels.values import Value

Path = tuple[tuple[int, str], ...]
"""Blocks around a statement, outermost first: each the number of its statement and which of its bodies."""


@dataclass
class Variable:
    """A local variable or an argument."""

    name: str  # its name in C
    type: Type  # its type
    pointer: bool = False  # whether it is a pointer to a record that stays as it is
    constant: float | None = None  # its value, where that is a number that is known at translation
    natural: bool = False  # whether it is an integer that is known not to be negative


@dataclass
class Loop:
    """A loop around what is translated now: variables that have a value where it goes on, and where it breaks off."""

    turns: list[set[str]] = field(default_factory=list)
    breaks: list[set[str]] = field(default_factory=list)


@dataclass
class Later:
    """A line of a variable that is written when the function is complete."""

    name: str
    declares: bool  # whether it is a declaration before the first value; else it says that none uses the variable


Item = tuple[int, "str | Later"]


@dataclass
class Scope:
    """Variables of one function and the lines of its body."""

    kernel: Kernel  # the function
    variables: dict[str, Variable] = field(default_factory=dict)  # variables by their name in Python
    lines: list[Item] = field(default_factory=list)  # depth and text of each line so far
    depth: int = 1  # depth of the line that comes next
    conditional: int = 0  # how many expressions are open of which C may leave out a part

    def __post_init__(self) -> None:
        self.counters: set[str] = set()
        self.writes = 0  # how often arrays are changed in place so far
        self.given: set[str] = set()  # variables that have a value here, by whatever way it is reached
        self.ended = False  # whether nothing can follow here
        self.loops: list[Loop] = []  # those around this place, innermost last
        self.folded: set[int] = set()  # conditions that are known at translation
        self.declared: set[str] = set()  # variables that have been declared
        self._homes: dict[str, Path] = {}
        body = self.kernel.tree.body
        self._find_homes(body, ())
        names = [node for node in ast.walk(self.kernel.tree) if isinstance(node, ast.Name)]
        self.stores = Counter(node.id for node in names if isinstance(node.ctx, ast.Store))
        loops = [node for node in ast.walk(self.kernel.tree) if isinstance(node, ast.For)]
        self.counted = Counter(ast.unparse(loop.target) for loop in loops)
        arguments = self.kernel.tree.args
        self._taken = {node.id for node in names} | {each.arg for each in (*arguments.args, *arguments.kwonlyargs)}

    def _find_homes(self, body: list[ast.stmt], path: Path) -> None:
        for statement in body:
            bodies = {name: getattr(statement, name, None) or [] for name in ("body", "orelse")}
            inner = {id(node) for body in bodies.values() for child in body for node in ast.walk(child)}
            for node in ast.walk(statement):
                if isinstance(node, ast.Name) and id(node) not in inner:
                    self._homes[node.id] = _common(self._homes.get(node.id, path), path)
            for name, body in bodies.items():
                self._find_homes(body, (*path, (id(statement), name)))

    def lives_in(self, name: str, path: Path) -> bool:
        """Tell whether a variable belongs to a body; the bodies of conditions known at translation are none."""
        home = self._homes.get(name, path)
        return self._opened(home) == self._opened(path)

    def _opened(self, path: Path) -> Path:
        return tuple(step for step in path if step[0] not in self.folded)

    def emit(self, text: str) -> None:
        """Write a line."""
        self.lines.append((self.depth, text))

    def fresh(self, wish: str) -> str:
        """Return a name that is not in use, like the one wished for."""
        name, count = wish, 1
        while name in self._taken or name in RESERVED:
            count += 1
            name = f"{wish}{count}"
        self._taken.add(name)
        return name

    def announce(self, statement: ast.stmt, path: Path) -> None:
        """Declare variables that get their first value within a statement and live on after it."""
        for node in ast.walk(statement):
            if not (isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)):
                continue
            if node.id != "_" and node.id not in self.declared and self.lives_in(node.id, path):
                if self.counted[node.id] == self.stores[node.id]:
                    continue  # counters are declared by their loops
                self.lines.append((self.depth, Later(node.id, declares=True)))
                self.declared.add(node.id)

    def value(self, name: str) -> Value:
        """Return a variable as an expression."""
        variable = self.variables[name]
        text, kind, known = variable.name, variable.type, variable.constant
        return Value(text, kind, constant=known, root=name, pointer=variable.pointer, natural=variable.natural)


def _common(first: Path, second: Path) -> Path:
    length = 0
    while length < min(len(first), len(second)) and first[length] == second[length]:
        length += 1
    return first[:length]
