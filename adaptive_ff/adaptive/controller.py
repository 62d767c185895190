"""The adaptive controller: PI loop with feedforward from a model that is identified online.

``step`` holds its kernels, ``supervised_step`` those of the supervision around them.
"""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.adaptive.adaptive_state import initial_adaptive_state
from adaptive_ff.adaptive.at_rest.wound_integral import initial_standing
from adaptive_ff.adaptive.faults.held_integral import initial_held_integral
from adaptive_ff.adaptive.first_map import with_first_map
from adaptive_ff.adaptive.learning.candidate_choice import (
    BENT_FACTORS,
    FACTORS,
    assess_choice,
    chosen_names,
)
from adaptive_ff.adaptive.learning.estimator_state import load_count
from adaptive_ff.adaptive.learning.fed_model import identified_model
from adaptive_ff.adaptive.learning.friction_map import coefficient_count
from adaptive_ff.adaptive.learning.map_reading import LearntMap, check_map_state, read_map
from adaptive_ff.adaptive.learning.map_settings import MAP_DEVIATION, MAP_MEMORY
from adaptive_ff.adaptive.learning.uncertainty import assess
from adaptive_ff.adaptive.settings import (
    DEVIATION,
    LARGEST_REGRESSOR,
    adaptive_parameters,
    observer_poles,
    settings_among,
)
from adaptive_ff.adaptive.state_check import (
    check_candidate_state,
    check_drive_limit,
    check_estimator_state,
    check_held_friction,
    check_held_integral,
    check_not_negative,
    check_observer,
    check_outer_loop,
    check_plan_known,
    check_seen_velocity,
    check_share,
    check_standing,
    check_trust,
    possible_now,
)
from adaptive_ff.adaptive.supervised_state import SupervisedParameters
from adaptive_ff.adaptive.supervised_step import initial_supervised_state
from adaptive_ff.adaptive.supervision.observer_state import ObserverParameters, initial_observer
from adaptive_ff.friction.bounds import FRICTION_LAG, INERTIA
from adaptive_ff.friction.feedforward import FeedforwardState
from adaptive_ff.friction.identifying import IdentifyingController
from adaptive_ff.friction.model import ESTIMATED, RIPPLE, WITH_GRAVITY, TorqueModel, directed_friction
from adaptive_ff.learning.torque_form import FILTER_TORQUE, initial_signals
from controllers.checks import checked_array, checked_switch
from controllers.plausible_sizes import largest_torque

if TYPE_CHECKING:
    from adaptive_ff.report.diagnosis import Diagnosis, Recorded


