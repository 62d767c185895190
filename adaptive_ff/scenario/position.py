"""The table ``[position]``: a position loop around every controller of a scenario."""

import math
from collections.abc import Callable

from adaptive_ff.scenario.tables import STRICT
from controllers import PositionLoopParameters, default_position_gain
from plant.fields import Positive, Table


class PositionControl(Table):
    """A proportional position loop; with it every controller stands in a cascade.

    Parameters
    ----------
    gain : float, optional
        Position gain, 1/s; by default a sixth of the angular bandwidth of the velocity loop.
    limit : float, optional
        Largest absolute correction, rad/s; by default there is none.
    encoder_resolution : float, optional
        Step of the encoder of the position, rad; by default that of ``[sensor]``, and where that has none either, the
        true position rounded to 1e-5 rad.
    """

    model_config = STRICT
    gain: Positive | None = None
    limit: Positive | None = None
    encoder_resolution: Positive | None = None

    def loop(self, bandwidth: Callable[[], float]) -> PositionLoopParameters:
        """Return the position loop; the bandwidth of the velocity loop, Hz, is asked for where no gain is given."""
        gain = default_position_gain(bandwidth()) if self.gain is None else self.gain
        return PositionLoopParameters(gain, math.inf if self.limit is None else self.limit)
