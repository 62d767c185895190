"""What controllers that identify have in common."""

import math
from typing import ClassVar

from adaptive_ff.model import ESTIMATED
from controllers import Controller


class IdentifyingController(Controller):
    """A controller that identifies the parameters of its feedforward while it works."""

    estimate_names: ClassVar[tuple[str, ...]] = ESTIMATED

    @property
    def enabled(self) -> bool:
        """Whether the estimates adapt; where not, they are kept and fed forward. May be set at any time."""
        return bool(self.state.enabled)

    @enabled.setter
    def enabled(self, value: bool) -> None:
        self.state = self.state._replace(enabled=bool(value))


def check_positive(**values: float) -> None:
    """Raise ``ValueError`` for the first value that is not a positive finite number."""
    for name, value in values.items():
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} = {value} is not allowed: it must be positive and finite")
