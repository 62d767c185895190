"""Controllers that are stepped from a loop outside the package's simulation, by the names of the registry."""

import importlib
from typing import Any

CLASSES = {
    "pi": "controllers:PI",
    "disturbance_observer": "controllers:DisturbanceObserver",
    "adaptive": "adaptive_ff.adaptive.controller:AdaptiveController",
}
"""Class of each controller, as ``module:name``."""

GROUPS = {
    "adaptive": "adaptive_ff.adaptive.group:JointGroup",
}
"""Group of joints of each controller that has one."""


def controller_class(name: str, classes: dict[str, str] = CLASSES) -> Any:
    """Return the class of a controller."""
    if name not in classes:
        raise ValueError(f"controllers = {name!r} is not known in such loops; there are {', '.join(classes)}")
    module, _, own = classes[name].partition(":")
    return getattr(importlib.import_module(module), own)
