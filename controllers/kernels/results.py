"""Names of the several values that a function returns."""

import ast
import re

from controllers.kernels.comments import section
from controllers.kernels.names import c_name
from controllers.kernels.sources import Kernel
from controllers.kernels.types import Record
from controllers.kernels.values import Value


def result_of(kernel: Kernel, function: str, values: list[Value]) -> Record:
    """Return the type of the values together, a struct that is named after the function in C."""
    fields = []
    for name, value in zip(_names(kernel, values), values, strict=True):
        if value.type is None:
            raise kernel.refusal(kernel.tree, f"{value.text} cannot be returned; return its items")
        fields.append((name, value.type))
    return Record(f"{function}_result", tuple(fields))


def _names(kernel: Kernel, values: list[Value]) -> list[str]:
    """Return names after the docstring's returns, the variables returned, or what they are."""
    documented = list(section(kernel.function, "Returns"))
    if len(documented) == len(values) and all(name.isidentifier() for name in documented):
        return [c_name(name) for name in documented]
    returned = [node.value for node in ast.walk(kernel.tree) if isinstance(node, ast.Return)]
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
