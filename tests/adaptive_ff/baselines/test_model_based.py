"""What a loop with an assumed model refuses; its tracking is tested with the controllers of a comparison."""

import math

import pytest

from adaptive_ff import TorqueModel
from adaptive_ff.baselines.model_based import ModelBased


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("inertia", -1.0),
        ("coulomb", -1.0),
        ("friction_lag", math.nan),
        ("stribeck_velocity", 0.0),
        ("offset", math.inf),
    ],
)
def test_model_that_no_joint_has_is_refused_by_name(field, value):
    good = TorqueModel(20.0, 60.0, 90.0, 80.0, 0.02, 0.05, 1.0)
    bad = good._replace(**{field: value})
    with pytest.raises(ValueError, match=rf"^model\.{field} = "):
        ModelBased(100.0, 1000.0, 0.01, bad)
    with pytest.raises(ValueError, match=rf"^changes\[0\]\.{field} = "):
        ModelBased(100.0, 1000.0, 0.01, good, [(1.0, bad)])
    with pytest.raises(TypeError, match=r"^model = None is not allowed: it must be a TorqueModel"):
        ModelBased(100.0, 1000.0, 0.01, None)
