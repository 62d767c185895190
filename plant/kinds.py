"""The kinds of joints, by their parameters and states, and a thin class to step any of them."""

from collections.abc import Callable
from typing import Annotated, Any

from numba.extending import register_jitable
from pydantic import Discriminator, Tag

from plant.backlash import (
    BacklashParameters,
    BacklashState,
    initial_backlash,
    step_backlash,
)
from plant.backlash_joint import BacklashJoint, check_backlash_period
from plant.change import scaled_friction
from plant.checks import check_finite
from plant.elastic import (
    ElasticParameters,
    ElasticState,
    changed_elastic,
    initial_elastic,
    sensed_elastic,
    step_elastic,
)
from plant.elastic_joint import ElasticJoint, check_elastic_period
from plant.elasto_plastic import (
    ElastoPlasticParameters,
    ElastoPlasticState,
    initial_elasto_plastic,
    step_elasto_plastic,
)
from plant.elasto_plastic_joint import ElastoPlasticJoint, check_elasto_plastic_period
from plant.gravity import gravity_torque
from plant.joint import FrictionFields, JointModel, check_unique_step, whole_multiple
from plant.lugre import (
    LuGreParameters,
    LuGreState,
    changed_lugre,
    initial_lugre,
    scaled_lugre,
    step_lugre,
)
from plant.lugre_joint import LuGreJoint, check_lugre_period
from plant.maxwell import (
    MaxwellParameters,
    MaxwellState,
    changed_maxwell,
    initial_maxwell,
    scaled_maxwell,
    step_maxwell,
)
from plant.maxwell_joint import MaxwellJoint, RollingJoint, check_maxwell_period
from plant.step import (
    JointParameters,
    JointState,
    ReadyJoint,
    changed_joint,
    initial_joint,
    ready_joint,
    scaled_joint,
    sensed_velocity,
    step_joint,
    step_ready_joint,
)

STEP_JOINT: dict[type, Callable[..., Any]] = {
    JointParameters: step_joint,
    LuGreParameters: step_lugre,
    ElasticParameters: step_elastic,
    BacklashParameters: step_backlash,
    MaxwellParameters: step_maxwell,
    ElastoPlasticParameters: step_elasto_plastic,
}
"""Kernel ``step(parameters, state, torque, period) -> state`` for each class of parameters."""


@register_jitable
def as_it_is(joint: Any, period: float) -> Any:
    """Return a joint whose step has no constants worth keeping."""
    return joint


READY_JOINT: dict[type, Callable[..., Any]] = {
    **dict.fromkeys(STEP_JOINT, as_it_is),
    JointParameters: ready_joint,
}
"""Kernel ``ready(parameters, period) -> ready`` for each class of parameters: constants of the step, found once."""

STEP_READY: dict[type, Callable[..., Any]] = {**STEP_JOINT, ReadyJoint: step_ready_joint}
"""Kernel ``step(ready, state, torque, period) -> state`` for each class that :data:`READY_JOINT` makes."""

SCALE_JOINT: dict[type, Callable[..., Any]] = {
    JointParameters: scaled_joint,
    LuGreParameters: scaled_lugre,
    ElasticParameters: scaled_friction,
    BacklashParameters: scaled_friction,
    MaxwellParameters: scaled_maxwell,
    ElastoPlasticParameters: scaled_friction,
}
"""Kernel ``scaled(parameters, factor) -> parameters`` for each class of parameters: friction times a factor."""

CHANGE_JOINT: dict[type, Callable[..., Any]] = {
    JointParameters: changed_joint,
    LuGreParameters: changed_lugre,
    ElasticParameters: changed_elastic,
    BacklashParameters: changed_elastic,
    MaxwellParameters: changed_maxwell,
    ElastoPlasticParameters: changed_joint,
}
"""Kernel ``changed(parameters, change) -> parameters`` for each class of parameters; see ``plant.change``."""

SENSED_VELOCITY: dict[type, Callable[..., Any]] = {
    JointState: sensed_velocity,
    LuGreState: sensed_velocity,
    ElasticState: sensed_elastic,
    BacklashState: sensed_elastic,
    MaxwellState: sensed_velocity,
    ElastoPlasticState: sensed_velocity,
}
"""Kernel ``sensed(state) -> velocity`` at the motor, rad/s, for each class of states."""

