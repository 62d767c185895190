"""Adaptive friction-compensating velocity control: identification, feedforward, comparison."""

from typing import Any

import lazy_loader

from adaptive_ff.shadowed import check_not_shadowed

check_not_shadowed()

_load, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> Any:
    """Load a public name when it is used first."""
    if name == "__version__":
        from importlib.metadata import version  # takes longer than the rest of this file

        return version("adaptive-ff")
    return _load(name)
