"""Further known regressors of the joints of a group: first those that the angles of a chain make, then given ones.

In a chain of parallel axes joint i turns the links from i on. The weight of link j acts along ``sin a_j``, where
``a_j`` is the sum of the positions from the base to j; ``sin a_i`` is gravity of the joint itself, and a sine and a
cosine of each ``a_j`` behind it are its further regressors, in the order of the joints.
"""

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from adaptive_ff.adaptive.arguments import MOST_REGRESSORS, further_names, refuse_large, write_finite
from adaptive_ff.adaptive.controller import AdaptiveController
from controllers.arrays import NDArray
from controllers.checks import checked_array

Array = NDArray[np.float64]

Given: TypeAlias = Sequence[Array | None]
"""What is given to each joint beside what is formed; None where the last ones hold."""


class JointRegressors:
    """The further known regressors of all joints.

    Parameters
    ----------
    joints : mapping of str to AdaptiveController
        The joints by name.
    preceding : mapping of str to sequence of str, or None
        Names of the joints between the base and each joint; with None nothing is formed.

    Raises
    ------
    ValueError
        A name is unknown or precedes itself, one that precedes another is left out behind that, a joint was made for
        fewer regressors than are formed, or one behind others is to learn what depends on its own position.
    """

    def __init__(self, joints: Mapping[str, AdaptiveController], preceding: Mapping[str, Sequence[str]] | None) -> None:
        self._controllers = tuple(joints.values())
        self._names = tuple(joints)
        self._gear_ratios = np.array([controller.parameters.hypothesis.gear_ratio for controller in self._controllers])
        self.forms = preceding is not None
        self._angles = link_angles(self._names, preceding or {})
        self._carried = [carried_links(self._angles, place) for place in range(len(self._names))]
        self._formed = [2 * carried.size if self.forms else 0 for carried in self._carried]
        self._none: Given = (None,) * len(self._names)
        for (name, controller), links, formed in zip(joints.items(), self._angles, self._formed, strict=True):
            if np.count_nonzero(links) > 1 and controller.depends_on_position:
                raise ValueError(
                    f"{name}.preceding is not allowed with ripple_periods, position_periods or position_hats: it is "
                    "given sums of angles, not its own one; leave preceding out and give sines of sums as regressors"
                )
            made_for = controller.parameters.hypothesis.regressors
            regressor_count(name, formed)
            if made_for < formed:
                raise ValueError(
                    f"{name} has regressors = {made_for}; it must be {formed} at least: a sine and a cosine for each "
                    "joint that follows, and then those that are given at each step"
                )

    def checked(self, given: Any) -> Given:
        """Return what is given to each joint, as arrays; nothing is changed.

        Parameters
        ----------
        given : array_like, shape (n, k), or sequence of n vectors, or None
            Regressors of each joint beside those that are formed. For a joint with None the last ones hold.

        Raises
        ------
        ValueError
            There is not one vector for each joint, one has not as many numbers as its joint was made for, or a number
            is too large.
        """
        if given is None:
            return self._none
        try:
            vectors = list(given)
        except TypeError:
            vectors = []
        if len(vectors) != len(self._names):
            raise ValueError(
                f"regressors = {given!r} is not allowed: it must be a vector, or None, for each of the "
                f"{len(self._names)} joints"
            )
        return [None if vector is None else self._vector(place, vector) for place, vector in enumerate(vectors)]

    def _vector(self, place: int, vector: Any) -> Array:
        name, formed = self._names[place], self._formed[place]
        count = self._controllers[place].regressors.size - formed
        try:
            array = checked_array("regressors", vector)
        except TypeError as error:
            raise ValueError(
                f"regressors of {name} = {vector!r} is not allowed: it must be a vector of {count}"
            ) from error
        if array.shape != (count,):
            beside = f", beside the {formed} that the joints behind it make" if formed else ""
            raise ValueError(
                f"regressors of {name} has shape {array.shape}; it must be ({count},), as it was made for{beside}"
            )
        refuse_large(f"regressors of {name}", array)
        return array

    def place(self, position: Array, given: Given) -> None:
        """Write the regressors of all joints into their states, and replace each position by the sum up to the joint.

        A sum with an unknown position is unknown: the joints that it concerns hold their last one. Positions of motors
        are summed as angles of their joints, and handed on as the controller takes them.
        """
        if given is not self._none:
            for controller, formed, vector in zip(self._controllers, self._formed, given, strict=True):
                if vector is not None:
                    write_finite(controller.regressors[formed:], vector)
        if not self.forms:
            return
        own = position / self._gear_ratios
        angles = np.array([np.sum(own[row != 0.0]) for row in self._angles])
        for controller, formed, carried in zip(self._controllers, self._formed, self._carried, strict=True):
            place = controller.regressors[:formed]
            with np.errstate(invalid="ignore"):
                write_finite(place[0::2], np.sin(angles[carried]))
                write_finite(place[1::2], np.cos(angles[carried]))
        position[:] = self._gear_ratios * angles


def regressor_count(name: str, formed: int, given: int = 0) -> int:
    """Return how many further regressors a joint is made for, or raise ``ValueError`` where they are too many."""
    count = formed + len(further_names(given))
    if count > MOST_REGRESSORS:
        raise ValueError(
            f"{name}.regressors = {count} is not allowed: a sine and a cosine for each of the {formed // 2} joints "
            f"that follow, and {given} given ones, are more than {MOST_REGRESSORS}, the most that can be identified; "
            "leave preceding out, give sums of angles as position, and as regressors sums of those whose ratio is known"
        )
    return count


def carried_links(angles: Array, place: int) -> NDArray[np.intp]:
    """Return the places of the joints that follow the joint at a place."""
    follows = angles[:, place] != 0.0
    follows[place] = False
    return np.flatnonzero(follows)


def link_angles(names: tuple[str, ...], preceding: Mapping[str, Sequence[str]]) -> Array:
    """Return the matrix, of ones and zeros, that makes the angles of the links of the positions, shape (n, n).

    Raises
    ------
    ValueError
        A name is unknown, comes twice or precedes itself, or one that precedes another is left out behind that.
    """
    matrix = np.eye(len(names))
    for name, others in preceding.items():
        if isinstance(others, str) or not isinstance(others, Sequence):
            raise ValueError(f"{name}.preceding = {others!r} is not allowed: it must be a list of names")
        for other in (name, *others):
            if other not in names:
                raise ValueError(f"preceding: {other!r} is not a joint; there are {', '.join(names)}")
        if name in others or len(set(others)) < len(others):
            raise ValueError(f"{name}.preceding = {list(others)} is not allowed: every name once, not its own")
        for other in others:
            matrix[names.index(name), names.index(other)] = 1.0
    for name, others in preceding.items():
        for other in others:
            for first in preceding.get(other, ()):
                if first not in others:
                    raise ValueError(
                        f"{name}.preceding = {list(others)} is not allowed: {first} precedes {other}; it must be all "
                        "joints between the base and this one"
                    )
    return matrix
