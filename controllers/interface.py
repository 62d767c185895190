"""What every controller has in common: its kernel's inputs and output, and the thin class around it."""

import copy
import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Self

import numpy as np
from numba.extending import register_jitable

from controllers.bridging import BRIDGED
from controllers.checks import check_positive
from controllers.compiled import compiled_in_place, dispatched
from controllers.plausible_sizes import largest_torque
from controllers.saved_state import check_it_goes_on, restored, saved_text


class Inputs(NamedTuple):
    """What a controller is given at a sample.

    Feedback acts on ``reference + correction - velocity``. Feedforward, preview and instruments see the plan alone,
    ``reference`` and ``next_reference``: a correction contains the measurement, and friction fed forward along it
    would close a loop of its own. Identification sees the true velocity and torque.

    Attributes
    ----------
    reference : float
        Planned velocity now, rad/s.
    velocity : float
        Measured velocity now, rad/s; not finite where the measurement failed.
    next_reference : float
        Planned velocity at the next sample, rad/s; not a number where it is not known.
    correction : float
        What an outer loop adds to the plan, rad/s.
    position : float
        Measured position now, rad; not a number where it is not known.
    realised_torque : float
        Mean torque that the drive gave over the last period, N m; not a number where it is not known.
    feedforward : float
        Torque known from elsewhere, such as gravity, N m.
    inertia : float
        Inertia in the present configuration, kg m^2; not a number where the controller's own holds.
    dt : float
        Time since the last sample, s.
    """

    reference: float
    velocity: float
    next_reference: float
    correction: float
    position: float
    realised_torque: float
    feedforward: float
    inertia: float
    dt: float


@register_jitable
def planned_inputs(
    reference: float, velocity: float, next_reference: float, realised_torque: float, dt: float
) -> Inputs:
    """Return the inputs along a plan without an outer loop, with no position, known torque or given inertia.

    Parameters
    ----------
    reference, velocity, next_reference : float
        Planned velocity now, measured velocity, planned velocity at the next sample, rad/s.
    realised_torque : float
        Mean torque that the drive gave over the last period, N m.
    dt : float
        Time since the last sample, s.
    """
    return Inputs(reference, velocity, next_reference, 0.0, math.nan, realised_torque, 0.0, math.nan, dt)


@register_jitable
def _changed(inputs: Inputs, velocity: float, realised_torque: float, feedforward: float) -> Inputs:
    # the one place that lists all fields: compiled code knows no ``_replace``
    return Inputs(
        inputs.reference,
        velocity,
        inputs.next_reference,
        inputs.correction,
        inputs.position,
        realised_torque,
        feedforward,
        inputs.inertia,
        inputs.dt,
    )


@register_jitable
def with_feedforward(inputs: Inputs, torque: float) -> Inputs:
    """Return the inputs with a torque (N m) added to their feedforward."""
    return _changed(inputs, inputs.velocity, inputs.realised_torque, inputs.feedforward + torque)


@register_jitable
def with_velocity(inputs: Inputs, velocity: float) -> Inputs:
    """Return the inputs with another velocity (rad/s) in the place of the measured one."""
    return _changed(inputs, velocity, inputs.realised_torque, inputs.feedforward)


@register_jitable
def with_realised_torque(inputs: Inputs, torque: float) -> Inputs:
    """Return the inputs with a mean torque (N m) that the drive gave over the last period."""
    return _changed(inputs, inputs.velocity, torque, inputs.feedforward)


@register_jitable
def present_inertia(inputs: Inputs, inertia: float) -> float:
    """Return the inertia (kg m^2) of the present configuration, or the controller's own where none is given."""
    return inputs.inertia if math.isfinite(inputs.inertia) else inertia


class Output(NamedTuple):
    """What a controller gives at a sample.

    Attributes
    ----------
    torque : float
        Commanded torque, N m.
    feedforward : float
        The part of it that is not feedback, N m.
    """

    torque: float
    feedforward: float


