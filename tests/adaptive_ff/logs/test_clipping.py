"""A torque that is cut off at its ends is said to be; one that a machine really gives is not."""

import numpy as np
import pytest
from synthetic_logs import make_log

from adaptive_ff.identify.identification import identify_log
from adaptive_ff.logs.cleaning import at_limit
from adaptive_ff.logs.log import Log


def clipped_torque(torque):
    return at_limit(Log("log", np.arange(torque.size), torque, torque))[1]


TORQUE = make_log(duration=20.0, noise=0.05).torque
PHASE = np.linspace(0.0, 60.0, 10000)


@pytest.mark.parametrize(("limits", "shown"), [((-8.0, 8.0), "-8 or 8"), ((-np.inf, 8.0), "8"), ((-8.0, np.inf), "-8")])
def test_torque_that_is_cut_off_is_said_to_be(limits, shown):
    clipped = np.clip(TORQUE, *limits)
    share = 100.0 * np.mean(clipped != TORQUE)
    (said,) = clipped_torque(clipped)
    cut = f"the torque is exactly {shown} in {share:.0f} % of the rows: if what records it cuts it off"
    assert said.startswith(cut)


def test_identification_says_it():
    log = make_log(noise=0.05, period=0.004)
    np.clip(log.torque, -8.0, 8.0, out=log.torque)
    assert any(caution.startswith("the torque is exactly -8 or 8") for caution in identify_log(log).cautions)


@pytest.mark.parametrize(
    "torque",
    [
        TORQUE,
        np.clip(TORQUE, -0.98 * np.max(np.abs(TORQUE)), None),  # a few rows only
        np.round(3.0 * np.sin(PHASE) + 2.0 * np.sin(3.3 * PHASE)),  # of few digits
        np.where(np.sin(PHASE) > 0.0, 5.0, -5.0),  # switched
        np.repeat(np.random.default_rng(5).integers(-3, 4, 100).astype(float), 100),  # in steps
        np.maximum(TORQUE, 0.0),  # off where it would be negative
        np.repeat(TORQUE[::5], 5),  # held
        np.full(100, np.nan),
        np.full(100, 2.0),
    ],
    ids=["sound", "few rows", "digits", "switched", "steps", "off", "held", "nothing", "constant"],
)
def test_other_torques_are_not(torque):
    assert clipped_torque(torque) == []
