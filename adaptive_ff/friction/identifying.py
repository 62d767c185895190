"""What controllers that identify have in common."""

from collections.abc import Sequence

from adaptive_ff.friction.model import (
    ESTIMATED,
    GRAVITY,
    PER_DIRECTION,
    PER_DIRECTION_WITH_GRAVITY,
    WITH_GRAVITY,
    WITH_OFFSET,
)
from controllers import Controller
from controllers.checks import checked_switch


class IdentifyingController(Controller):
    """A controller that identifies the parameters of its feedforward while it works."""

    estimate_names: tuple[str, ...] = ESTIMATED

    @property
    def enabled(self) -> bool:
        """Whether the estimates adapt; where not, they are kept and fed forward. May be set at any time."""
        return bool(self.state.enabled)

    @enabled.setter
    def enabled(self, value: bool) -> None:
        self.state = self.state._replace(enabled=checked_switch("enabled", value))


FRICTION_CHOICES = (ESTIMATED, WITH_OFFSET, PER_DIRECTION)
"""What may be identified of friction, and of a constant load."""

ALL_CHOICES = (*FRICTION_CHOICES, WITH_GRAVITY, PER_DIRECTION_WITH_GRAVITY)
"""What may be identified where the position is known."""


def check_parameters(
    parameters: Sequence[str], choices: Sequence[tuple[str, ...]] = FRICTION_CHOICES
) -> tuple[str, ...]:
    """Return the names of the parameters to identify, or raise ``ValueError`` where they are no such choice."""
    try:
        names = tuple(parameters)
    except TypeError:
        names = ()
    if isinstance(parameters, str) or not all(isinstance(name, str) for name in names) or names not in choices:
        allowed = ", or ".join(str(choice) for choice in choices)
        given = names if names and not isinstance(parameters, str) else parameters
        raise ValueError(f"parameters = {given!r} is not allowed: it must be {allowed}")
    return names


def has_gravity(parameters: Sequence[str]) -> bool:
    """Return whether gravity is among the parameters to identify."""
    return tuple(parameters[-len(GRAVITY) :]) == GRAVITY
