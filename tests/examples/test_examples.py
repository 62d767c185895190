"""Every script in ``examples`` runs in an empty folder, is short, and prints what it promises.

The controller in one file is checked, compiled, saved, compared and exported like those of the package.
"""

import runpy
from pathlib import Path

import numpy as np
import pytest
from closed_loops import sampled

from adaptive_ff import compare, export_controller, load_scenario, simulate
from examples.sliding_mode import SlidingMode

EXAMPLES = Path(__file__).resolve().parent.parent.parent / "examples"

PRINTED = {
    "first_comparison": "estimates at the end:",
    "design_a_loop": "friction slope",
    "choose_a_bandwidth": "largest difference, rad/s: 0.0",
    "in_your_own_loop": "36 to 40 s: rms error",
    "arm_in_mujoco": "elbow: rms error",
    "read_update_write": "right: rms error",
    "position_loop": "rms position error: PI",
    "identify_a_log": "verdict: usable",
    "own_controller": "'mine':",
    "sliding_mode": "sliding",
    "guard_tracking": "is of another scenario: feedback.bandwidth is 10.0 there and 8.0 here",
}
"""Something that each prints."""

QUICK = {*PRINTED} - {"arm_in_mujoco", "choose_a_bandwidth"}
"""What runs in a few seconds."""


def test_every_script_is_run():
    assert {path.stem for path in EXAMPLES.glob("*.py")} == set(PRINTED)


@pytest.mark.filterwarnings("ignore")  # what plotting a Bode diagram warns of is not ours
@pytest.mark.parametrize("name", sampled(PRINTED, QUICK))
def test_script_runs_and_is_short(name, tmp_path, monkeypatch, capsys):
    path = EXAMPLES / f"{name}.py"
    assert len(path.read_text(encoding="utf-8").splitlines()) < 60
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(path), run_name="__main__")
    assert PRINTED[name] in capsys.readouterr().out


SCENARIO = load_scenario().modified(duration=20.0, controllers=["pi"])
ARGUMENTS = {"proportional": 1256.0, "integral": 15800.0, "period": 0.01, "inertia": 20.0}


def test_sliding_mode_is_compared_by_its_file_alone():
    found = compare(SCENARIO, own={"sliding": f"{EXAMPLES / 'sliding_mode.py'}:SlidingMode"})
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


def test_state_of_sliding_mode_goes_on_where_it_was_saved():
    first, second = SlidingMode(**ARGUMENTS), SlidingMode(**ARGUMENTS)
    for _ in range(5):
        first.step(0.1, 0.08, next_reference=0.11)
    second.state_from_json(first.state_to_json())
    assert second.step(0.12, 0.1) == first.step(0.12, 0.1)


def test_help_names_every_argument_and_the_source_of_a_program_in_c_is_written(tmp_path):
    assert all(f"\n{name} : float" in SlidingMode.__doc__ for name in (*ARGUMENTS, "level", "layer", "delay"))
    export_controller(SlidingMode(**ARGUMENTS), tmp_path / "sliding")
    assert "step_sliding_mode" in (tmp_path / "sliding" / "controller.c").read_text()
