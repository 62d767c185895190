"""A joint of any kind: as a field of a model, at the start of a run, and as a thin class to be stepped."""

from typing import Annotated, Any

from pydantic import Discriminator, Tag

from plant.backlash import BacklashJoint
from plant.elastic import ElasticJoint
from plant.elasto_plastic import ElastoPlasticJoint
from plant.fields import check_finite
from plant.joint import FrictionFields, JointModel, gravity_torque, whole_multiple
from plant.lugre import LuGreJoint
from plant.maxwell import MaxwellJoint, RollingJoint
from plant.registry import INITIAL_STATE, STEP_JOINT


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
    return INITIAL_STATE[type(joint)](joint, float(velocity))


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
        self.model = model
        self._parameters = model.parameters
        self._step = STEP_JOINT[type(self._parameters)]
        self.state: Any = initial_state(self._parameters, velocity)

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
