"""The state of a replayed controller with its settings, as one JSON text."""

import json
import math
from pathlib import Path

from adaptive_ff.adaptive.controller import UnsupervisedController
from adaptive_ff.errors import InputError, read_text
from adaptive_ff.friction.bounds import INERTIA
from adaptive_ff.replay.settings import ReplaySettings

KEPT = 0.01
"""Share that is kept of what is known of the inertia where a state is carried over, as an information. The posture may
be another one, and with it the inertia; friction stays. Of KUKA KR300 and EMPS, one record to the other, 0.01 leaves
4 % less torque while the reference moves than 1; the same share of friction would leave 3 % more."""


def state_to_json(settings: ReplaySettings, controller: UnsupervisedController) -> str:
    """Return settings and state as a text that restores both exactly."""
    return json.dumps({"settings": settings.to_dict(), **json.loads(controller.state_to_json())}, indent=1) + "\n"


def state_from_json(text: str) -> tuple[ReplaySettings, UnsupervisedController]:
    """Return settings and controller of a saved text.

    Raises
    ------
    InputError
        The text is no such state.
    """
    try:
        content = json.loads(text)
        table = content.pop("settings")
        if not isinstance(table, dict):
            raise TypeError("settings is no table")
    except (json.JSONDecodeError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(f"{text[:40]!r} is no saved state of a replay: {error}") from error
    settings = ReplaySettings.from_dict(table)
    controller = settings.controller()
    try:
        controller.state_from_json(json.dumps(content))
    except ValueError as error:
        raise InputError(str(error)) from error
    return settings, controller


def carry_over(controller: UnsupervisedController) -> None:
    """Let a controller forget the inertia, but for a share, and of the other parameters nothing.

    What errors are usual is not known either: with those of the other record, errors of another inertia would be taken
    for a sudden load.
    """
    state = controller.state
    estimator, block = state.estimator, controller.parameters.estimator
    information = estimator.recursion.information
    information[INERTIA, :] *= math.sqrt(KEPT)  # row and column: what is left stays positive definite
    information[:, INERTIA] *= math.sqrt(KEPT)
    largest = estimator.levels.torque / block.torque_scale
    usual = max(estimator.levels.squared_error, (1.0 - KEPT) * largest * largest)
    levels = estimator.levels._replace(squared_error=usual)
    controller.state = state._replace(estimator=estimator._replace(levels=levels))


def read_state(path: Path) -> str:
    """Return the text of a file with a saved state.

    Raises
    ------
    InputError
        The file cannot be read, or holds no such state.
    """
    text = read_text(path, "cannot be read")
    try:
        state_from_json(text)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    return text
