"""A controller's state as bytes that the exported code reads and writes as well.

A header of 24 bytes, then all numbers of the state in their order. Numbers are little-endian on every machine: reals
of 8 bytes, or 4 in single precision, integers of 8, truth values of 1. The header holds the letters ``AFFS``, the
version of this format, the whole size, a checksum of the numbers (FNV-1a, 32 bits) and a hash of what the state holds
and belongs to (64 bits), so that a state of another controller, of one for another joint, or of another version of it,
is refused.
"""

import hashlib
import math
import struct
from collections.abc import Iterator
from typing import Any

import numpy as np

from adaptive_ff.errors import InputError
from controllers import Controller
from controllers.kernels.leaves import Leaf, leaves, rebuilt, value_at
from controllers.kernels.types import BOOLEAN, INTEGER, REAL, Type, type_of

MAGIC = b"AFFS"
VERSION = 1
HEADER = struct.Struct("<4sIIIQ")
"""Letters, version, size, checksum, hash."""


def layout(controller: Controller) -> list[Leaf]:
    """Return the numbers of a controller's state in their order."""
    return list(leaves(type_of(controller.state, "state", sizes=True)))


def formats(single: bool) -> dict[Type, str]:
    """Return how each kind of number is written."""
    return {REAL: "f" if single else "d", INTEGER: "q", BOOLEAN: "B"}


def belongings(controller: Controller) -> list[str]:
    """Return what a state belongs to: what JSON keeps with it, and the curves that are tried, of which it names one.

    Numbers have nine digits: the same design on another machine may differ in the last ones.
    """
    estimator = getattr(controller.parameters, "estimator", None)
    tried = {name: np.ravel(getattr(estimator, name, ())).tolist() for name in ("candidates", "presliding")}
    return [f"{name} {_nine_digits(value)}" for name, value in {**controller._belongs_to(), **tried}.items()]


def _nine_digits(value: Any) -> str:
    if isinstance(value, list):
        return " ".join(map(_nine_digits, value))
    return f"{value:.9g}" if isinstance(value, float) else str(value)


def layout_hash(controller: Controller, single: bool) -> int:
    """Return the hash of what the state holds and belongs to: the controller's class, its joint and loop, all names."""
    text = ";".join(
        [
            type(controller).__name__,
            "single" if single else "double",
            *belongings(controller),
            *(f"{leaf.path} {leaf.kind.kind} {leaf.shape}" for leaf in layout(controller)),
        ]
    )
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "little")


def checksum(content: bytes) -> int:
    """Return the 32-bit FNV-1a hash of some bytes."""
    total = 2166136261
    for byte in content:
        total = (total ^ byte) * 16777619 & 0xFFFFFFFF
    return total


def payload_size(controller: Controller, single: bool) -> int:
    """Return how many bytes the numbers of the state take."""
    letters = formats(single)
    return sum(struct.calcsize(letters[leaf.kind]) * leaf.count for leaf in layout(controller))


def state_to_bytes(controller: Controller, *, single: bool = False) -> bytes:
    """Return the state of a controller for the exported code's ``load_state``."""
    letters = formats(single)
    payload = b""
    for leaf in layout(controller):
        numbers = np.ravel(np.asarray(value_at(controller.state, leaf.path))).tolist()
        payload += struct.pack(f"<{len(numbers)}{letters[leaf.kind]}", *numbers)
    size = HEADER.size + len(payload)
    return HEADER.pack(MAGIC, VERSION, size, checksum(payload), layout_hash(controller, single)) + payload


def state_from_bytes(controller: Controller, content: bytes, *, single: bool = False) -> None:
    """Restore a state that the exported code's ``save_state`` wrote."""
    expected = HEADER.size + payload_size(controller, single)
    if len(content) != expected:
        raise InputError(f"state of {len(content)} bytes is not allowed: one of this controller has {expected}")
    letters, version, size, total, found = HEADER.unpack(content[: HEADER.size])
    payload = content[HEADER.size :]
    if letters != MAGIC or version != VERSION or size != expected:
        raise InputError(f"state = {content[:12]!r}... is no saved state of version {VERSION}")
    if found != layout_hash(controller, single):
        raise InputError(
            f"state with hash {found:016x} is of another controller than this {type(controller).__name__}, or of one "
            "with another period, inertia, gain or list of estimates"
        )
    if total != checksum(payload):
        raise InputError("state is damaged: its checksum does not agree with its numbers")
    numbers = list(_numbers(controller, payload, single))
    if any(isinstance(value, float) and math.isnan(value) for values in numbers for value in values):
        raise InputError("state holds what is not a number")
    flat = (values if leaf.is_array else values[0] for leaf, values in zip(layout(controller), numbers, strict=True))
    controller.state = rebuilt(controller.state, flat)


def _numbers(controller: Controller, payload: bytes, single: bool) -> Iterator[list[Any]]:
    letters, place = formats(single), 0
    for leaf in layout(controller):
        part = struct.Struct(f"<{leaf.count}{letters[leaf.kind]}")
        yield list(part.unpack_from(payload, place))
        place += part.size
