"""Every script in ``examples`` runs in an empty folder, is short, and prints what it promises."""

import runpy
from pathlib import Path

import pytest
from nightly import sampled

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