class AdaptiveBase(IdentifyingController):
    """What the adaptive controllers share: reading what has been learnt, and taking further regressors."""

    def _belongs_to(self) -> dict[str, Any]:
        estimator = self.parameters.estimator
        found = super()._belongs_to() | {"inertia": float(estimator.first[INERTIA])}
        if estimator.gear_ratio != 1.0:  # gravity, ripple and maps are over the position of the joint
            found["gear_ratio"] = float(estimator.gear_ratio)
        if self._ripples > 0:
            found["ripple_waves"] = estimator.waves[-self._ripples :].tolist()
        mapped = estimator.friction_map
        if coefficient_count(mapped) == 0:
            return found
        numbers = [*mapped.waves.tolist(), mapped.hats, mapped.lowest, mapped.spacing, mapped.load, mapped.memory]
        return found | {"friction_map": [float(number) for number in numbers]}

    def _largest_torque(self) -> float:
        return largest_torque(self.parameters.feedback.proportional, self.parameters.feedback.integral)

    def _check_state(self, state: Any) -> None:
        super()._check_state(state)
        largest, estimator = self._largest_torque(), self.parameters.estimator
        check_estimator_state(estimator, state.estimator, largest)
        ranges = possible_now(estimator, state.estimator.levels)
        check_candidate_state(estimator, state.estimator.candidates, ranges, largest)
        check_map_state(state.estimator.friction_map, largest)
        check_share("command.share", state.command.share)
        if not 0.0 <= state.timing.lag <= self.parameters.estimator.ranges[FRICTION_LAG, 1] * (1.0 + 1e-9):
            raise ValueError(f"state.timing.lag = {state.timing.lag} s is not allowed: it is beyond its range")
        if not state.timing.seen >= 0.0:
            raise ValueError(f"state.timing.seen = {state.timing.seen} is not allowed: it must be zero or more")
        check_not_negative("doubt", left=state.doubt.left, speed=state.doubt.speed, aside=state.doubt.aside)

    @property
    def feedforward_enabled(self) -> bool:
        """Whether what is identified is fed forward; it is faded in and out, and identification goes on."""
        return bool(self.state.command.feedforward_enabled)

    @feedforward_enabled.setter
    def feedforward_enabled(self, value: bool) -> None:
        switch = checked_switch("feedforward_enabled", value)
        self.state = self.state._replace(command=self.state.command._replace(feedforward_enabled=switch))

    def _prepare(self, reference: float, torque: float) -> None:
        block, state = self.parameters, self.state
        model = identified_model(block, state)
        friction = 0.0 if reference == 0.0 else directed_friction(model, abs(reference), reference)
        count = block.estimator.first.size - load_count(block.estimator)
        measured = initial_signals(count)
        measured.filters[FILTER_TORQUE, 0] = torque
        state.estimator.candidates.filters[:] = 0.0
        state.estimator.candidates.bent[:] = 0.0
        self.state = state._replace(
            feedforward=FeedforwardState(friction, reference, True, 0.0, 0.0, 0.0),
            measured=measured,
            model=initial_signals(count),
            sliding=-block.hold,
            lagged_torque=torque,
            model_torques=(friction,) * len(state.model_torques),
            known_torques=(0.0,) * len(state.known_torques),
            command=state.command._replace(share=0.0),  # the integral holds the torque; what is fed fades in
        )

    @property
    def depends_on_position(self) -> bool:
        """Whether it learns a ripple or friction over its own position."""
        mapped = self.parameters.estimator.friction_map
        return self._ripples > 0 or mapped.waves.size + mapped.hats > 0

    @property
    def _ripples(self) -> int:
        return sum(name.startswith(RIPPLE) for name in self.estimate_names) // len(RIPPLE)

    @property
    def regressors(self) -> NDArray[np.float64]:
        """Further known regressors that hold now; what is written here, the next step sees."""
        held: NDArray[np.float64] = self._state.estimator.regressors  # arrays are shared with compiled code
        return held

    def _take_regressors(self, regressors: Sequence[float]) -> None:
        place = self.regressors
        values = checked_array("regressors", regressors)
        if values.shape != place.shape:
            raise ValueError(
                f"regressors has shape {values.shape}; it must be {place.size} numbers, as the controller was made for"
            )
        refuse_large("regressors", values)
        write_finite(place, values)

    @property
    def uncertainties(self) -> dict[str, float]:
        """How far each estimate may be off, as a standard deviation, by name; see ``confidence`` for its limits."""
        estimator, state = self.parameters.estimator, self.state.estimator
        errors = assess(estimator, state, self.parameters.period).errors.tolist()
        errors += [one.error for one in assess_choice(estimator, state.candidates)]
        return dict(zip(self.estimate_names, errors, strict=True))

    @property
    def feedforward_lag(self) -> float:
        """Friction lag that the feedforward is computed with, s: the identified one, tuned by the tracking error."""
        return float(self.state.timing.lag)

    @property
    def learnt_map(self) -> LearntMap | None:
        """Friction over position and load as it is learnt and fed; None for a controller without a map."""
        if self._state.estimator.friction_map.coefficients.size == 0:  # known without reading the state from memory
            return None
        return read_map(self.parameters.estimator.friction_map, self.state.estimator.friction_map)

    def diagnose(self, run: "Recorded | None" = None) -> "Diagnosis":
        """Return what the controller has identified and how uncertain it is; see ``report.diagnosis``."""
        from adaptive_ff.report.diagnosis import diagnose

        return diagnose(self, run)


def refuse_large(name: str, values: NDArray[np.float64]) -> None:
    """Raise ``ValueError`` where a regressor is too large; one that is not finite is none."""
    large = values[(np.abs(values) > LARGEST_REGRESSOR) & np.isfinite(values)]
    if large.size > 0:
        raise ValueError(
            f"{name} = {large[0]:g} is not allowed: they should be of the size of one, from {-LARGEST_REGRESSOR:g} to "
            f"{LARGEST_REGRESSOR:g} at most"
        )


def write_finite(held: NDArray[np.float64], values: NDArray[np.float64]) -> None:
    """Write regressors over those that hold; of one that is not finite the last one holds."""
    np.copyto(held, values, where=np.isfinite(values))


class UnsupervisedController(AdaptiveBase):
    """Control law ``u = Kp (r - w) + Ki int (r - w) dt + J dr/dt + f_ref + offset``, the model identified online.

    The lagged friction ``f_ref`` solves ``tau df_ref/dt + f_ref = F(r)``; see ``friction.feedforward``. What it has
    identified is fed forward in full, also where the model does not hold: it is there for comparison, and to watch the
    motion of another controller. Arguments are those of :class:`AdaptiveController`, but for the observer's.
    """

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
        filter_pole: float | None = None,
        parameters: Sequence[str] = ESTIMATED,
        delay: float = 0.0,
        velocity_lag: float = 0.0,
        tunes_lag: bool = True,
        regressors: int = 0,
        gear_ratio: float = 1.0,
        ripple_periods: Sequence[float] = (),
    ) -> None:
        self.estimate_names, block = adaptive_parameters(settings_among(locals()))
        super().__init__(block, period, initial_adaptive_state)


