"""Several adaptive joints as one controller with arrays."""

import copy
import json
import math
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from adaptive_ff.adaptive.controller import AdaptiveController
from adaptive_ff.adaptive.extensions.chain import JointRegressors
from adaptive_ff.adaptive.extensions.joints import checked_column, joints_of_table, named
from adaptive_ff.errors import check_kind, checked_path, read_text
from controllers import Controller, Inputs, Output
from controllers.arrays import ArrayLike, NDArray
from controllers.native import declined, fast_step
from controllers.registry import COMMANDED, MEASURED, PREVIEW, RULES, UNKNOWN

if TYPE_CHECKING:
    from adaptive_ff.adaptive.diagnosis import Diagnosis

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

COLUMNS = Inputs._fields
"""Inputs of a joint."""

OPTIONAL = (*(name for name in COLUMNS if name not in ("reference", "velocity", "dt")), "regressors")
"""Inputs that a step may do without."""

MAY_BE_UNKNOWN = tuple(name for name, rule in RULES.items() if rule in (MEASURED, PREVIEW, UNKNOWN))
"""Inputs that need not be finite, joint by joint: then they are not known."""


class JointGroup:
    """``u_i = PI(e_i) + feedforward_i`` for every joint i: adaptive controllers stepped together, with arrays.

    Each joint is identified on its own. Where it is said which joints precede which, in an arm whose joints turn about
    parallel axes, gravity is taken at the sum of the angles, and every joint carries the weight of those that follow:
    their sines and cosines are its further known regressors. Others may be given at each step, for each joint its own.

    A joint can have 20 further regressors (``MOST_REGRESSORS``), so in a chain ten joints may follow one:
    twelve in a row are refused. There ``preceding`` is left out, sums of angles are given as ``position``, and at most
    20 ``regressors`` of each joint: one sum for links whose weights are known but for a factor.

    Parameters
    ----------
    joints : mapping of str to AdaptiveController
        The joints by name, in the order of the arrays. All must have the same period.
    preceding : mapping of str to sequence of str, optional
        Names of all joints between the base and each joint, not only of the one before it; not named, a joint stands
        on the base.

    Raises
    ------
    TypeError
        The joints, or those that precede them, are not given by name, or the joints are no adaptive controllers.
    ValueError
        There is no joint, one stands under two names, periods differ, a name is unknown or precedes itself, one that
        precedes another is left out behind that, or a joint was made for fewer regressors than those that follow make,
        two for each, or would need more than 20.

    Examples
    --------
    >>> from adaptive_ff import JointGroup
    >>> from controllers import pi_gains
    >>> proportional, integral = pi_gains(20.0, 10.0)
    >>> joint = {"proportional": proportional, "integral": integral, "inertia": 20.0, "stribeck_velocity": 0.05}
    >>> table = {"period": 0.01, "joints": {"shoulder": joint, "elbow": {**joint, "preceding": ["shoulder"]}}}
    >>> group = JointGroup.from_table(table)
    >>> group.step([0.1, 0.2], [0.0, 0.0], position=[0.0, 0.5]).shape
    (2,)
    """

    def __init__(
        self, joints: Mapping[str, AdaptiveController], preceding: Mapping[str, Sequence[str]] | None = None
    ) -> None:
        check_kind("joints", joints, Mapping, "controllers by name, such as {'elbow': controller}")
        check_kind("preceding", preceding, (Mapping, NoneType), "names of the joints before each, by joint")
        if not joints:
            raise ValueError("joints = {} is not allowed: there must be one at least")
        self.joints = dict(joints)
        self._names, self._controllers = tuple(self.joints), tuple(self.joints.values())
        for name, controller in self.joints.items():
            check_kind(name, controller, AdaptiveController, "an AdaptiveController")
        if len({id(controller) for controller in self._controllers}) < len(self._controllers):
            raise ValueError("joints is not allowed: one controller stands under two names; each joint needs its own")
        periods = {controller.period for controller in self._controllers}
        if len(periods) > 1:
            raise ValueError(f"periods = {sorted(periods)} are not allowed: all joints must have the same")
        self.period = periods.pop()
        self._regressors = JointRegressors(self.joints, preceding)
        self._rows = np.empty((len(self.joints), len(COLUMNS) + len(Output._fields)))
        self._bound = -1  # what ``Controller.released`` was when addresses were taken
        self._fast: Callable[..., Any] = declined

    def __getstate__(self) -> dict[str, Any]:
        """Return what a copy is made of: no addresses."""
        return {**self.__dict__, "_bound": -1, "_fast": declined}

    @classmethod
    def from_table(cls, table: Mapping[str, Any]) -> Self:
        """Make a group from a table, such as a TOML file holds.

        Parameters
        ----------
        table : mapping
            ``period`` (s) and ``joints``, a table for each by name: arguments of :class:`AdaptiveController`, beside
            them ``identify`` (a key of ``adaptive_ff.friction.model.IDENTIFIED``, ``"gravity"`` by default) and
            ``preceding``, names of the joints between the base and this one. ``regressors`` counts those that are given
            at each step, not those that the joints behind it make; both together may be 20.

        Raises
        ------
        ValueError
            An entry is missing, unknown or not allowed; the message names the joint.
        TypeError
            It is no table.
        """
        return cls(*joints_of_table(table))

    @classmethod
    def from_toml(cls, path: str | Path) -> Self:
        """Make a group from a TOML file; see :meth:`from_table`."""
        text = read_text(checked_path("path", path), "is not valid TOML")
        try:
            return cls.from_table(tomllib.loads(text))
        except ValueError as error:
            raise ValueError(f"{path}: {error}") from error

    def step(
        self,
        reference: ArrayLike,
        velocity: ArrayLike,
        *,
        next_reference: ArrayLike | None = None,
        correction: ArrayLike = 0.0,
        position: ArrayLike | None = None,
        realised_torque: ArrayLike | None = None,
        feedforward: ArrayLike = 0.0,
        inertia: ArrayLike | None = None,
        regressors: ArrayLike | Sequence[ArrayLike | None] | None = None,
        dt: float | None = None,
        acting_reference: ArrayLike | None = None,
        next_acting_reference: ArrayLike | None = None,
    ) -> Array:
        """Compute the torques for the coming period.

        Parameters
        ----------
        reference, velocity : array_like, shape (n,)
            Planned and measured velocities, rad/s.
        next_reference, correction, position, realised_torque, feedforward, inertia : array_like, shape (n,), optional
            As in :meth:`controllers.Controller.step`. What is not finite of velocity, previews, position and realised
            torque is not known, for that joint alone; of a commanded input it is refused, for all.
        regressors : array_like, shape (n, k), or sequence of n vectors, optional
            Further known regressors of each joint, of the size of one: as many as it was made for beside those that
            the joints behind it make, which come before them in ``estimates``. Where none are given, for a joint with
            None, and where one is not finite, the last ones hold.
        dt : float, optional
            Time since the last call, s; the nominal period by default.
        acting_reference, next_acting_reference : array_like, shape (n,), optional
            As in :meth:`controllers.Controller.step`, and like the other preview.

        Returns
        -------
        ndarray, shape (n,)
            Torques, N m, always finite.

        Raises
        ------
        ValueError
            A shape is wrong, or a value is not allowed: reference, correction or feedforward of a joint is not finite,
            its inertia or ``dt`` not positive and finite, or its regressors are not as many as it takes or beyond 1e6
            in size. The message names the joint; nothing has been changed then, and no joint has been stepped.
        """
        if self._bound != Controller.released:
            self._bind()
        torques: Array = np.empty(len(self._controllers))
        found: Array | None = self._fast(
            torques,
            reference,
            velocity,
            next_reference,
            correction,
            position,
            realised_torque,
            feedforward,
            inertia,
            dt,
            acting_reference,
            next_acting_reference,
            regressors,
        )
        if found is not None:
            return found
        return self._checked_step(
            torques,
            reference,
            velocity,
            next_reference,
            correction,
            position,
            realised_torque,
            feedforward,
            inertia,
            dt,
            acting_reference,
            next_acting_reference,
            regressors,
        )

    def _bind(self) -> None:
        """Step all joints in one call, where they are in memory and none needs the angles of others."""
        self._bound, found = Controller.released, [controller._in_memory() for controller in self._controllers]
        natives = [native.addresses for native in found if native is not None]
        together = len(natives) == len(found) and not self._regressors.forms
        self._fast = fast_step(natives, self._rows, self.period, together=True) if together else declined

    def _checked_step(self, *given: Any) -> Array:
        """Do a step with inputs and regressors that have not been checked; of those left out, what stands for them."""
        torques: Array
        torques, *columns, regressors = given
        rows = np.full((torques.size, len(COLUMNS)), math.nan)
        for place, (name, values) in enumerate(zip(COLUMNS, columns, strict=True)):
            if values is not None or RULES[name] in (COMMANDED, MEASURED):
                rows[:, place] = checked_column(self._names, name, values, name in MAY_BE_UNKNOWN)
            elif name == "dt":
                rows[:, place] = self.period
        self._regressors.place(rows[:, COLUMNS.index("position")], self._regressors.checked(regressors))
        for place, (controller, row) in enumerate(zip(self._controllers, rows.tolist(), strict=True)):
            torques[place] = controller._run(*row)
        return torques

    @property
    def estimates(self) -> dict[str, dict[str, float]]:
        """Physical estimates of each joint, by name."""
        return {name: controller.estimates for name, controller in self.joints.items()}

    @property
    def rejected(self) -> dict[str, int]:
        """Number of measurements of each joint that were not finite and so were skipped."""
        return {name: controller.rejected for name, controller in self.joints.items()}

    @property
    def faults(self) -> dict[str, int]:
        """Number of samples at which another input of each joint was not plausible and so was not used."""
        return {name: controller.faults for name, controller in self.joints.items()}

    @property
    def fault(self) -> dict[str, bool]:
        """Whether the measurement of each joint has been lost for so long that its torque fades to zero."""
        return {name: controller.fault for name, controller in self.joints.items()}

    def diagnose(self) -> "dict[str, Diagnosis]":
        """Return what has been identified of each joint and how uncertain it is."""
        return {name: controller.diagnose() for name, controller in self.joints.items()}

    def take_over(
        self, torque: ArrayLike, reference: ArrayLike, velocity: ArrayLike, **given: ArrayLike | None
    ) -> None:
        """Prepare all joints for taking over without a jump; see :meth:`controllers.Controller.take_over`.

        Parameters
        ----------
        torque, reference, velocity : array_like, shape (n,)
            Torques that the drives give now, N m, planned and measured velocities, rad/s.
        **given : array_like, optional
            Other arguments of the :meth:`step` that comes next, ``regressors`` among them, but ``dt``.

        Raises
        ------
        ValueError
            A shape is wrong, or a value or a name is not allowed; no joint has been prepared then.
        """
        unknown = set(given) - set(OPTIONAL)
        if unknown:
            raise ValueError(f"{min(unknown)} is not allowed: it must be one of {', '.join(OPTIONAL)}")
        count = len(self._controllers)
        known = {name: value for name, value in given.items() if value is not None and name != "regressors"}
        further = self._regressors.checked(given.get("regressors"))
        columns = {}
        for name, value in {"torque": torque, "reference": reference, "velocity": velocity, **known}.items():
            may_be_unknown = name in MAY_BE_UNKNOWN and name != "velocity"
            columns[name] = np.broadcast_to(checked_column(self._names, name, value, may_be_unknown), count)
        columns["position"] = np.array(columns.get("position", np.full(count, math.nan)))
        with self._all_or_none():
            self._regressors.place(columns["position"], further)
            for place, (name, controller) in enumerate(self.joints.items()):
                row = {key: float(column[place]) for key, column in columns.items()}
                with named(name):
                    controller.take_over(
                        **{k: v for k, v in row.items() if math.isfinite(v) or k not in MAY_BE_UNKNOWN}
                    )

    @contextmanager
    def _all_or_none(self) -> Iterator[None]:
        """Give all joints their states back, regressors too, where one refuses."""
        before = [copy.deepcopy(controller.state) for controller in self._controllers]
        try:
            yield
        except ValueError:
            for controller, state in zip(self._controllers, before, strict=True):
                controller.state = state
            raise

    @property
    def enabled(self) -> Flags:
        """Whether each joint learns; may be set for all, or joint by joint, as a whole: ``enabled = [True, False]``."""
        return _read_only([controller.enabled for controller in self._controllers])

    @enabled.setter
    def enabled(self, value: ArrayLike) -> None:
        self._switch("enabled", value)

    @property
    def feedforward_enabled(self) -> Flags:
        """Whether each joint feeds what it has learnt, fading in and out; may be set as ``enabled`` is."""
        return _read_only([controller.feedforward_enabled for controller in self._controllers])

    @feedforward_enabled.setter
    def feedforward_enabled(self, value: ArrayLike) -> None:
        self._switch("feedforward_enabled", value)

    def _switch(self, name: str, value: ArrayLike) -> None:
        flags, joints = np.asarray(value), len(self._controllers)
        if flags.dtype != bool or flags.shape not in ((), (joints,)):
            raise ValueError(
                f"{name} = {flags.tolist()} is not allowed: it must be true or false, for all or for {joints} joints"
            )
        for controller, own in zip(self._controllers, np.broadcast_to(flags, joints), strict=True):
            setattr(controller, name, bool(own))

    def restart(self) -> None:
        """Let all joints begin at standstill with what they have learnt; see :meth:`controllers.Controller.restart`."""
        for controller in self._controllers:
            controller.restart()

    def reset(self) -> None:
        """Return all joints to the state of new ones."""
        for controller in self._controllers:
            controller.reset()

    def warm_up(self) -> None:
        """Compile or load the step before real-time use; the states are left as they are."""
        for controller in self._controllers:
            controller.warm_up()

    def state_to_json(self) -> str:
        """Return the states of all joints as one JSON text that restores them exactly."""
        saved = {name: json.loads(controller.state_to_json()) for name, controller in self.joints.items()}
        return json.dumps({"group": saved}, indent=1)

    def state_from_json(self, text: str) -> None:
        """Restore the states that a group of the same joints has saved.

        Raises
        ------
        ValueError
            The text is no such state; all joints keep the one they have.
        """
        try:
            saved = dict(json.loads(text)["group"])
            names = list(saved)
        except (KeyError, ValueError, TypeError, RecursionError) as error:
            why = f"{error} is missing" if isinstance(error, KeyError) else error
            raise ValueError(f"text = {str(text)[:40]!r} is no saved state of a group: {why}") from error
        if names != list(self.joints):
            raise ValueError(f"joints = {names} is not allowed: this group has {list(self.joints)}")
        with self._all_or_none():
            for name, controller in self.joints.items():
                with named(name):
                    controller.state_from_json(json.dumps(saved[name]))

    def run_uncompiled(self) -> Self:
        """Make all joints step in plain Python, for debugging; returns itself."""
        for controller in self._controllers:
            controller.run_uncompiled()
        return self


def _read_only(flags: list[bool]) -> Flags:
    """Return flags that refuse to be written one by one: they are no part of the joints."""
    array = np.array(flags)
    array.flags.writeable = False
    return array