STEPS: dict[type, Callable[..., Any]] = {}
"""Step kernel of each class of controller parameters: ``step(parameters, state, inputs) -> (output, state)``."""

ESTIMATES: dict[type, Callable[..., Any]] = {}
"""Kernel that writes the physical estimates into a row: ``write(parameters, state, row)``."""


class _Monitors(dict[type, Callable[..., Any]]):
    """Kernels of the classes that have any; the others write nothing."""

    def get(self, block: type, default: Any = None) -> Any:
        """Return the kernel of a class of parameters."""
        return super().get(block, without_estimates)


MONITORS: dict[type, Callable[..., Any]] = _Monitors()
"""Kernel that writes what a controller watches itself by into a row: ``write(parameters, state, row)``; optional."""


def _step(block: Any, state: Any, inputs: Inputs) -> Any:
    return STEPS[type(block)](block, state, inputs)


def _write_estimates(block: Any, state: Any, row: Any) -> Any:
    return ESTIMATES[type(block)](block, state, row)


def _write_monitors(block: Any, state: Any, row: Any) -> Any:
    return MONITORS.get(type(block))(block, state, row)  # type: ignore[misc]


step = dispatched(STEPS, _step)
"""One sample of any controller, compiled or not."""

write_estimates = dispatched(ESTIMATES, _write_estimates)
"""Write the physical estimates of any controller into a row of floats."""


write_monitors = dispatched(MONITORS, _write_monitors)
"""Write what any controller watches itself by into a row of floats."""


@register_jitable
def without_estimates(block: Any, state: Any, row: Any) -> None:
    """Write nothing: for controllers that estimate nothing."""


def _single_step(block: Any, state: Any, inputs: Inputs) -> Any:
    return step(block, state, inputs)


single_step = compiled_in_place(_single_step)


