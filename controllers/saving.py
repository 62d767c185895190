"""States as JSON content: nested named tuples of numbers and arrays."""

from typing import Any

import numpy as np


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
