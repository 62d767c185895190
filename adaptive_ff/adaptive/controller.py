"""The adaptive controller as a class: what it is made with, what can be read of it, and its state kept and restored."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from adaptive_ff.adaptive.arguments import (
    check_gear_and_limit,
    check_machine,
    checked_fraction,
    checked_memory,
    checked_noise,
    checked_tuning,
    further_names,
    observer_pole,
    refuse_large,
    slowed,
    write_finite,
)
from adaptive_ff.adaptive.estimates import deviations
from adaptive_ff.adaptive.extensions.over_position import LearntMap, checked_hats, checked_periods, read_map
from adaptive_ff.adaptive.prior import ASYMMETRY, FOUND, default_prior, model_prior, with_map
from adaptive_ff.adaptive.state import RESPONSES, AdaptiveParameters, AdaptiveState, Machine, initial_adaptive_state
from adaptive_ff.adaptive.state_check import check_adaptive_state
from adaptive_ff.adaptive.step import step_adaptive  # noqa: F401  its import registers the kernel
from adaptive_ff.adaptive.tuning import Tuning
from adaptive_ff.friction.columns import Hypothesis, initial_friction_state
from adaptive_ff.friction.identifying import ALL_CHOICES, IdentifyingController, check_parameters, has_gravity
from adaptive_ff.friction.model import WITH_GRAVITY, TorqueModel, ripple_names
from adaptive_ff.learning.kalman import Prior
from adaptive_ff.learning.response import initial_response
from controllers import check_gains, check_positive
from controllers.arrays import NDArray
from controllers.checks import check_numbers, check_velocity_lag, checked_array, checked_switch

if TYPE_CHECKING:
    from adaptive_ff.adaptive.diagnosis import Diagnosis

Array = NDArray[np.float64]


class AdaptiveController(IdentifyingController):
    """Control law ``u = Kp (r - w) + Ki int (r - w) dt + sum_i theta_i psi_i(r) + g d``, ``theta`` learnt online.

    ``psi_i`` are unit torques along the reference (inertia, friction, gravity: :mod:`adaptive_ff.friction.columns`),
    ``theta_i`` their sizes out of one Kalman filter behind the response of the loop, ``d`` an observer of the torque
    that the feedforward lacks and ``g`` its gain. ``docs/explanation`` has the equations and the contract.

    Parameters
    ----------
    proportional, integral : float
        Gains of the PI loop, N m s/rad and N m/rad.
    period : float
        Nominal sampling period, s.
    inertia : float
        Inertia that the feedback was designed for, kg m^2; it may be wrong.
    stribeck_velocity : float
        Stribeck velocity, rad/s, pre-estimated; it may be wrong.
    stribeck_shape : float, optional
        Stribeck shape factor, pre-estimated.
    memory : float, optional
        Time in which what was learnt fades to the prior by ``1/e``, s of motion; :class:`Tuning` has the default.
    parameters : sequence of str, optional
        What is identified, one of the sets of :mod:`adaptive_ff.friction.model`: ``WITH_GRAVITY`` by default, for a
        rotary joint. Gravity is there as soon as ``step`` is given a position, and zero until then. ``WITH_OFFSET`` is
        without gravity, for a linear axis whose position is given all the same; ``ESTIMATED`` without offset, too;
        ``PER_DIRECTION`` and ``PER_DIRECTION_WITH_GRAVITY`` where friction may differ by direction. The offset is the
        torque that the integral holds, a constant load among it; it need not be fed.
    delay : float, optional
        Computation delay of the drive, sampling periods. The ``feedforward`` that ``step`` takes is, as the torque
        that it returns, of the period in which the drive will apply it.
    velocity_lag : float, optional
        Time by which the measured velocity lags behind the joint's, s: half a period for a difference of positions;
        :func:`controllers.low_pass_lag` for one behind a low-pass.
    velocity_noise : float, optional
        Standard deviation of its noise, rad/s, with which the level that is learnt begins; 0, the default, where it is
        unknown. A coarse encoder shows its own only once the joint moves.
    regressors : int, optional
        How many further known regressors there are, for instance sines of summed angles in a coupled arm: the joint
        carries the torque ``sum_i a_i x_i``, and the ``a_i`` are identified. Their values, of the size of one, are
        given at each step.
    gear_ratio : float, optional
        Position and velocity as they are given over those of the joint that gravity turns: that of the gear where they
        are the motor's, negative where the gear reverses the direction.
    ripple_periods : sequence of float, optional
        Known periods of a torque over position, such as cogging of a motor, rad of the joint.
    model : TorqueModel or mapping, optional
        First estimate, from a data sheet, an identification, or the ``estimates`` of another controller, fed forward
        from the first sample; its offset the integral begins with. A mapping may hold gravity as well.
    deviation : float or mapping, optional
        How sure that is: standard deviation as a fraction of each value, or in its unit for each name;
        :class:`Tuning` has the default.
    torque_limit : float, optional
        Largest torque that is commanded, N m, infinite of a drive that gives all it is asked for; what it cut off
        counts as not realised. Give it, or ``realised_torque`` at each step: without either there is no observer, and
        torque that never acted would be learnt as friction.
    feedforward_includes_inertia : bool, optional
        Whether the ``feedforward`` given to ``step`` is inverse dynamics that includes the inertia along the plan: the
        ``inertia`` given with it, or that of the controller where none is, times the slope of the plan.
    friction_share : float, optional
        What of the identified friction is fed, from 0 to 1; robots that are moved by hand, or at low gains, ship 0.8 to
        0.9. Neither the observer nor the estimates make up for the rest.
    observer_bandwidth : float, optional
        Bandwidth of the observer, Hz, at most the crossover ``Kp/J`` of the feedback.
    position_periods : sequence of float, optional
        Known periods of friction over position, rad of the joint.
    position_hats : int, optional
        Number of hats of a piecewise linear map of friction over position, where no period is known.
    position_range : sequence of float, optional
        Positions of the first and of the last hat, rad, a turn about zero by default.
    load_friction : bool, optional
        Whether friction may rise with the known torque, ``feedforward``.
    position_map : sequence of float, optional
        First map of friction over position: cosine and sine of each of ``position_periods``, then each of
        ``position_hats``, from -2 to 2, as fractions of the friction of the ``model``, which must have some.
    map_deviation : float or sequence of float, optional
        How sure that is: standard deviation of all its numbers, or of each, as a fraction of friction; infinite where
        nothing is known. :class:`Tuning` has the default.
    tuning : Tuning, optional
        Every constant of the method.

    Raises
    ------
    ValueError
        A value is out of range.

    Examples
    --------
    >>> from adaptive_ff import AdaptiveController
    >>> from controllers import PI
    >>> design = PI.design(inertia=20.0, period=0.01, bandwidth=10.0)
    >>> controller = AdaptiveController(
    ...     design.proportional, design.integral, period=0.01, inertia=20.0, stribeck_velocity=0.05, torque_limit=400.0
    ... )
    >>> torque = controller.step(0.1, 0.0, next_reference=0.101)
    """

    monitor_names = ("change_probability", "observer_gain", "observer_torque")
    state_version = 9

    def __init__(
        self,
        proportional: float,
        integral: float,
        period: float,
        *,
        inertia: float,
        stribeck_velocity: float,
        stribeck_shape: float = 1.0,
        memory: float | None = None,
        parameters: Sequence[str] = WITH_GRAVITY,
        delay: float = 0.0,
        velocity_lag: float = 0.0,
        velocity_noise: float = 0.0,
        regressors: int = 0,
        gear_ratio: float = 1.0,
        ripple_periods: Sequence[float] = (),
        model: TorqueModel | Mapping[str, float] | None = None,
        deviation: float | Mapping[str, float] | None = None,
        torque_limit: float | None = None,
        feedforward_includes_inertia: bool = False,
        friction_share: float = 1.0,
        observer_bandwidth: float | None = None,
        position_periods: Sequence[float] = (),
        position_hats: int = 0,
        position_range: Sequence[float] | None = None,
        load_friction: bool = False,
        position_map: Sequence[float] | None = None,
        map_deviation: float | Sequence[float] | None = None,
        tuning: Tuning | None = None,
    ) -> None:
        tuning = checked_tuning(tuning)
        feedback = check_gains(proportional, integral, period, delay)
        parameters = check_parameters(parameters, ALL_CHOICES)
        ripples = checked_periods("ripple_periods", ripple_periods)
        names = (*parameters, *ripple_names(ripples.size), *further_names(regressors, ripples.size))
        check_machine(proportional, inertia, stribeck_velocity)
        check_positive(stribeck_shape=stribeck_shape)
        check_velocity_lag(velocity_lag, period)
        check_gear_and_limit(gear_ratio, torque_limit)
        hats, lowest, spacing = checked_hats(position_hats, position_range)
        response = inertia / proportional
        hypothesis = Hypothesis(
            shape=float(stribeck_shape),
            distances=stribeck_velocity * response * tuning.distance_ratio ** np.arange(tuning.distances),
            directions=ASYMMETRY[0] in parameters,
            waves=np.append(np.ones(int(has_gravity(parameters))), 2.0 * math.pi / ripples),
            map_waves=2.0 * math.pi / checked_periods("position_periods", position_periods),
            hats=hats,
            lowest=lowest,
            spacing=spacing,
            over_load=checked_switch("load_friction", load_friction),
            regressors=int(regressors),
            gear_ratio=float(gear_ratio),
        )
        machine = Machine(
            inertia=float(inertia),
            velocity_lag=float(velocity_lag),
            velocity_noise=checked_noise(velocity_noise),
            torque_limit=math.inf if torque_limit is None else float(torque_limit),
            torque_known=torque_limit is not None,
            includes_inertia=checked_switch("feedforward_includes_inertia", feedforward_includes_inertia),
            memory=checked_memory(memory, tuning),
            first_unit=tuning.first_unit * float(proportional * stribeck_velocity),
            observer_pole=min(observer_pole(observer_bandwidth, tuning), slowed(1.0 / response, delay * period)),
            span=max(1, int(tuning.span * response / period)),
            friction_share=checked_fraction(friction_share),
            offset=0.0,
        )
        prior = default_prior(hypothesis, tuning, float(proportional), float(inertia), float(stribeck_velocity))
        unit = float(proportional * stribeck_velocity)
        sure = tuning.model_deviation if deviation is None else deviation
        prior = prior_with(prior, hypothesis, tuning, names, model, sure, unit, stribeck_shape)
        known = model._asdict() if isinstance(model, TorqueModel) else dict(model or {})
        coulomb = float(known.get("coulomb", 0.0))
        machine = machine._replace(offset=float(known.get("offset", 0.0)) if "offset" in names else 0.0)
        spread = tuning.map_deviation if map_deviation is None else map_deviation
        prior = with_map(prior, hypothesis, tuning, position_map, spread, coulomb)
        self.estimate_names = (*names, *FOUND)
        record = AdaptiveParameters(feedback, machine, hypothesis, prior, tuning, float(period))
        super().__init__(record, period, initial_adaptive_state)

    @property
    def feedforward_enabled(self) -> bool:
        """Whether what is identified is fed forward; it is faded in and out, and identification goes on."""
        return bool(self.state.feedforward_enabled)

    @feedforward_enabled.setter
    def feedforward_enabled(self, value: bool) -> None:
        self.state = self.state._replace(feedforward_enabled=checked_switch("feedforward_enabled", value))

    @property
    def uncertainties(self) -> dict[str, float]:
        """Standard deviation of each estimate, by name, as the filter believes."""
        found = deviations(self.parameters, self.state, len(self.estimate_names))
        return dict(zip(self.estimate_names, found.tolist(), strict=True))

    @property
    def observer_gain(self) -> float:
        """Gain with which the observed torque is fed back, from 0 to 1."""
        return float(self.state.observer.gain)

    @property
    def observed_torque(self) -> float:
        """Torque that the feedforward lacks, as observed, N m."""
        return float(self.state.observer.torque)

    @property
    def torque_limit(self) -> float:
        """Limit of the drive, N m; to change it, make another controller and hand it ``state_to_json()``."""
        return float(self.parameters.machine.torque_limit)

    @property
    def feedforward_lag(self) -> float:
        """Friction lag that the feedforward is computed with, s."""
        return math.exp(self.state.estimate.mean[-2])

    @property
    def learnt_map(self) -> LearntMap | None:
        """Friction over position and load as it is learnt and fed; None for a controller without a map."""
        return read_map(self.parameters.hypothesis, self.state.estimate.mean)

    @property
    def depends_on_position(self) -> bool:
        """Whether it learns a ripple or friction over its own position."""
        hypothesis = self.parameters.hypothesis
        ripples = any(name.startswith("ripple") for name in self.estimate_names)
        return bool(ripples or hypothesis.map_waves.size + hypothesis.hats > 0)

    @property
    def regressors(self) -> Array:
        """Further known regressors that hold now; what is written here, the next step sees."""
        held: Array = self._state.regressors  # arrays are shared with compiled code
        return held

    def diagnose(self) -> "Diagnosis":
        """Return what is known of the joint, how surely, what is not known and why, and what is suspected."""
        from adaptive_ff.adaptive.diagnosis import diagnose

        return diagnose(self, self.learnt_map)

    def _take_regressors(self, regressors: Sequence[float]) -> None:
        place = self.regressors
        values = checked_array("regressors", regressors)
        if values.shape != place.shape:
            raise ValueError(
                f"regressors has shape {values.shape}; it must be {place.size} numbers, as the controller was made for"
            )
        refuse_large("regressors", values)
        write_finite(place, values)

    def _belongs_to(self) -> dict[str, Any]:
        hypothesis = self.parameters.hypothesis
        found = super()._belongs_to()
        found |= {"stribeck_shape": hypothesis.shape, "distances": hypothesis.distances.tolist()}
        if hypothesis.gear_ratio != 1.0:  # gravity, ripple and maps are over the position of the joint
            found["gear_ratio"] = hypothesis.gear_ratio
        if any(name.startswith("ripple") for name in self.estimate_names):
            found["waves"] = hypothesis.waves.tolist()
        mapped = [*hypothesis.map_waves.tolist(), hypothesis.hats, hypothesis.lowest, hypothesis.spacing]
        if hypothesis.map_waves.size + hypothesis.hats + int(hypothesis.over_load):
            found["friction_map"] = [float(number) for number in (*mapped, hypothesis.over_load)]
        return found

    def _check_state(self, state: Any) -> None:
        super()._check_state(state)
        check_adaptive_state(self.parameters, state)

    def _prepare(self, reference: float, torque: float) -> None:
        """Forget the motion, the loop's states and the observer, keep what was learnt; what is fed fades in."""
        parameters, state = self.parameters, self.state
        begun: AdaptiveState = initial_adaptive_state(parameters)
        self.state = begun._replace(
            feedback=state.feedback,
            friction=initial_friction_state(parameters.hypothesis),
            response=initial_response(parameters.prior.mean.size + RESPONSES, parameters.feedback.delay),
            estimate=state.estimate,
            given=state.given,
            regressors=state.regressors,
            weight=state.weight,
            noise=begun.noise._replace(variance=state.noise.variance),
            unit=state.unit,
            last_reference=reference,
            steady=torque,
            enabled=state.enabled,
            feedforward_enabled=state.feedforward_enabled,
            fed_gain=0.0,
        )


def prior_with(
    prior: Prior,
    hypothesis: Hypothesis,
    tuning: Tuning,
    names: Sequence[str],
    model: TorqueModel | Mapping[str, float] | None,
    deviation: float | Mapping[str, float],
    unit: float,
    stribeck_shape: float,
) -> Prior:
    """Return a prior with what is known of the joint, where anything is; a deviation is checked in any case."""
    if model is None:
        model_prior(prior, hypothesis, tuning, names, {"inertia": prior.mean[0], "friction_lag": 0.0}, deviation, unit)
        return prior
    if isinstance(model, TorqueModel):
        assumed = {"stribeck_velocity": math.exp(prior.mean[-1]), "stribeck_shape": stribeck_shape}
        for name, value in assumed.items():
            own = getattr(model, name)
            check_numbers(**{f"model.{name}": own})
            if not math.isclose(own, value):
                raise ValueError(f"model.{name} = {own:g} is not allowed: it must be {name} = {value:g}")
    return model_prior(prior, hypothesis, tuning, names, model, deviation, unit)
