"""Own controllers in the scenario matrix, in its tables and on the command line."""

import inspect
import json

import pytest
from command_line import refusal, run_command_line

from adaptive_ff import InputError, simulate
from adaptive_ff.report.study_pictures import column_groups
from adaptive_ff.report.tables import gains_table
from adaptive_ff.scenario.library import SCENARIOS
from adaptive_ff.studies import matrix
from adaptive_ff.studies.matrix import Job, cell_scenario, collect, run_matrix


class Mine:
    def __init__(self, proportional):
        self.gain = proportional

    def step(self, reference, velocity):
        return self.gain * (reference - velocity)


SOURCE = inspect.getsource(Mine)


@pytest.fixture
def short(monkeypatch, tmp_path):
    """One scenario of the matrix, cut to a few seconds."""
    text = (SCENARIOS / "paper_100hz.toml").read_text(encoding="utf-8")
    (tmp_path / "paper_100hz.toml").write_text(text.replace("duration = 60.0", "duration = 4.0"), encoding="utf-8")
    monkeypatch.setattr(matrix, "SCENARIOS", tmp_path)
    monkeypatch.setattr("adaptive_ff.scenario.library.SCENARIOS", tmp_path)
    (tmp_path / "mine.py").write_text(SOURCE, encoding="utf-8")
    return tmp_path


def test_own_controller_is_run_beside_the_others_and_kept_until_its_file_changes(short, monkeypatch, one_thread):
    job = Job("paper_100hz", 1, False)
    run, ran = matrix.run_job, []
    monkeypatch.setattr(matrix, "run_job", lambda own, job, names: ran.append(names) or run(own, job, names))
    own = {"mine": f"{short / 'mine.py'}:Mine"}
    results = run_matrix([job], ["pi"], short / "out", own=own, executor=one_thread)
    scenario = cell_scenario("paper_100hz", 1, False)
    alone = simulate(scenario, Mine(scenario.feedback.gains[0])).metrics
    assert results[job]["mine"]["rms_error_settled"] == alone.rms_error_settled
    run_matrix([job], ["pi"], short / "out", own=own, executor=one_thread)
    assert ran == [["pi", "mine"]]
    (short / "mine.py").write_text(SOURCE + "# changed\n", encoding="utf-8")
    run_matrix([job], ["pi"], short / "out", own=own, executor=one_thread)
    assert ran == [["pi", "mine"], ["mine"]]
    living = run_matrix([job], ["pi"], short / "out", own={"mine": Mine}, executor=one_thread)
    assert ran[2:] == [["mine"]]  # whether it is the same, nobody knows
    assert living == results


def test_table_and_picture_show_own_controllers(short):
    job = Job("paper_100hz", 1, False)
    results = run_matrix([job], ["pi", "oracle"], short / "out", own={"mine": lambda proportional: Mine(proportional)})
    table = gains_table(collect(results), "title")
    assert table.heads == ("scenario", "pi", "oracle", "mine")
    assert table.units == ("", "mrad/s", "", "")
    groups = column_groups(["pi", "coulomb_true", "canudas", "oracle", "mine", "adaptive"])
    assert groups == {"own": ["mine"], "ours": ["adaptive"], "learners": ["canudas"], "knows the truth": ["oracle"]}


def test_mistakes_are_refused(short):
    job = Job("paper_100hz", 1, False)
    with pytest.raises(InputError, match="'pi' is not allowed"):
        run_matrix([job], ["pi"], short / "out", own={"pi": Mine})
    with pytest.raises(InputError, match="has no method step"):
        run_matrix([job], ["pi"], short / "out", own={"mine": lambda: 3})


def test_command_line(short):
    place = f"{short / 'mine.py'}:Mine"
    options = ("--only", "paper_100hz", "--seeds", "1", "--controller", "oracle", "--out", short / "out")
    outcome = run_command_line("matrix", "--own", place, *options, "--json", short / "all.json")
    assert outcome.status == 0, outcome
    assert "Mine" in outcome.out
    assert "paper_100hz" in outcome.out
    rows = json.loads((short / "all.json").read_text(encoding="utf-8"))["runs"]
    assert [row["controller"] for row in rows] == ["pi", "oracle", "Mine"]
    for name in ("matrix.md", "matrix_own_loop.png", "runs.csv", "scenarios/paper_100hz-own-1.toml"):
        assert (short / "out" / name).stat().st_size > 100
    assert "'nothing' is not known; there are paper_100hz" in refusal("matrix", "--only", "nothing")
    assert "--controller: 'nothing' is not known" in refusal("matrix", "--controller", "nothing")


def test_file_in_the_place_of_the_folder_is_named(short):
    asked = ("--controller", "pi", "--seeds", "1", "--own", f"{short / 'mine.py'}:Mine")
    line = refusal("matrix", *asked, "--out", short / "mine.py")
    assert line == f"adaptive-ff: {short / 'mine.py'}/runs.jsonl: cannot be written: File exists"
