"""Controllers that are stepped from a loop outside the package's simulation, by the names of the registry."""

from typing import Any

from adaptive_ff import AdaptiveController
from controllers import PI, DisturbanceObserver

CLASSES: dict[str, Any] = {"pi": PI, "disturbance_observer": DisturbanceObserver, "adaptive": AdaptiveController}


def controller_class(name: str) -> Any:
    """Return the class of a controller."""
    if name not in CLASSES:
        raise ValueError(f"controllers = {name!r} is not known in such loops; there are {', '.join(CLASSES)}")
    return CLASSES[name]