class Controller:
    """A velocity controller to call once a sample.

    Subclasses set the parameters (an immutable named tuple registered in ``STEPS``) and the function that makes
    the state of a controller at rest.

    Parameters
    ----------
    parameters : NamedTuple
        Parameters of the kernel.
    period : float
        Nominal sampling period, s: ``dt`` of a step where none is given.
    initial_state : callable
        Makes a new state from the parameters.
    """

    estimate_names: tuple[str, ...] = ()
    monitor_names: tuple[str, ...] = ()

    def __init__(self, parameters: Any, period: float, initial_state: Callable[[Any], Any]) -> None:
        if not (math.isfinite(period) and period > 0.0):
            raise ValueError(f"period = {period} is not allowed: it must be a positive number of seconds")
        self.parameters = parameters
        self.period = float(period)
        self._initial_state = initial_state
        self.state: Any = initial_state(parameters)
        self._step: Callable[..., Any] = single_step

    def step(
        self,
        reference: float,
        velocity: float,
        *,
        next_reference: float | None = None,
        correction: float = 0.0,
        position: float | None = None,
        realised_torque: float | None = None,
        feedforward: float = 0.0,
        inertia: float | None = None,
        regressors: Sequence[float] | None = None,
        dt: float | None = None,
    ) -> float:
        """Compute the torque for the coming period.

        Parameters
        ----------
        reference : float
            Planned velocity now, rad/s, without what an outer loop adds.
        velocity : float
            Measured velocity now, rad/s. A value that is not finite, or that no machine can have, is skipped and
            counted in ``rejected``: the controller takes the error for zero, keeps its integral and its estimates and
            goes on with its feedforward for two seconds; then ``fault`` is set and the torque fades to zero.
        next_reference : float, optional
            Planned velocity at the next sample, rad/s (preview).
        correction : float, optional
            What an outer loop, such as a position loop, adds to the plan, rad/s. Only the feedback follows it:
            feedforward and instruments follow the plan.
        position : float, optional
            Measured position now, rad, for torques that depend on it. A value that is not finite counts as not known.
        realised_torque : float, optional
            Mean torque that the drive gave over the last period, N m. Without it the drive is taken to give what was
            asked. A value that is not finite counts as not known.
        feedforward : float, optional
            Torque known from elsewhere, N m, added to the output.
        inertia : float, optional
            Inertia in the present configuration, kg m^2, for the torque fed forward along the plan and for observers,
            instead of the one that the controller was made with or has identified.
        regressors : sequence of float, optional
            Further known regressors now, for a controller that was made for some; where none are given, or one is not
            finite, the last ones hold.
        dt : float, optional
            Time since the last call, s; the nominal period by default.

        Returns
        -------
        float
            Torque, N m, always finite. Other inputs that no machine can have are not used, and counted in ``faults``.

        Raises
        ------
        ValueError
            The reference, the preview, the correction or the feedforward is not finite, the inertia or ``dt`` is
            not positive and finite, or the regressors are not as many as the controller was made for.
        """
        if inertia is not None:
            check_positive(inertia=inertia)
        if regressors is not None:
            self._take_regressors(regressors)
        inputs = Inputs(
            _finite("reference", reference),
            float(velocity),
            math.nan if next_reference is None else _finite("next_reference", next_reference),
            _finite("correction", correction),
            math.nan if position is None else float(position),
            math.nan if realised_torque is None else float(realised_torque),
            _finite("feedforward", feedforward),
            math.nan if inertia is None else float(inertia),
            self.period if dt is None else _finite("dt", dt),
        )
        if inputs.dt <= 0.0:
            raise ValueError(f"dt = {dt} is not allowed: it must be a positive number of seconds")
        output, self.state = self._step(self.parameters, self.state, inputs)
        torque: float = output.torque
        return torque

    def _take_regressors(self, regressors: Sequence[float]) -> None:
        """Take further known regressors for the coming step; a controller that knows none refuses them."""
        raise ValueError(f"regressors is not allowed: {type(self).__name__} has no use for known regressors")

    def take_over(self, torque: float, reference: float, velocity: float, **given: Any) -> None:
        """Prepare for taking over from a controller that runs, without a jump of the torque.

        The step that comes next with the same arguments returns this torque, but for a torque limit; what was learnt
        stays. The integral of the feedback makes up for the difference; an adaptive controller begins as its PI loop
        alone and fades its feedforward in.

        Parameters
        ----------
        torque : float
            Torque that the drive gives now, N m.
        reference, velocity : float
            Planned and measured velocity now, rad/s.
        **given
            Other arguments of :meth:`step`.

        Raises
        ------
        ValueError
            The torque or the velocity is not finite, or the controller has no integral.
        """
        torque, velocity = _finite("torque", torque), _finite("velocity", velocity)
        if not feedback_state(self.parameters).integral > 0.0:
            raise ValueError("integral = 0 is not allowed for a takeover: it must be positive to hold the torque")
        self._prepare(float(reference), torque)
        feedback = feedback_state(self.state)
        started = feedback._replace(commands=(torque,) * len(feedback.commands), samples=0)
        begun = with_feedback_state(copy.deepcopy(self.state), started)
        self.state = copy.deepcopy(begun)
        self.step(reference, velocity, **given)
        missing = torque - feedback_state(self.state).commands[0]
        self.state = with_feedback_state(begun, started._replace(integral=started.integral + missing))

    def _prepare(self, reference: float, torque: float) -> None:
        """Forget what the last motion left in filters, before a takeover at a reference (rad/s) and a torque (N m)."""

    def reset(self) -> None:
        """Return to the state of a new controller; estimates are forgotten."""
        self.state = self._initial_state(self.parameters)

    @property
    def rejected(self) -> int:
        """Number of measured velocities that were not finite, or not plausible, and so were skipped."""
        return int(feedback_state(self.state).rejected)

    @property
    def faults(self) -> int:
        """Number of samples at which another input was not plausible and so was not used; see ``plausibility``."""
        return int(feedback_state(self.state).guard.faults)

    @property
    def fault(self) -> bool:
        """Whether the measurement has been lost for longer than can be bridged, so that the torque fades to zero."""
        return bool(feedback_state(self.state).guard.lost > BRIDGED)

    @property
    def estimates(self) -> dict[str, float]:
        """Physical estimates by name; empty for a controller that has none."""
        row = np.zeros(len(self.estimate_names))
        write_estimates(self.parameters, self.state, row)
        return dict(zip(self.estimate_names, row.tolist(), strict=True))

    def warm_up(self) -> None:
        """Compile or load the step before real-time use; the state is left as it is."""
        single_step(
            self.parameters,
            self._initial_state(self.parameters),
            planned_inputs(0.0, 0.0, 0.0, 0.0, self.period),
        )

    def state_to_json(self) -> str:
        """Return the state as a JSON text that restores it exactly, with what it belongs to."""
        return saved_text(type(self).__name__, self._belongs_to(), self.state)

    def state_from_json(self, text: str) -> None:
        """Restore a state saved by a controller of the same class, made with the same period, inertia and gains.

        Raises
        ------
        ValueError
            The text is no such state, or no controller can go on from it; the controller keeps the one it has.
        """
        template = self._initial_state(self.parameters)
        state = restored(text, type(self).__name__, self._belongs_to(), template)
        self._check_state(state)
        inputs = planned_inputs(0.0, 0.0, 0.0, math.nan, self.period)
        check_it_goes_on(state, lambda tried: _single_step(self.parameters, tried, inputs))
        self.state = state

    def _belongs_to(self) -> dict[str, Any]:
        """Return what a state of this controller belongs to, by name."""
        feedback = feedback_state(self.parameters)
        gains = {name: float(getattr(feedback, name)) for name in ("proportional", "integral", "delay")}
        return {"period": self.period, **gains, **_inertia_of(self.parameters), "estimates": list(self.estimate_names)}

    def _check_state(self, state: Any) -> None:
        """Raise ``ValueError`` where a restored state is none that the controller could have come to."""
        feedback = feedback_state(state)
        if not 0 <= feedback.rejected <= feedback.samples or feedback.guard.faults < 0 or feedback.guard.lost < 0.0:
            raise ValueError(
                f"state.feedback is not allowed: samples = {feedback.samples}, rejected = {feedback.rejected}, "
                f"faults = {feedback.guard.faults} and lost = {feedback.guard.lost} must be counts of one run"
            )
        largest = largest_torque(feedback_state(self.parameters).proportional, feedback_state(self.parameters).integral)
        for torque in (feedback.integral, *feedback.commands):
            if abs(torque) > largest:
                raise ValueError(
                    f"state.feedback: torque = {torque} N m is not allowed: at most {largest:g} is plausible"
                )

    def run_uncompiled(self) -> Self:
        """Make this controller step in plain Python, for debugging; returns itself."""
        self._step = _single_step
        return self


def _inertia_of(parameters: Any) -> dict[str, float]:
    """Return the inertia that a controller was made with, where its parameters name one."""
    if hasattr(parameters, "inertia"):
        return {"inertia": float(parameters.inertia)}
    for item in parameters:
        if hasattr(item, "_asdict") and (found := _inertia_of(item)):
            return found
    return {}


def feedback_state(state: Any) -> Any:
    """Return the state of the innermost feedback loop of a controller's state."""
    while hasattr(state, "feedback"):
        state = state.feedback
    return state


def with_feedback_state(state: Any, feedback: Any) -> Any:
    """Return a controller's state with another state of its innermost feedback loop."""
    if not hasattr(state, "feedback"):
        return feedback
    return state._replace(feedback=with_feedback_state(state.feedback, feedback))


def _finite(name: str, value: float) -> float:
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"{name} = {value} is not allowed: it must be a finite number")
    return number
