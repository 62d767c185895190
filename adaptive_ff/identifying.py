"""What controllers that identify have in common."""

from typing import ClassVar

from adaptive_ff.model import ESTIMATED
from controllers import Controller, check_positive

__all__ = ["IdentifyingController", "check_positive"]


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