class AdaptiveController(AdaptiveBase):
    """Control law ``u = Kp (r - w) + Ki int (r - w) dt + J dr/dt + gamma f_ref + offset + g d``, identified online.

    The lagged friction ``f_ref`` solves ``tau df_ref/dt + f_ref = F(r)``; see ``friction.feedforward``. ``d`` is an
    observer of the torque that the feedforward lacks, ``g`` its gain, which noise closes; ``gamma`` is the trust in the
    friction; README.md beside this file says what each is for, and where they fail.

    The first estimate is a frictionless joint of the assumed inertia, with a friction lag equal to the time constant
    ``J/Kp`` of the feedback, but 30 ms at most; lags that are much shorter hardly matter to the loop.

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
        Memory of the estimator, s of sliding motion: an equation counts ``exp(-age/memory)``. By default what
        :func:`adaptive_ff.adaptive.settings.default_memory` says.
    filter_pole : float, optional
        Pole of the regression's filters, rad/s; by default the crossover of the feedback, ``Kp/J``.
    parameters : sequence of str, optional
        What is identified, one of the sets of :mod:`adaptive_ff.friction.model`: ``WITH_GRAVITY`` by default, for a
        rotary joint. What differs by direction of Coulomb friction, and a constant load, is an offset; gravity is there
        as soon as ``step`` is given a position, and zero until then. ``WITH_OFFSET`` is without gravity, for a linear
        axis whose position is given all the same; ``ESTIMATED`` without offset, too; ``PER_DIRECTION`` and
        ``PER_DIRECTION_WITH_GRAVITY`` where all friction may differ by direction.
    delay : float, optional
        Computation delay of the drive, sampling periods. The ``feedforward`` that ``step`` takes is, as the torque
        that it returns, of the period in which the drive will apply it.
    velocity_lag : float, optional
        Time by which the measured velocity lags behind the joint's, s: half a period for a difference of positions;
        :func:`controllers.low_pass_lag` for one behind a low-pass.
    tunes_lag : bool, optional
        Whether the lag of the feedforward is tuned by the tracking error, beyond the identified friction lag; see
        :mod:`adaptive_ff.adaptive.learning.lag_tuning`. It must be false for a controller that only watches another's
        motion.
    regressors : int, optional
        How many further known regressors there are, for instance sines of summed angles in a coupled arm: the joint
        carries the torque ``sum_i a_i x_i`` beside gravity, and the ``a_i`` are identified. Their values, of the size
        of one, are given at each step.
    gear_ratio : float, optional
        Position and velocity as they are given over those of the joint that gravity turns: that of the gear where they
        are the motor's, negative where the gear reverses the direction.
    ripple_periods : sequence of float, optional
        Known periods of a torque over position, such as cogging of a motor, rad of the joint: of a sine and a cosine of
        each the sizes are identified and fed forward, as soon as ``step`` is given a position.
    model : TorqueModel or mapping, optional
        First estimate, from a data sheet, an identification, or the ``estimates`` of another controller, instead of a
        frictionless joint; fed forward from the first sample. A mapping may hold gravity as well.
    deviation : float or mapping, optional
        How sure that is: standard deviation as a share of each value, or in its unit for each name. It weighs for a
        few memories.
    torque_limit : float, optional
        Largest torque that is commanded, N m; what it cut off then counts as not realised without being reported. Where
        neither it nor ``realised_torque`` is given, the integral winds up beside a drive that saturates; nothing is
        learnt from torque that its motion does not answer to (:mod:`adaptive_ff.adaptive.faults.drive_limit`).
    feedforward_includes_inertia : bool, optional
        Whether the ``feedforward`` given to ``step`` is inverse dynamics that includes the inertia along the plan: the
        ``inertia`` given with it, or the first estimate where none is, times the slope of the plan. The inertia is then
        identified as ever, and fed once.
    stribeck_factors : sequence of float, optional
        Stribeck velocities that are tried, over the assumed one: positive, ascending, 1 among them. The one in use is
        the estimate ``stribeck_velocity``. With none of them the assumed one is kept.
    presliding_factors : sequence of float, optional
        Presliding distances that are tried with the assumed Stribeck velocity ``Vs``, over ``Vs`` by the pole of the
        filters: positive and ascending. The one in use is the estimate ``presliding``, zero where there is none.
    position_periods : sequence of float, optional
        Known periods of friction over position, rad: of a cosine and a sine of each the sizes are learnt. Position is
        that of the joint, the given one by ``gear_ratio``; a turn of the motor is ``2 pi`` over the gear's ratio.
    position_hats : int, optional
        Number of hats of a piecewise linear map of friction over position, where no period is known.
    position_range : sequence of float, optional
        Positions of the first and of the last hat, rad, a turn about zero by default; beyond, the map goes on as it is.
    load_friction : bool, optional
        Whether friction may rise with the known torque, ``feedforward`` and identified gravity.
    map_memory : float, optional
        Memory of these maps, s of sliding motion at a position.
    position_map : sequence of float, optional
        First estimate of the map of friction over position, such as an identification gives: cosine and sine of each
        of ``position_periods``, then each of ``position_hats``, from -2 to 2, as shares of the friction of the
        ``model``, which must have Coulomb friction. It is fed from the first sample on, so ``step`` must be given the
        position from there on. What friction does over load is learnt anew.
    map_deviation : float or sequence of float, optional
        How sure that is: standard deviation of all its numbers, or of each, as a share of friction; infinite where
        nothing is known, as of a hat that was not visited; less than a hundredth is a hundredth. A map
        as vague as it is large is not fed until it is learnt.
    observer_bandwidth : float, optional
        Bandwidth of the observer, Hz; at most the crossover of the feedback, ``Kp/J``. By default it is that, but at
        most 10.3 Hz, and with a delay of the drive less. :meth:`controllers.DisturbanceObserver.design` tells what a
        margin allows, also for a velocity out of a Kalman filter, which has no lag to be told and yet bounds it. With a
        delay the observer is faster while the joint stands before anything is learnt, as it answers to no torque then.

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
    ...     design.proportional, design.integral, period=0.01, inertia=20.0, stribeck_velocity=0.05
    ... )
    >>> torque = controller.step(0.1, 0.0, next_reference=0.101)
    >>> controller.estimates["coulomb"]
    0.0
    """

    monitor_names = ("trust", "observer_gain", "observer_torque")

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
        filter_pole: float | None = None,
        parameters: Sequence[str] = WITH_GRAVITY,
        delay: float = 0.0,
        velocity_lag: float = 0.0,
        tunes_lag: bool = True,
        regressors: int = 0,
        gear_ratio: float = 1.0,
        ripple_periods: Sequence[float] = (),
        model: TorqueModel | Mapping[str, float] | None = None,
        deviation: float | Mapping[str, float] = DEVIATION,
        torque_limit: float = math.inf,
        feedforward_includes_inertia: bool = False,
        observer_bandwidth: float | None = None,
        stribeck_factors: Sequence[float] = FACTORS,
        presliding_factors: Sequence[float] = BENT_FACTORS,
        position_periods: Sequence[float] = (),
        position_hats: int = 0,
        position_range: Sequence[float] | None = None,
        load_friction: bool = False,
        map_memory: float = MAP_MEMORY,
        position_map: Sequence[float] | None = None,
        map_deviation: float | Sequence[float] = MAP_DEVIATION,
    ) -> None:
        self.estimate_names, block = adaptive_parameters(settings_among(locals()))
        self.estimate_names = (*self.estimate_names, *chosen_names(stribeck_factors, presliding_factors))
        pole, standing = observer_poles(block, float(inertia), observer_bandwidth)
        observer = ObserverParameters(pole, standing, float(inertia), block.velocity_lag, block.period)
        begun = with_first_map(block.estimator, position_map, map_deviation)
        super().__init__(SupervisedParameters(*block, observer), period, begun or initial_supervised_state)

    def _check_state(self, state: Any) -> None:
        super()._check_state(state)
        check_trust(state.trust)
        check_observer(state.observer)
        check_plan_known(state)
        if not 0.0 <= state.moved <= self._largest_torque():
            raise ValueError(f"state.moved = {state.moved} is not allowed: at most {self._largest_torque():g} N m")
        check_seen_velocity(state.seen)
        check_held_integral(state.held, self._largest_torque())
        check_outer_loop(state.outer)
        check_held_friction(state.held_friction)
        check_standing(state.standing, self._largest_torque())
        check_drive_limit(state.drive)

    def _prepare(self, reference: float, torque: float) -> None:
        super()._prepare(reference, torque)
        old = self.state.observer
        begun = initial_observer(self.parameters.feedback)._replace(noise=old.noise, colour=old.colour)
        self.state = self.state._replace(observer=begun, held=initial_held_integral(), standing=initial_standing())

    @property
    def trust(self) -> float:
        """Share of the identified friction that is fed forward."""
        return float(self.state.trust.trust)

    @property
    def observer_gain(self) -> float:
        """Gain with which the observed torque is fed back, from 0 to 1."""
        return float(self.state.observer.gain)

    @property
    def torque_limit(self) -> float:
        """Limit of the drive that it was told, N m; to change it, make another one and hand it ``state_to_json()``."""
        return float(self.parameters.command.torque_limit)

    @property
    def observed_torque(self) -> float:
        """Torque that the feedforward lacks, as observed, N m."""
        return float(self.state.observer.disturbance)
