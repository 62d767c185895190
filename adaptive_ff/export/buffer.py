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
from itertools import islice
from typing import Any

import numpy as np

from adaptive_ff.errors import InputError
from controllers import Controller
from controllers.kernels.memory import Leaf, leaves, rebuilt, value_at
from controllers.kernels.types import BOOLEAN, INTEGER, REAL, Type, type_of

MAGIC = b"AFFS"
VERSION = 1
HEADER = struct.Struct("<4sIIIQ")
"""Letters, version, size, checksum, hash."""


def layout(controller: Controller) -> list[Leaf]:
    """Return the numbers of a controller's state in their order."""
    return list(leaves(type_of(controller.state, "state", sizes=True)))


def payload(controller: Controller, single: bool) -> struct.Struct:
    """Return how the numbers of a controller's state are written."""
    letters: dict[Type, str] = {REAL: "f" if single else "d", INTEGER: "q", BOOLEAN: "B"}
    return struct.Struct("<" + "".join(f"{leaf.count}{letters[leaf.kind]}" for leaf in layout(controller)))


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


def state_to_bytes(controller: Controller, *, single: bool = False) -> bytes:
    """Return the state of a controller for the exported code's ``load_state``."""
    values = (value_at(controller.state, leaf.path) for leaf in layout(controller))
    content = payload(controller, single).pack(*(number for value in values for number in np.ravel(value).tolist()))
    size = HEADER.size + len(content)
    return HEADER.pack(MAGIC, VERSION, size, checksum(content), layout_hash(controller, single)) + content


def state_from_bytes(controller: Controller, content: bytes, *, single: bool = False) -> None:
    """Restore a state that the exported code's ``save_state`` wrote."""
    written = payload(controller, single)
    expected = HEADER.size + written.size
    if len(content) != expected:
        raise InputError(f"state of {len(content)} bytes is not allowed: one of this controller has {expected}")
    letters, version, size, total, found = HEADER.unpack(content[: HEADER.size])
    if letters != MAGIC or version != VERSION or size != expected:
        raise InputError(f"state = {content[:12]!r}... is no saved state of version {VERSION}")
    if found != layout_hash(controller, single):
        raise InputError(
            f"state with hash {found:016x} is of another controller than this {type(controller).__name__}, or of one "
            "with another period, inertia, gain or list of estimates"
        )
    if total != checksum(content[HEADER.size :]):
        raise InputError("state is damaged: its checksum does not agree with its numbers")
    numbers = written.unpack_from(content, HEADER.size)
    if any(isinstance(value, float) and math.isnan(value) for value in numbers):
        raise InputError("state holds what is not a number")
    left = iter(numbers)
    flat = (list(islice(left, leaf.count)) if leaf.is_array else next(left) for leaf in layout(controller))
    controller.state = rebuilt(controller.state, flat)
