"""What controllers that identify have in common."""

from collections.abc import Sequence

from adaptive_ff.model.friction import ESTIMATED, PER_DIRECTION, WITH_OFFSET
from controllers import Controller


class IdentifyingController(Controller):
    """A controller that identifies the parameters of its feedforward while it works."""

    estimate_names: tuple[str, ...] = ESTIMATED

    @property
    def enabled(self) -> bool:
        """Whether the estimates adapt; where not, they are kept and fed forward. May be set at any time."""
        return bool(self.state.enabled)

    @enabled.setter
    def enabled(self, value: bool) -> None:
        self.state = self.state._replace(enabled=bool(value))


def check_parameters(parameters: Sequence[str]) -> tuple[str, ...]:
    """Return the names of the parameters to identify, or raise ``ValueError`` where they are no such choice."""
    names, choices = tuple(parameters), (ESTIMATED, WITH_OFFSET, PER_DIRECTION)
    if names not in choices:
        allowed = ", or ".join(str(choice) for choice in choices)
        raise ValueError(f"parameters = {names} is not allowed: it must be {allowed}")
    return names
