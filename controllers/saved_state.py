"""States of controllers as JSON content: what they belong to, and whether a controller can go on from them.

A state is numbers without a meaning of their own: those of a heavy joint are finite and of the right shape for a light
one, and command a thousand newton metres there. So a text says whose it is, and one that does not fit is refused.
"""

import copy
import json
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from controllers.arrays import unpacked

SAME = 1e-9
"""Relative difference up to which two numbers are the same."""

LARGEST = 1e20
"""Numbers beyond that no state holds; a recursion over them would overflow."""

LEAST_EIGENVALUE = -1e-7
"""What the eigenvalues of a covariance, scaled to ones on the diagonal, must exceed: certainty has zeros."""


def plain_state(value: Any) -> Any:
    """Return a state as plain content that JSON can hold."""
    if hasattr(value, "_asdict"):
        return {key: plain_state(item) for key, item in value._asdict().items()}
    if isinstance(value, np.ndarray):
        return value.tolist()
    return value


def rebuilt_state(template: Any, content: Any, where: str) -> Any:
    """Rebuild a state like the template from plain JSON content.

    Raises
    ------
    ValueError
        The content is of another shape or type, or not finite.
    """
    if hasattr(template, "_asdict"):
        if not isinstance(content, dict):
            raise ValueError(f"{where} must have the fields {', '.join(template._fields)}")
        missing = [name for name in template._fields if name not in content]
        unknown = [name for name in content if name not in template._fields]
        if missing or unknown:
            raise ValueError(
                f"{where} must have the fields {', '.join(template._fields)}: {', '.join(missing) or 'none'} missing, "
                f"{', '.join(unknown)[:80] or 'none'} unknown; was it saved by another version?"
            )
        items = template._asdict().items()
        return type(template)(**{key: rebuilt_state(item, content[key], f"{where}.{key}") for key, item in items})
    kind = np.asarray(template).dtype.type
    try:
        array = np.array(content)
        allowed = {"f": "if", "i": "i", "b": "b"}[np.dtype(kind).kind]
        if array.size and array.dtype.kind not in allowed:
            raise ValueError(f"it must hold numbers of type {kind.__name__}")
        array = array.astype(kind)
        if array.size == 0 and np.size(template) == 0:
            array = array.reshape(np.shape(template))  # JSON keeps no shape of an array without numbers
    except (TypeError, ValueError) as error:
        raise ValueError(f"{where} = {repr(content)[:80]} is not allowed: {error}") from error
    if array.shape != np.shape(template) or not np.all(np.isfinite(array)):
        raise ValueError(f"{where} must be finite and of shape {np.shape(template)}, not {repr(content)[:80]}")
    if isinstance(template, tuple):
        return tuple(array.tolist())
    return array if isinstance(template, np.ndarray) else array.item()


def saved_text(name: str, version: int, belongs: Mapping[str, Any], state: Any) -> str:
    """Return the text of a state."""
    content = {"controller": name, "version": version, "belongs_to": dict(belongs), "state": plain_state(state)}
    return json.dumps(content, indent=1)


def restored(text: str, name: str, version: int, belongs: Mapping[str, Any], template: Any) -> Any:
    """Return the state of a text that was saved by a controller like this one."""
    try:
        saved = json.loads(text)
        found, content = saved["controller"], saved["state"]
    except KeyError as error:
        raise ValueError(f"text = {str(text)[:40]!r} is no saved controller state: {error} is missing") from error
    except (json.JSONDecodeError, TypeError, RecursionError, UnicodeDecodeError) as error:
        raise ValueError(f"text = {str(text)[:40]!r} is no saved controller state: {error}") from error
    if found != name:
        raise ValueError(f"controller = {str(found)[:40]!r} is not allowed: this is a {name!r}")
    if saved.get("version") != version:
        raise ValueError(
            f"version of the state = {str(saved.get('version'))[:40]} is not allowed: it must be {version}"
        )
    _check_belongs(saved.get("belongs_to"), belongs)
    state = rebuilt_state(template, content, "state")
    check_numbers_of(state, "state")
    return state


def _check_belongs(found: Any, wanted: Mapping[str, Any]) -> None:
    if not isinstance(found, dict) or set(found) != set(wanted):
        unknown = sorted(set(found) - set(wanted)) if isinstance(found, dict) else []
        beside = f", not {unknown[0][:40]}" if unknown else ""
        raise ValueError(f"state: belongs_to must have the fields {', '.join(wanted)}{beside}")
    for key, value in wanted.items():
        other = found[key]
        number = isinstance(other, int | float) and not isinstance(other, bool)
        same = math.isclose(other, value, rel_tol=SAME) if number and isinstance(value, float) else other == value
        if not same:
            raise ValueError(f"{key} = {str(other)[:80]} is not allowed: this controller has {value}")


def check_numbers_of(value: Any, where: str) -> None:
    """Raise ``ValueError`` where a state (a named tuple) has too large numbers, or a matrix that is not definite."""
    for key, item in value._asdict().items():
        if hasattr(item, "_asdict"):
            check_numbers_of(item, f"{where}.{key}")
        elif np.any(np.abs(np.asarray(item, dtype=np.float64)) > LARGEST):
            raise ValueError(f"{where}.{key} is not allowed: its numbers must be at most {LARGEST:g}")
        elif key == "covariance" and not _is_semi_definite(item if np.ndim(item) == 2 else unpacked(item)):
            raise ValueError(f"{where}.{key} is not allowed: it must be symmetric and positive semi-definite")


def _is_semi_definite(matrix: Any) -> bool:
    squares = np.diag(matrix)
    if np.any(squares < 0.0) or not np.allclose(matrix, np.transpose(matrix), rtol=SAME, atol=0.0):
        return False
    units = np.sqrt(np.where(squares > 0.0, squares, 1.0))
    return bool(np.linalg.eigvalsh(matrix / np.outer(units, units))[0] > LEAST_EIGENVALUE)


def check_feedback(feedback: Any, largest: float) -> None:
    """Raise ``ValueError`` where a feedback has counts of no run, or a torque (N m) beyond the largest."""
    if not 0 <= feedback.rejected <= feedback.samples or feedback.guard.faults < 0 or feedback.guard.lost < 0.0:
        raise ValueError(
            f"state.feedback is not allowed: samples = {feedback.samples}, rejected = {feedback.rejected}, "
            f"faults = {feedback.guard.faults} and lost = {feedback.guard.lost} must be counts of one run"
        )
    for torque in (feedback.integral, *feedback.commands):
        if abs(torque) > largest:
            raise ValueError(f"state.feedback: torque = {torque} N m is not allowed: at most {largest:g} is plausible")


def check_it_goes_on(state: Any, step: Callable[[Any], tuple[Any, Any]]) -> None:
    """Try a few steps on a copy of a state."""
    tried = copy.deepcopy(state)
    try:
        for _ in range(3):
            output, tried = step(tried)
            if not math.isfinite(output.torque):
                raise ValueError("the torque is not finite")
        rebuilt_state(tried, plain_state(tried), "state")
    except (ArithmeticError, LookupError, ValueError) as error:
        raise ValueError(f"state is not allowed: no controller can go on from it: {error}") from error
