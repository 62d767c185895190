"""What a group is given: joints, from a table such as a TOML file holds, and columns of inputs."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np

from adaptive_ff.adaptive.controller import AdaptiveController
from adaptive_ff.adaptive.extensions.chain import carried_links, link_angles, regressor_count
from adaptive_ff.errors import check_kind
from adaptive_ff.friction.model import IDENTIFIED
from controllers.arrays import ArrayLike, NDArray
from controllers.checks import checked_array

INSTEAD = {"parameters": "it is named by identify", "period": "all joints have that of the group"}
"""Arguments of a controller that a table of a joint must not hold, and what stands in their place."""


def joints_of_table(table: Mapping[str, Any]) -> tuple[dict[str, AdaptiveController], dict[str, Any] | None]:
    """Return controllers by name, and the joints before each where any are named; see ``JointGroup.from_table``."""
    check_kind("table", table, Mapping, "a table with period and joints; from_toml(path) reads a file")
    unknown = set(table) - {"period", "joints"}
    if unknown:
        raise ValueError(f"{min(unknown)} is not allowed: a group has period and joints")
    for name in ("period", "joints"):
        if name not in table:
            raise ValueError(f"{name} is missing: a group has period and joints")
    if not isinstance(table["joints"], Mapping):
        raise ValueError(f"joints = {table['joints']!r} is not allowed: it must be a table for each joint")
    for name, entry in table["joints"].items():
        if not isinstance(entry, Mapping):
            raise ValueError(f"{name} = {entry!r} is not allowed: it must be a table of settings")
    entries = {name: dict(entry) for name, entry in table["joints"].items()}
    coupled = any("preceding" in entry for entry in entries.values())
    preceding = {name: entry.pop("preceding", ()) for name, entry in entries.items()}
    angles = link_angles(tuple(entries), preceding)
    joints = {}
    for place, (name, entry) in enumerate(entries.items()):
        identify = entry.pop("identify", "gravity")
        if not isinstance(identify, str) or identify not in IDENTIFIED:
            raise ValueError(
                f"{name}.identify = {identify!r} is not allowed: it must be one of {', '.join(IDENTIFIED)}"
            )
        for key, instead in INSTEAD.items():
            if key in entry:
                raise ValueError(f"{name}.{key} is not allowed: {instead}")
        formed = 2 * carried_links(angles, place).size
        try:
            if coupled:
                entry["regressors"] = regressor_count(name, formed, entry.get("regressors", 0))
            joints[name] = AdaptiveController(period=table["period"], parameters=IDENTIFIED[identify], **entry)
        except (TypeError, ValueError) as error:
            text = str(error).replace("AdaptiveController.__init__() ", "")
            raise ValueError(text if text.startswith(f"{name}.") else f"{name}: {text}") from error
    return joints, preceding if coupled else None


def checked_column(joints: tuple[str, ...], name: str, values: ArrayLike, may_be_unknown: bool) -> NDArray[np.float64]:
    """Return an input as an array, a number for each joint or one for all; refuse what is not allowed."""
    count = len(joints)
    try:
        array = checked_array(name, values)
    except TypeError as error:
        raise ValueError(f"{name} = {values!r} is not allowed: it must be {count} numbers") from error
    if name == "dt" and array.shape:
        raise ValueError(f"dt has shape {array.shape}; it must be one number for all joints")
    if array.shape not in ((), (count,)):
        raise ValueError(f"{name} has shape {array.shape}; it must be ({count},)")
    positive = name in ("inertia", "dt")
    allowed = np.isfinite(array) & (array > 0.0 if positive else True)
    if not (may_be_unknown or np.all(allowed)):
        place = int(np.argmin(allowed))
        limits = "positive and finite" if positive else "a finite number"
        where = f"{name} of {joints[place]}"
        raise ValueError(f"{where} = {array.flat[place]} is not allowed: it must be {limits}")
    return array


@contextmanager
def named(joint: str) -> Iterator[None]:
    """Name the joint in what its controller refuses."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{joint}: {error}") from error
