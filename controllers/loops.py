"""What controllers around a PI loop have in common: its gains, the delay of the drive, an observer's design."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

from controllers.checks import OBSERVER_SENSITIVITY
from controllers.declaration import argument, as_given, controller, derived, positive
from controllers.interface import Controller
from controllers.pi import PIParameters, check_gains

if TYPE_CHECKING:
    from controllers.design.observer_design import ObserverDesign

DELAY = "Computation delay of the drive, sampling periods: it applies the torque of a sample from that much later on."


@controller()
class PILoop(Controller):
    """A controller around a PI loop."""

    proportional: float = argument(as_given, "Proportional gain of the PI loop, N m s/rad.", kw_only=False, kept=False)
    integral: float = argument(as_given, "Integral gain of the PI loop, N m/rad.", kw_only=False, kept=False)
    period: float = argument(as_given, "Nominal sampling period, s.", kw_only=False)
    delay: float = argument(as_given, DELAY, default=0.0, kept=False)
    feedback: PIParameters = derived("The PI loop.")

    Parameters: ClassVar[type]

    def derive(self) -> dict[str, Any]:
        """Return the parameters of the PI loop, with all checks."""
        feedback = check_gains(self.proportional, self.integral, self.period, self.delay)
        return {"feedback": feedback, "period": feedback.period}


@controller()
class DesignedLoop(PILoop):
    """A controller around a PI loop that was designed for an inertia."""

    proportional: float = argument(positive, "Proportional gain of the PI loop, N m s/rad.", kw_only=False, kept=False)
    inertia: float = argument(positive, "Inertia that the feedback was designed for, kg m^2.")


class Observing(Controller):
    """A controller with an observer of the disturbing torque."""

    @property
    def disturbance(self) -> float:
        """Estimated torque that opposes the commanded one beyond what the controller's model foresees, N m."""
        state = self.state
        while not hasattr(state, "disturbance"):
            state = state.observer if hasattr(state, "observer") else state.feedback
        return float(state.disturbance)


def designing(compensation: str) -> Callable[..., "ObserverDesign"]:
    """Return the method ``design`` of a controller, by the name of its filter in ``design.observer_design``."""

    def design(
        inertia: float,
        period: float,
        proportional: float,
        integral: float,
        bandwidth: float | None = None,
        *,
        delay: int = 0,
        maximum_sensitivity: float = OBSERVER_SENSITIVITY,
        velocity: Any = None,
    ) -> "ObserverDesign":
        """Compute the margins of the loop with an observer, or the fastest observer that a margin allows.

        Parameters
        ----------
        inertia : float
            Nominal inertia, kg m^2.
        period : float
            Sampling period, s.
        proportional, integral : float
            Gains of the PI loop, N m s/rad and N m/rad.
        bandwidth : float, optional
            Bandwidth of the observer, Hz. By default the largest one that the margin allows.
        delay : int, optional
            Computation delay, whole periods.
        maximum_sensitivity : float, optional
            Bound on ``max |1/(1 + L)|`` where no bandwidth is given.
        velocity : NamedTuple, optional
            Estimator of :mod:`controllers.velocity` that makes the measured velocity of positions.

        Raises
        ------
        ValueError
            An argument is out of range, or no bandwidth meets the bound.
        """
        from controllers.design import observer_design as desk

        gains, filtered = (proportional, integral), getattr(desk, compensation)
        return desk.design_observer(inertia, period, gains, bandwidth, delay, maximum_sensitivity, filtered, velocity)

    return design
