"""What global names stand for, as far as machine code depends on it.

A name may get another meaning without any source of a kernel being edited: a constant that is computed, or read from a
file that holds no kernels, or replaced by a test; another function under the same name; a kernel more for a class.
Machine code on disk is kept together with what the names stood for, and is made anew where one stands for something
else.
"""

import builtins
import importlib
import sys
from collections.abc import Hashable, Mapping
from typing import Any

from controllers.kernels.language import DISPATCHED
from controllers.kernels.sources import KERNEL_PACKAGES


def meaning(scope: Mapping[str, Any], name: str) -> str:
    """Return what a name, which may have dots, stands for now."""
    first, *fields = name.split(".")
    found = scope[first] if first in scope else vars(builtins)[first]
    for field in fields:
        found = getattr(found, field)
    if isinstance(found, type) and hasattr(found, "_fields"):
        return repr((_full_name(found), found._fields, vars(found).get("_field_defaults"), found.__annotations__))
    if isinstance(found, bool | int | float | tuple):
        return repr(found)
    known: Mapping[Any, Mapping[type, Any]] = DISPATCHED
    chosen = known.get(found, {}) if isinstance(found, Hashable) else {}
    return repr((_function(found), sorted((_full_name(kind), _function(kernel)) for kind, kernel in chosen.items())))


def stands(meanings: Mapping[tuple[str, str], str]) -> bool:
    """Tell whether all names, which have their module beside them, stand for what they stood for."""
    try:
        return all(meaning(_scope(module), name) == known for (module, name), known in meanings.items())
    except (ImportError, KeyError, AttributeError):
        return False


def _scope(module: str) -> Mapping[str, Any]:
    return vars(sys.modules[module] if module in sys.modules else importlib.import_module(module))


def _function(found: Any) -> tuple[Any, ...]:
    """Return what a function is: its name and defaults, and its file where only that tells it from others."""
    name = _full_name(found)
    code = None if name[0].partition(".")[0] in KERNEL_PACKAGES else getattr(found, "__code__", None)
    defaults = getattr(found, "__defaults__", None), getattr(found, "__kwdefaults__", None)
    return *name, getattr(code, "co_filename", ""), repr(defaults)


def _full_name(thing: Any) -> tuple[str, str]:
    return getattr(thing, "__module__", None) or "", getattr(thing, "__qualname__", "")
