"""A controller in one file is checked, compiled, saved, compared and exported like those of the package."""

import inspect
from pathlib import Path

import numpy as np
import pytest

from adaptive_ff import compare, export_controller, load_scenario, simulate
from examples.sliding_mode import SlidingMode

PLACE = Path(inspect.getfile(SlidingMode))
SCENARIO = load_scenario().modified(duration=20.0, controllers=["pi"])
ARGUMENTS = {"proportional": 1256.0, "integral": 15800.0, "period": 0.01, "inertia": 20.0}


def test_it_is_compared_by_its_file_alone():
    found = compare(SCENARIO, own={"sliding": f"{PLACE}:SlidingMode"})
    assert found.improvement["sliding"] > 1.5


def test_compiled_and_plain_series_agree_to_the_bit():
    gains = dict(zip(("proportional", "integral"), SCENARIO.feedback.gains, strict=True))
    made = {**ARGUMENTS, **gains}
    compiled, plain = (simulate(SCENARIO, one) for one in (SlidingMode(**made), SlidingMode(**made).run_uncompiled()))
    assert np.array_equal(compiled.torque, plain.torque)
    assert np.ptp(compiled.feedforward) > 50.0


@pytest.mark.parametrize("name", ["proportional", "inertia", "level", "layer", "period"])
@pytest.mark.parametrize(("wrong", "kind"), [(-1.0, ValueError), ("5", TypeError)])
def test_arguments_are_refused_by_name(name, wrong, kind):
    with pytest.raises(kind, match=rf"^{name} = '?{wrong}'? is not allowed: it must be "):
        SlidingMode(**{**ARGUMENTS, name: wrong})


def test_state_goes_on_where_it_was_saved():
    first, second = SlidingMode(**ARGUMENTS), SlidingMode(**ARGUMENTS)
    for _ in range(5):
        first.step(0.1, 0.08, next_reference=0.11)
    second.state_from_json(first.state_to_json())
    assert second.step(0.12, 0.1) == first.step(0.12, 0.1)


def test_help_names_every_argument_and_the_source_of_a_program_in_c_is_written(tmp_path):
    assert all(f"\n{name} : float" in SlidingMode.__doc__ for name in (*ARGUMENTS, "level", "layer", "delay"))
    export_controller(SlidingMode(**ARGUMENTS), tmp_path / "sliding")
    assert "step_sliding_mode" in (tmp_path / "sliding" / "controller.c").read_text()
