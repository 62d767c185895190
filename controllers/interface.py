"""The class around the kernels of a velocity controller: to be called once a sample."""

import copy
import math
import warnings
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, Self

import numpy as np

from controllers.checks import check_finite, check_period
from controllers.compiled import compiles
from controllers.kernels.compiler import NoCompiler
from controllers.native import Native, NativeParameters, bound_step, declined, empty_exchange, fast_step
from controllers.plausibility import BRIDGED, largest_torque
from controllers.registry import Inputs, Output, checked_step, planned_inputs, step, write_estimates
from controllers.saved_state import check_feedback, check_it_goes_on, restored, saved_text


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
    state_version: int = 2
    """Version of the layout of its saved states; 1 had neither a version nor what the state belongs to."""
    needs_double: str = ""
    """Why it cannot be exported in single precision; empty where it can."""
    released: int = 0
    """How often a controller has left its memory: who holds addresses then takes them anew."""

    def __init__(self, parameters: Any, period: float, initial_state: Callable[[Any], Any]) -> None:
        check_period(period)
        self.parameters = parameters
        self.period = float(period)
        self._initial_state = initial_state
        self._state: Any = initial_state(parameters)
        self._native: Native | None = None
        self._exchange = empty_exchange()
        self._is_plain = not compiles()
        self._begin_stepping()

    @property
    def state(self) -> Any:
        """State of the kernel, a named tuple; the arrays in it are those that the next step changes."""
        return self._state if self._native is None else self._native.state

    @state.setter
    def state(self, value: Any) -> None:
        self._state = value  # keeps the arrays alive, too, whose addresses compiled code has
        if self._native is not None:
            self._native.state = value

    @property
    def native(self) -> NativeParameters:
        """What compiled code takes for this controller; its state stays where it is. Compiles or loads at first.

        Raises
        ------
        NoCompiler
            It has to be compiled, and there is no compiler.
        """
        if self._native is None:
            self._native = Native(self.parameters, self._state, self._exchange)
        return self._native.addresses

    def _begin_stepping(self) -> None:
        """Compile or load the step at the next one."""
        self._fast: Callable[..., Any] = declined
        self._run: Callable[..., float] = self._plain_run if self._is_plain else self._first_run

    def _first_run(self, *inputs: float) -> float:
        if self._in_memory() is None:
            self._run = self._plain_run
        else:
            self._run = bound_step(self.native)
            self._fast = fast_step([self.native], self._exchange, self.period, together=False)
        return self._run(*inputs)

    def _in_memory(self) -> Native | None:
        """Return kernels and state in memory; None of a controller that steps in plain Python."""
        if self._native is None and not self._is_plain:
            try:
                _ = self.native
            except NoCompiler as error:
                warnings.warn(f"{type(self).__name__} runs as plain Python: {error}", stacklevel=4)
                self._is_plain = True
        return self._native

    def step_plain(self, inputs: Inputs) -> Output:
        """Do one sample in plain Python, with inputs as they are; return torque and feedforward, N m."""
        output: Output
        output, self.state = step(self.parameters, self.state, inputs)
        return output

    def _plain_run(self, *inputs: float) -> float:
        return self.step_plain(Inputs(*inputs)).torque

    def __getstate__(self) -> dict[str, Any]:
        """Return what a copy is made of: no addresses."""
        content = {**self.__dict__, "_state": self.state, "_native": None}
        del content["_fast"], content["_run"]
        return content

    def __setstate__(self, content: dict[str, Any]) -> None:
        """Make a copy; it steps as the original did, compiled or in plain Python."""
        self.__dict__.update(content)
        self._is_plain = self._is_plain or not compiles()
        self._begin_stepping()

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
        acting_reference: float | None = None,
        next_acting_reference: float | None = None,
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
            Planned velocity a nominal period from now, rad/s (preview), whenever the next sample really comes.
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
        acting_reference, next_acting_reference : float, optional
            Planned velocity when the torque that is returned begins to act, and one nominal period later, rad/s: those
            ``delay`` and ``delay + 1`` periods ahead, for a drive that is late. Where not both are given, the plan is
            extrapolated from now and the next sample, through stops and corners as well.

        Returns
        -------
        float
            Torque, N m, always finite. Other inputs that no machine can have are not used, and counted in ``faults``.

        Raises
        ------
        ValueError
            The reference, a preview, the correction or the feedforward is not finite, the inertia or ``dt`` is
            not positive and finite, or the regressors are not as many as the controller was made for or far too large.
        TypeError
            An argument is no number.
        """
        given = (
            *(reference, velocity, next_reference, correction, position, realised_torque, feedforward),
            *(inertia, dt, acting_reference, next_acting_reference, regressors),
        )
        torque: float | None = self._fast(*given)
        return self._checked_step(*given) if torque is None else torque

    def _checked_step(self, *given: Any) -> float:
        """Do a step with inputs and regressors that have not been checked."""
        inputs = checked_step(given[:-1], self.period)
        if given[-1] is not None:  # nothing is taken before all has been checked
            self._take_regressors(given[-1])
        return self._run(*inputs)

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
            The torque, the reference or the velocity is not finite, no drive can give such a torque, the controller has
            no integral, or :meth:`step` refuses an argument. State, what was learnt and further regressors are then as
            they were.
        TypeError
            An argument is no number.
        """
        check_finite(torque=torque, reference=reference, velocity=velocity)
        torque = float(torque)
        feedback = feedback_state(self.parameters)
        if not feedback.integral > 0.0:
            raise ValueError("integral = 0 is not allowed for a takeover: it must be positive to hold the torque")
        largest = largest_torque(feedback.proportional, feedback.integral)
        if abs(torque) > largest:
            raise ValueError(f"torque = {torque} N m is not allowed: at most {largest:g} is plausible")
        held = self.state
        self.state = copy.deepcopy(held)  # so that not even the arrays of the present one are touched
        try:
            self._begin_at(torque, reference, velocity, given)
        except BaseException:
            self.state = held
            raise

    def _begin_at(self, torque: float, reference: float, velocity: float, given: dict[str, Any]) -> None:
        """Make the next step with these arguments return a torque (N m)."""
        self._prepare(float(reference), torque)
        started = _started(feedback_state(self.state), torque)
        begun = with_feedback_state(self.state, started)
        self.state = copy.deepcopy(begun)
        self.step(reference, velocity, **given)
        missing = torque - feedback_state(self.state).commands[0]
        self.state = with_feedback_state(begun, started._replace(integral=started.integral + missing))

    def _prepare(self, reference: float, torque: float) -> None:
        """Forget what the last motion left in filters, before a takeover at a reference (rad/s) and a torque (N m)."""

    def restart(self) -> None:
        """Begin at standstill with what has been learnt: forget the motion that a restored state was saved in.

        A state goes on where it was saved, with the integral and the filters of that motion: at standstill they would
        throw the joint. The first torque is that of a new feedback; an adaptive controller fades its feedforward in.
        """
        self.state = copy.deepcopy(self.state)  # whose arrays may be those of a saved one
        self._prepare(0.0, 0.0)
        begun = _started(feedback_state(self.state), 0.0)._replace(integral=0.0)
        self.state = with_feedback_state(self.state, begun)

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
        if not compiles():
            return
        at_rest = self._initial_state(self.parameters)
        with suppress(NoCompiler):
            native = Native(self.parameters, at_rest)  # kept: what stands for it holds addresses only
            bound_step(native.addresses)(*planned_inputs(0.0, 0.0, 0.0, 0.0, self.period))
            fast_step([native.addresses], native.addresses.exchange, self.period, together=False)

    def state_to_json(self) -> str:
        """Return the state as a JSON text that restores it exactly, with what it belongs to."""
        return saved_text(type(self).__name__, self.state_version, self._belongs_to(), self.state)

    def state_from_json(self, text: str) -> None:
        """Restore a state saved by a controller of the same class, made with the same period, inertia and gains.

        It goes on as if no time had passed: integral and filters hold the motion in which it was saved. Where the joint
        has moved or rested since, :meth:`take_over` next; what was learnt stays.

        Raises
        ------
        ValueError
            The text is no such state, or no controller can go on from it; the controller keeps the one it has.
        """
        template = self._initial_state(self.parameters)
        state = restored(text, type(self).__name__, self.state_version, self._belongs_to(), template)
        self._check_state(state)
        inputs = planned_inputs(0.0, 0.0, 0.0, math.nan, self.period)
        check_it_goes_on(state, lambda tried: step(self.parameters, tried, inputs))
        self.state = state

    def _belongs_to(self) -> dict[str, Any]:
        """Return what a state of this controller belongs to, by name."""
        feedback = feedback_state(self.parameters)
        gains = {name: float(getattr(feedback, name)) for name in ("proportional", "integral", "delay")}
        return {"period": self.period, **gains, **inertia_of(self.parameters), "estimates": list(self.estimate_names)}

    def _check_state(self, state: Any) -> None:
        """Raise ``ValueError`` where a restored state is none that the controller could have come to."""
        gains = feedback_state(self.parameters)
        check_feedback(feedback_state(state), largest_torque(gains.proportional, gains.integral))

    def run_uncompiled(self) -> Self:
        """Make this controller step in plain Python, for debugging; returns itself."""
        self.state, self._native, self._is_plain = self.state, None, True
        Controller.released += 1
        self._begin_stepping()
        return self


def inertia_of(parameters: Any) -> dict[str, float]:
    """Return the inertia that a controller was made with, where its parameters name one."""
    if hasattr(parameters, "inertia"):
        return {"inertia": float(parameters.inertia)}
    for item in parameters:
        if hasattr(item, "_asdict") and (found := inertia_of(item)):
            return found
    return {}


def _started(feedback: Any, torque: float) -> Any:
    """Return the state of a feedback at whose first sample a torque (N m) acts; its counts are those of a new run."""
    return feedback._replace(commands=(torque,) * len(feedback.commands), samples=0, rejected=0)


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
