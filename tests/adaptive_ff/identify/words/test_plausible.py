"""Logs that are refused for what they give."""

from types import SimpleNamespace

import numpy as np
import pytest

from adaptive_ff import InputError
from adaptive_ff.identify.units import ROTARY
from adaptive_ff.identify.words.cautions import check_plausible


@pytest.mark.parametrize(("error", "shown"), [(0.95, "5 %"), (1.2, "0 %")])
def test_torque_that_the_motion_does_not_explain_is_said_to_be_explained_by_no_less_than_nothing(error, shown):
    values = {"inertia": -1.0, "coulomb": -1.0, "viscous": -1.0}
    found = SimpleNamespace(
        name="log",
        rows=[SimpleNamespace(velocity=np.array([-1.0, 2.0]), slides=np.array([True, True]))],
        selection=SimpleNamespace(chosen=SimpleNamespace(values=values)),
        parameters={name: SimpleNamespace(estimate=SimpleNamespace(upper=-0.5)) for name in values},
        units=ROTARY,
        fit=SimpleNamespace(relative_error=error),
    )
    with pytest.raises(InputError, match=f"log: the motion explains {shown} of the torque"):
        check_plausible(found, SimpleNamespace())