INITIAL_STATE: dict[type, Callable[..., Any]] = {
    JointParameters: initial_joint,
    LuGreParameters: initial_lugre,
    ElasticParameters: initial_elastic,
    BacklashParameters: initial_backlash,
    MaxwellParameters: initial_maxwell,
    ElastoPlasticParameters: initial_elasto_plastic,
}
"""``initial(parameters, velocity) -> state``, in plain Python, for each class of parameters."""

CHECK_PERIOD: dict[type, Callable[..., None]] = {
    JointParameters: check_unique_step,
    LuGreParameters: check_lugre_period,
    ElasticParameters: check_elastic_period,
    BacklashParameters: check_backlash_period,
    MaxwellParameters: check_maxwell_period,
    ElastoPlasticParameters: check_elasto_plastic_period,
}
"""``check(parameters, period)``, in plain Python, for each class of parameters; refuses a solver period."""


def _kind(table: Any) -> Any:
    return table.get("kind", "stribeck") if isinstance(table, dict) else getattr(table, "kind", "stribeck")


AnyJoint = Annotated[
    Annotated[JointModel, Tag("stribeck")]
    | Annotated[LuGreJoint, Tag("lugre")]
    | Annotated[ElasticJoint, Tag("elastic")]
    | Annotated[BacklashJoint, Tag("backlash")]
    | Annotated[MaxwellJoint, Tag("maxwell")]
    | Annotated[RollingJoint, Tag("rolling")]
    | Annotated[ElastoPlasticJoint, Tag("elasto_plastic")],
    Discriminator(_kind),
]
"""A joint of any kind, as a field of a model; without a kind it is a rigid joint with lagged Stribeck friction."""


def initial_state(joint: Any, velocity: float) -> Any:
    """Return the state of a joint of any kind that has moved at a velocity (rad/s) for long; its position is zero.

    Raises
    ------
    ValueError
        The velocity is not finite.
    TypeError
        The joint is none, or the velocity no number.
    """
    if type(joint) not in INITIAL_STATE:
        raise TypeError(f"joint = {joint!r} is not allowed: it must be the parameters of a joint of any kind")
    check_finite("velocity", velocity, "rad/s")
    return INITIAL_STATE[type(joint)](joint, velocity)


class Joint:
    """A joint of any kind to step in one's own loop.

    Parameters
    ----------
    model : JointModel, LuGreJoint or another of ``AnyJoint``
        Parameters of the joint.
    velocity : float, optional
        Velocity at the start, rad/s; the joint has moved so for long.

    Raises
    ------
    ValueError
        The velocity is not finite.
    TypeError
        The model is none of ``AnyJoint``, or the velocity no number.

    Examples
    --------
    >>> from plant import Joint, JointModel
    >>> joint = Joint(JointModel(inertia=20.0, coulomb=60.0, stiction=90.0, viscous=80.0, stribeck_velocity=0.05))
    >>> joint.step(80.0, 0.01)  # below the stiction: it rests
    0.0
    """

    def __init__(self, model: AnyJoint, velocity: float = 0.0) -> None:
        if not isinstance(model, FrictionFields):
            raise TypeError(f"model = {model!r} is not allowed: it must be a JointModel, or another joint of AnyJoint")
        check_finite("velocity", velocity, "rad/s")
        self.model = model
        self._parameters = model.parameters
        self._step = STEP_JOINT[type(self._parameters)]
        self.state: Any = initial_state(self._parameters, float(velocity))

    def step(self, torque: float, duration: float) -> float:
        """Apply a constant torque for a while and return the velocity reached.

        Parameters
        ----------
        torque : float
            Torque, N m.
        duration : float
            Duration, s, a whole number of solver periods.

        Returns
        -------
        float
            Velocity at the end, rad/s; of an elastic joint, the link's.

        Raises
        ------
        ValueError
            The torque is not finite, or the duration is not a whole number of solver periods.
        TypeError
            An argument is no number.
        """
        check_finite("torque", torque, "N m")
        steps = whole_multiple(duration, self.model.solver_period)
        if steps is None:
            raise ValueError(
                f"duration = {duration} s is not allowed: it must be a whole number of solver periods of "
                f"{self.model.solver_period:g} s"
            )
        for _ in range(steps):
            pull = gravity_torque(self.model.weight, self.state.position)
            self.state = self._step(self._parameters, self.state, float(torque) - pull, self.model.solver_period)
        return float(self.state.velocity)
