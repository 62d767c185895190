"""Regression gate: tracking must stay as good as it was."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from adaptive_ff.comparison.comparison import Comparison
from adaptive_ff.errors import InputError

GATED = ("rms_error", "max_error", "rms_error_start", "rms_error_settled", "max_error_settled", "torque_variation")
"""Figures of merit that may not get worse; smaller is better for all of them."""

TOLERANCE = 0.05
"""Default tolerance, relative."""


def read_baseline(path: str | Path) -> dict[str, Any]:
    """Read a result that ``adaptive-ff compare --json`` wrote.

    Raises
    ------
    InputError
        The file cannot be read or is no such result.
    """
    try:
        content = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror or error}") from error
    except (UnicodeDecodeError, ValueError, RecursionError) as error:
        raise InputError(f"{path}: is not valid JSON: {error}") from error
    if not isinstance(content, dict):
        content = {}
    controllers = content.get("controllers")
    if not isinstance(controllers, dict) or not controllers:
        raise InputError(f"{path}: controllers is missing; the file must be a result of 'adaptive-ff compare --json'")
    for name, figures in controllers.items():
        for figure in GATED:
            value = figures.get(figure) if isinstance(figures, dict) else None
            if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value) or value < 0.0:
                raise InputError(
                    f"{path}: controllers.{name}.{figure} = {value!r} is not allowed: it must be a finite number >= 0"
                )
    return content


def regressions(comparison: Comparison, baseline: Mapping[str, Any], tolerance: float = TOLERANCE) -> list[str]:
    """Return what got worse than a baseline, a sentence each; empty where nothing did.

    Parameters
    ----------
    comparison : Comparison
        The result now.
    baseline : mapping
        The earlier result, see :func:`read_baseline`.
    tolerance : float, optional
        How much worse a figure may be, relative, zero or more.

    Raises
    ------
    ValueError
        The tolerance is negative or not finite.
    """
    if not (math.isfinite(tolerance) and tolerance >= 0.0):
        raise ValueError(f"tolerance = {tolerance} is not allowed: it must be finite and not negative")
    now = comparison.to_dict()["controllers"]
    found = []
    for name, before in baseline["controllers"].items():
        if name not in now:
            found.append(f"{name}: is in the baseline, but was not run")
            continue
        for figure in GATED:
            old, new = before[figure], now[name][figure]
            if new > old * (1.0 + tolerance):
                growth = f"{100.0 * (new / old - 1.0):.1f} %" if old > 0.0 else "from zero"
                found.append(
                    f"{name}: {figure} grew from {old:.4g} to {new:.4g} ({growth}, allowed {100 * tolerance:g} %)"
                )
    return found


def assert_no_regression(comparison: Comparison, baseline: str | Path, tolerance: float = TOLERANCE) -> None:
    """Fail a test where tracking got worse than a stored result.

    Parameters
    ----------
    comparison : Comparison
        The result now.
    baseline : str or Path
        A file that ``adaptive-ff compare --json`` wrote.
    tolerance : float, optional
        How much worse a figure may be, relative.

    Raises
    ------
    AssertionError
        Something got worse; the message says what.
    InputError
        The baseline cannot be read.
    """
    found = regressions(comparison, read_baseline(baseline), tolerance)
    if found:
        raise AssertionError("tracking got worse:\n" + "\n".join(found))
