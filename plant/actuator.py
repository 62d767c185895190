"""The drive between the commanded and the realised torque."""

import math
from typing import NamedTuple

from numba.extending import register_jitable
from pydantic import BaseModel, ConfigDict

from plant.joint import Positive


class ActuatorParameters(NamedTuple):
    """What the drive's kernel needs to know.

    Attributes
    ----------
    torque_limit : float
        Largest torque either way, N m; infinite where there is none.
    """

    torque_limit: float


@register_jitable
def realise_torque(actuator: ActuatorParameters, command: float) -> float:
    """Return the torque (N m) that the drive gives for a commanded one (N m)."""
    return min(max(command, -actuator.torque_limit), actuator.torque_limit)


class Actuator(BaseModel):
    """A drive with a torque limit.

    Parameters
    ----------
    torque_limit : float, optional
        Largest torque either way, N m; none by default.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    torque_limit: Positive | None = None

    @property
    def parameters(self) -> ActuatorParameters:
        """The drive as its kernel takes it."""
        return ActuatorParameters(math.inf if self.torque_limit is None else self.torque_limit)
