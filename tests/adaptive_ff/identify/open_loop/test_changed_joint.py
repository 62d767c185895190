"""What of an open-loop error one parameter that has changed between the logs explains."""

import numpy as np
import pytest

from adaptive_ff.identify.open_loop.changed_joint import (
    changed,
    fitted_changes,
    root_mean_square,
    whole_error,
    words_of_change,
)
from adaptive_ff.identify.open_loop.simulation import OpenLoopModel, Record

PERIOD = 0.002
MODEL = OpenLoopModel(0.5, 1.0, 2.0, 0.1, -1.0, 1.0, np.array([0.3]))


def record_of(model):
    """A log of 10 s that a model makes of three sines."""
    time = PERIOD * np.arange(5000)
    torque = 4.0 * np.sum([np.sin(2.0 * np.pi * f * time + f) for f in (0.31, 0.47, 0.83)], axis=0)
    position = model.errors(Record(np.zeros(5000), np.zeros(5000), torque, PERIOD), np.array([0]), 5000)[0]
    return Record(position, np.zeros(5000), torque, PERIOD)  # it starts at rest


@pytest.mark.parametrize(
    ("parameter", "share", "change"),
    [("viscous", 0.05, 0.05), ("coulomb", -0.1, -0.1), ("inertia", 0.1, 0.1), ("offset", 0.08, 0.08)],
)
def test_a_joint_that_has_changed_is_found(parameter, share, change):
    found, *others = fitted_changes(MODEL, record_of(changed(MODEL, parameter, share)))
    assert all(other.rms > found.rms for other in others)
    assert found.parameter == parameter
    assert found.change == pytest.approx(change, abs=2e-3)


def test_what_no_single_number_explains_is_not_explained():
    """Viscous friction that has risen, and Coulomb friction that has fallen for it."""
    other = record_of(MODEL._replace(coulomb=0.6, viscous=3.0, force=np.array([0.6])))
    rms = root_mean_square(whole_error(MODEL, other))
    assert rms > 0.01
    assert words_of_change(fitted_changes(MODEL, other)[0], rms, linear=False) == ""


def test_the_sentence_names_parameter_size_and_what_is_left():
    record = record_of(changed(MODEL, "viscous", 0.05))
    rms = root_mean_square(whole_error(MODEL, record))
    said = words_of_change(fitted_changes(MODEL, record)[0], rms, linear=False)
    assert said.startswith("With viscous friction 5.0% larger")
    assert f"instead of {1e3 * rms:.3g} mrad" in said
    offset = words_of_change(fitted_changes(MODEL, record_of(changed(MODEL, "offset", -0.08)))[0], 0.01, linear=True)
    assert offset.startswith("With an offset of -0.08 N beside its own")
