"""Position loop around a velocity controller.

With the planned velocity fed forward by the velocity controller, the position loop only adds a correction: the cascade
follows ``dq_ref/dt + Kv (q_ref - q)``. The correction goes to the controller's input of that name, not into its
reference: it contains the measured position, and friction fed forward along it would close a loop of its own.
"""

import math
from typing import TYPE_CHECKING, Any, NamedTuple

from controllers.checks import PI_SENSITIVITY, check_finite, check_numbers, check_positive

if TYPE_CHECKING:
    from controllers.design.position_design import PositionDesign


class PositionLoopParameters(NamedTuple):
    """Parameters of the position loop."""

    gain: float  # position gain ``Kv``, 1/s; zero where there is no position loop
    limit: float  # largest absolute correction, rad/s; may be infinite


class PositionLoopState(NamedTuple):
    """State of the position loop, by default at rest."""

    correction: float = 0.0  # last correction, rad/s
    rejected: int = 0  # positions that were not finite


def step_position_loop(
    parameters: PositionLoopParameters, state: PositionLoopState, planned: float, position: float
) -> tuple[float, PositionLoopState]:
    """Return the correction (rad/s) for a planned and a measured position (rad), and the new state.

    Where the measurement failed, the last correction is kept.
    """
    if not math.isfinite(position):
        return state.correction, PositionLoopState(state.correction, state.rejected + 1)
    correction = min(max(parameters.gain * (planned - position), -parameters.limit), parameters.limit)
    return correction, PositionLoopState(correction, state.rejected)


class PositionLoop:
    """``correction = Kv (q_ref - q)``, limited: proportional position loop with velocity feedforward.

    Parameters
    ----------
    gain : float
        Position gain ``Kv``, 1/s; :meth:`design` says how large it may be.
    limit : float, optional
        Largest absolute correction, rad/s; by default there is none.

    Raises
    ------
    ValueError
        A value is not positive.
    TypeError
        A value is no number.

    Examples
    --------
    >>> from controllers import PI, PositionLoop
    >>> design = PI.design(inertia=20.0, period=0.01, bandwidth=10.0)
    >>> velocity_loop = PI(design.proportional, design.integral, period=0.01)
    >>> position_loop = PositionLoop(PositionLoop.design(period=0.01, bandwidth=10.0).gain)
    >>> correction = position_loop.step(0.5, 0.499)
    >>> torque = velocity_loop.step(0.1, 0.0, correction=correction)
    """

    def __init__(self, gain: float, *, limit: float = math.inf) -> None:
        check_positive(gain=gain)
        check_numbers(limit=limit)
        if not limit > 0.0:
            raise ValueError(f"limit = {limit} is not allowed: it must be positive, rad/s")
        self.parameters = PositionLoopParameters(float(gain), float(limit))
        self.state = PositionLoopState()

    def step(self, planned: float, position: float) -> float:
        """Return the correction that the velocity controller is given.

        Parameters
        ----------
        planned : float
            Planned position now, rad: the integral of the planned velocity.
        position : float
            Measured position now, rad. Where it is not finite, the last correction is kept, and it is counted in
            ``rejected``.

        Returns
        -------
        float
            Correction, rad/s.

        Raises
        ------
        ValueError
            The planned position is not finite.
        TypeError
            A position is no number.
        """
        check_finite(planned=planned)
        check_numbers(position=position)
        correction, self.state = step_position_loop(self.parameters, self.state, float(planned), float(position))
        return correction

    def reset(self) -> None:
        """Return to the state of a new loop."""
        self.state = PositionLoopState()

    @property
    def rejected(self) -> int:
        """Number of positions that were not finite."""
        return self.state.rejected

    @staticmethod
    def design(
        period: float,
        bandwidth: float,
        gain: float | None = None,
        *,
        delay: int = 0,
        maximum_sensitivity: float = PI_SENSITIVITY,
        velocity: Any = None,
    ) -> "PositionDesign":
        """Design the gain for the bandwidth of the velocity loop; see :func:`controllers.design_position_loop`."""
        from controllers.design.position_design import design_position_loop

        options = {"maximum_sensitivity": maximum_sensitivity, "velocity": velocity}
        return design_position_loop(period, bandwidth, gain, delay=delay, **options)
