"""The engine of studies: what runs, what is kept, and where; and the matrix of scenarios."""

import inspect
import json
import math
import os
import sys
import threading

import numpy as np
import pytest
from command_line import refusal, run_command_line

from adaptive_ff import InputError, load_scenario, simulate
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.report.study_pictures import column_groups
from adaptive_ff.report.tables import gains_table, ranking_table
from adaptive_ff.scenario.library import GROUPS, SCENARIOS, grouped, scenario_names
from adaptive_ff.scenario.loop import fall_over_gain
from adaptive_ff.simulation.metrics import rms
from adaptive_ff.studies import matrix, study
from adaptive_ff.studies.study import Store, run_study
from adaptive_ff.studies.tracking import run_errors
from controllers import fastest_bandwidth

ASKED = [name for names in GROUPS.values() for name in names]
JOB = matrix.Job("paper_100hz", 1, False)


class Mine:
    def __init__(self, proportional):
        self.gain = proportional

    def step(self, reference, velocity):
        return self.gain * (reference - velocity)


@pytest.fixture
def short(monkeypatch, tmp_path):
    """Two scenarios of the matrix, cut to a few seconds."""
    for name in ("paper_100hz", "friction_drops"):
        text = (SCENARIOS / f"{name}.toml").read_text(encoding="utf-8")
        text = text.replace("duration = 60.0", "duration = 8.0").replace("duration = 90.0", "duration = 24.0")
        (tmp_path / f"{name}.toml").write_text(text.replace("time = 45.0", "time = 10.0"), encoding="utf-8")
    monkeypatch.setattr(matrix, "SCENARIOS", tmp_path)
    monkeypatch.setattr("adaptive_ff.scenario.library.SCENARIOS", tmp_path)
    return ["friction_drops", "paper_100hz"]


@pytest.fixture
def mine(tmp_path):
    """A file with an own controller."""
    (tmp_path / "mine.py").write_text(inspect.getsource(Mine), encoding="utf-8")
    return tmp_path / "mine.py"


def test_every_scenario_is_in_one_group_and_valid():
    assert scenario_names() == sorted(ASKED)
    assert len(ASKED) == 61
    for name in ASKED:
        scenario = load_scenario(SCENARIOS / f"{name}.toml")
        assert scenario.reference_velocity().size == scenario.times().size
        assert scenario.velocity_noise > 0.0 or name == "ideal_1khz"


def test_scenarios_differ_in_what_their_names_say():
    load, built_in = load_scenario, load_scenario()
    same, assumed = load("paper_100hz").model_dump(), built_in.model_dump()
    apart = {"fixed": None, "reference": None}  # the peak of the reference is a default there
    assert {**same, **apart} == {**assumed, **apart}
    motions = [one.reference_velocity() for one in (load("paper_100hz"), built_in)]
    np.testing.assert_allclose(*motions, rtol=1e-12, atol=1e-15)
    assert [load(f"friction_{way}").change[0].friction_scale for way in ("drops", "rises")] == [0.6, 1.5]
    assumed = [load(f"vs_{way}").adaptation.stribeck_velocity for way in ("half", "double")]
    assert assumed == [0.5 * built_in.joint.stribeck_velocity, 2.0 * built_in.joint.stribeck_velocity]
    assert [load(f"inertia_{way}").feedback.inertia for way in ("low", "high")] == [16.0, 24.0]
    assert load("delay").delay == 1.0
    assert np.ptp(load("standstill").reference.pause) == 60.0
    assert np.max(np.abs(load("slow_stribeck").reference_velocity())) == pytest.approx(0.05)
    assert [load(f"load_step_{load_}").change[0].load for load_ in (30, 80)] == [30.0, 80.0]
    assert [load(f"payload_{way}").change[0].inertia_scale for way in ("half", "double")] == [0.5, 2.0]
    assert [load(f"gravity_{torque}").joint.gravity for torque in (40, 100)] == [40.0, 100.0]
    assert [load(f"lugre_{stiffness}").joint.stiffness for stiffness in ("1e3", "3e3", "1e4")] == [1e3, 3e3, 1e4]
    slow = [load(f"slow_{share}") for share in ("010", "025", "050")]
    assert [s.reference.peak / s.joint.stribeck_velocity for s in slow] == pytest.approx([0.1, 0.25, 0.5])
    steep = [fall_over_gain(load(f"steep_{times}")) for times in (2, 5, 10, 20)]
    assert steep == pytest.approx([2.0, 5.0, 10.0, 20.0], rel=1e-3)
    delays = [(load(name).delay, load(name).assumed_delay) for name in ("delay_unknown", "delay_absent", "delay")]
    assert delays == [(1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
    assert [load(f"torque_constant_{way}").actuator.gain for way in ("low", "high")] == [0.9, 1.1]
    wrong = [load(f"high_stiction{way}") for way in ("_vs_quarter", "", "_vs_fourfold")]
    assert [s.adaptation.stribeck_velocity / s.joint.stribeck_velocity for s in wrong] == [0.25, 1.0, 4.0]
    assert {s.joint.stiction / s.joint.coulomb for s in wrong} == {3.0}


def test_saturation_scenario_saturates_and_the_others_hardly_do():
    for name, most in (("saturation", 1.0), ("paper_100hz", 1e-3)):
        run = simulate(matrix.cell_scenario(name, 101, False), "pi")
        limited = float(np.mean(np.abs(run.torque) >= run.scenario.actuator.torque_limit))
        assert (0.01 < limited <= most) if name == "saturation" else limited <= most


def test_figures_of_a_run_against_their_definitions():
    scenario = load_scenario().modified(duration=30.0, change=[{"time": 12.0, "friction_scale": 0.6}])
    base, run = simulate(scenario, "pi"), simulate(scenario, "oracle")
    figures = matrix.further_figures(run, run_errors(base))
    error, time = run.reference - run.velocity, run.solver_time
    assert figures["rms_error_recovered"] == pytest.approx(rms(error[time >= 22.0]), rel=1e-12)
    assert figures["rms_error_second"] == pytest.approx(rms(error[(time > 5.0) & (time <= 10.0)]), rel=1e-12)
    own, theirs = (
        np.array([rms((one.reference - one.velocity)[a : a + 5000]) for a in range(0, 30_000, 5000)])
        for one in (run, base)
    )
    worst = np.max(own / np.maximum(theirs, 0.15 * np.median(theirs)))
    assert figures["worst_window"] == pytest.approx(worst, rel=1e-9)
    assert figures["standstill"] is None


def test_fastest_loop_is_bounded_by_the_margin_or_by_the_noise():
    quiet = load_scenario().modified(sensor={"velocity_noise": 0.0})
    assert matrix.with_fastest_loop(quiet).feedback.bandwidth == pytest.approx(fastest_bandwidth(0.01))
    loud = load_scenario().modified(sensor={"velocity_noise": 0.05})
    gain, _ = matrix.with_fastest_loop(loud).feedback.gains
    assert gain * 0.05 == pytest.approx(0.1 * 400.0)


def test_results_are_kept_and_run_again_only_where_something_changed(short, tmp_path, monkeypatch, one_thread):
    jobs = [matrix.Job(name, seed, False) for name in short for seed in (1, 2)]
    run, ran = matrix.run_job, []
    monkeypatch.setattr(matrix, "run_job", lambda own, job, names: ran.append(job) or run(own, job, names))
    shares = []
    first = matrix.run_matrix(jobs[:2], ["pi", "oracle"], tmp_path / "out", executor=one_thread, progress=shares.append)
    assert shares[-1] == 1.0
    assert ran == jobs[:2]
    again = matrix.run_matrix(jobs, ["pi", "oracle"], tmp_path / "out", executor=one_thread)
    assert ran == jobs  # the first two only once
    assert again[jobs[0]] == first[jobs[0]]
    scenario = tmp_path / f"{short[0]}.toml"
    scenario.write_text(scenario.read_text(encoding="utf-8") + "# changed\n", encoding="utf-8")
    matrix.run_matrix(jobs, ["pi"], tmp_path / "out", executor=one_thread)
    assert ran[4:] == jobs[:2]


def test_controller_that_fails_has_no_figures(short, monkeypatch):
    def fail(scenario):
        raise ValueError("no")

    monkeypatch.setitem(CONTROLLERS, "failing", fail)
    found = matrix.run_job({}, JOB, ["pi", "failing"])
    assert found["failing"] == {}
    assert set(matrix.collect({JOB: found})["paper_100hz"]) == {"pi"}


def test_own_controller_is_run_beside_the_others_and_kept_until_its_file_changes(
    short, mine, tmp_path, monkeypatch, one_thread
):
    run, ran = matrix.run_job, []
    monkeypatch.setattr(matrix, "run_job", lambda own, job, names: ran.append(names) or run(own, job, names))

    def run_own(controller):
        return matrix.run_matrix([JOB], ["pi"], tmp_path / "out", own={"mine": controller}, executor=one_thread)

    results = run_own(f"{mine}:Mine")
    scenario = matrix.cell_scenario(*JOB)
    alone = simulate(scenario, Mine(scenario.feedback.gains[0])).metrics
    assert results[JOB]["mine"]["rms_error_settled"] == alone.rms_error_settled
    run_own(f"{mine}:Mine")
    assert ran == [["pi", "mine"]]
    mine.write_text(mine.read_text(encoding="utf-8") + "# changed\n", encoding="utf-8")
    run_own(f"{mine}:Mine")
    assert ran == [["pi", "mine"], ["mine"]]
    living = run_own(Mine)
    assert ran[2:] == [["mine"]]  # whether it is the same, nobody knows
    assert living == results


def test_mistakes_in_own_controllers_are_refused(short, tmp_path):
    with pytest.raises(InputError, match="'pi' is not allowed"):
        matrix.run_matrix([JOB], ["pi"], tmp_path / "out", own={"pi": Mine})
    with pytest.raises(InputError, match="has no method step"):
        matrix.run_matrix([JOB], ["pi"], tmp_path / "out", own={"mine": lambda: 3})


def made_up(**errors):
    """Results of one scenario: settled errors of two seeds by controller, in mrad/s."""
    return {
        matrix.Job("made_up", seed, False): {
            name: {"rms_error_settled": 1e-3 * pair[seed]} for name, pair in errors.items()
        }
        for seed in (0, 1)
    }


def test_ranking_has_geometric_means_the_best_first_and_a_failure_last():
    errors = {"pi": 8.0, "oracle": 1.0}
    found = {
        matrix.Job(name, 1, False): {one: {"rms_error_settled": error} for one, error in {**errors, **further}.items()}
        for name, further in (("servo", {"adaptive": 4.0}), ("delay", {"adaptive": 1.0, "repetitive": 8.0}))
    }
    ranked = ranking_table(matrix.collect(found), "")
    assert ranked.heads == ("controller", "all (2)", "Where the model holds (1)", "At the limits of the loop (1)")
    assert ranked.rows == [
        ("oracle", "8.00", "8.00", "8.00"),
        ("adaptive", "4.00", "2.00", "8.00"),
        ("repetitive", "failed", "failed", "1.00"),
    ]


def test_verdict_names_the_best_that_does_not_know_the_truth_and_where_it_is_below_pi():
    lines = {"oracle": (1, 1), "oracle_tuned": (1, 1), "noise_floor": (0.5, 0.5), "coulomb_true": (1, 1)}
    said = matrix.verdict(matrix.collect(made_up(pi=(8, 8), adaptive=(2, 4), good=(2, 2), bad=(9, 9), **lines)))
    assert (said["best"], said["over_pi"], said["worst"], said["below_pi"]) == ("good", 4.0, "made_up", [])
    said = matrix.verdict(matrix.collect(made_up(pi=(8, 8), oracle=(1, 1), bad=(9, 9))))
    assert (said["best"], said["below_pi"]) == ("pi", [])


def test_tables_follow_the_groups():
    assert grouped(["made_up", "delay", "servo"]) == {
        "Where the model holds": ["servo"],
        "At the limits of the loop": ["delay"],
        "Further scenarios": ["made_up"],
    }
    found = {matrix.Job(name, 1, False): {"pi": {"rms_error_settled": 1.0}} for name in ("delay", "servo")}
    text = gains_table(matrix.collect(found), "").markdown()
    first, servo, second = map(text.index, ("**Where the model holds**", "| servo |", "**At the limits of the loop**"))
    assert first < servo < second


def test_table_and_picture_show_own_controllers(short, tmp_path):
    own = {"mine": lambda proportional: Mine(proportional)}
    table = gains_table(matrix.collect(matrix.run_matrix([JOB], ["pi", "oracle"], tmp_path / "out", own=own)), "title")
    assert table.heads == ("scenario", "pi", "oracle", "mine")
    assert table.units == ("", "mrad/s", "", "")
    groups = column_groups(["pi", "coulomb_true", "canudas", "oracle", "mine", "adaptive"])
    assert groups == {"own": ["mine"], "ours": ["adaptive"], "learners": ["canudas"], "knows the truth": ["oracle"]}


@pytest.mark.parametrize(
    ("option", "own", "loops"), [("--fastest", [], ["own", "fastest"]), ("--own", ["Mine"], ["own"])]
)
def test_matrix_command_writes_tables_pictures_and_runs(short, mine, tmp_path, option, own, loops):
    out = tmp_path / "out"
    words = ["matrix", "--only", "paper_100hz", "--seeds", "1", "--controller", "oracle", "--controller", "adaptive"]
    words += [option, *(f"{mine}:{name}" for name in own), "--out", out, "--json", tmp_path / "all.json"]
    outcome = run_command_line(*words)
    assert outcome.status == 0, outcome
    assert all(name in outcome.out for name in ("paper_100hz", *own))
    rows = json.loads((tmp_path / "all.json").read_text(encoding="utf-8"))["runs"]
    names = ["pi", "oracle", "adaptive", *own]
    expected = [(name, loop == "fastest") for loop in loops for name in names]
    assert [(row["controller"], row["fastest"]) for row in rows] == expected
    assert all(math.isfinite(row["rms_error_settled"]) for row in rows)
    assert "| paper_100hz |" in (out / "matrix.md").read_text(encoding="utf-8")
    for name in (*(f"matrix_{loop}_loop.png" for loop in loops), "runs.csv"):
        assert (out / name).stat().st_size > 500
    reproduced = load_scenario(out / "scenarios" / "paper_100hz-own-1.toml")
    adaptive = rows[names.index("adaptive")]
    assert simulate(reproduced, "adaptive").metrics.rms_error_settled == adaptive["rms_error_settled"]


def test_matrix_command_refuses_names_and_places_that_it_cannot_use(short, mine):
    assert "'nothing' is not known; there are friction_drops, paper_100hz" in refusal("matrix", "--only", "nothing")
    assert "--controller: 'nothing' is not known" in refusal("matrix", "--controller", "nothing")
    line = refusal("matrix", "--controller", "pi", "--seeds", "1", "--out", mine)
    assert line == f"adaptive-ff: {mine}/runs.jsonl: cannot be written: File exists"


@pytest.mark.filterwarnings("ignore")  # what the cluster's own modules warn of is not ours
def test_runs_go_to_a_dask_cluster_by_its_executor(short, tmp_path, one_thread):
    distributed = pytest.importorskip("distributed")
    jobs = [matrix.Job(name, 1, False) for name in short]
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=False, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        found = matrix.run_matrix(jobs, ["pi", "oracle"], tmp_path / "cluster", executor=client.get_executor())
    assert found == matrix.run_matrix(jobs, ["pi", "oracle"], tmp_path / "here", executor=one_thread)


CASES = {f"case {number}": number for number in range(4)}


class Counting:
    """Runs a case as a sum of its number and the length of a name, and notes what it was asked for."""

    def __init__(self):
        self.calls = []

    def __call__(self, case, names):
        self.calls.append((case, tuple(names)))
        return {"": case % 2, **{name: case + len(name) for name in names}}


def test_what_is_missing_of_every_controller_on_every_case_is_run_and_what_is_kept_is_not(tmp_path):
    file, first, second = tmp_path / "kept" / "runs.jsonl", Counting(), Counting()
    run_study(first, dict(list(CASES.items())[:2]), ["pi"], store=Store(file, "now"), workers=1)
    found = run_study(second, CASES, ["pi", "adaptive"], store=Store(file, "now"), workers=1)
    assert second.calls[:2] == [(0, ("adaptive",)), (1, ("adaptive",))]
    assert second.calls[2] == (2, ("pi", "adaptive"))
    assert list(found) == list(CASES)
    assert found["case 1"] == {"": 1, "pi": 3, "adaptive": 9}
    assert found["case 3"] == {"": 1, "pi": 5, "adaptive": 11}
    third = Counting()
    assert run_study(third, CASES, ["pi", "adaptive"], store=Store(file, "now"), workers=1) == found
    assert third.calls == []


def test_results_of_other_code_and_lines_that_were_cut_short_do_not_count(tmp_path):
    file, again = tmp_path / "runs.jsonl", Counting()
    run_study(Counting(), CASES, ["pi"], store=Store(file, "before"), workers=1)
    file.write_text(file.read_text() + '["case 0","pi","now",')
    run_study(again, CASES, ["pi"], store=Store(file, "now"), workers=1)
    assert len(again.calls) == 4


def test_a_controller_without_a_mark_is_not_kept_and_one_with_another_mark_runs_again(tmp_path):
    file = tmp_path / "runs.jsonl"
    marks = {"object": None, "own": "1"}
    run_study(Counting(), CASES, ["pi", "object", "own"], store=Store(file, "now", marks), workers=1)
    again = Counting()
    run_study(again, CASES, ["pi", "object", "own"], store=Store(file, "now", {**marks, "own": "2"}), workers=1)
    assert {names for _, names in again.calls} == {("object", "own")}


def test_results_are_written_as_they_come(tmp_path):
    file = tmp_path / "runs.jsonl"

    def interrupted(case, names):
        if case == 2:
            raise KeyboardInterrupt
        return {"": 0, "pi": case}

    with pytest.raises(KeyboardInterrupt):
        run_study(interrupted, CASES, ["pi"], store=Store(file, "now"), workers=1)
    assert Store(file, "now").read("case 1", ["pi"]) == {"": 0, "pi": 1}


def test_all_but_the_first_go_to_the_executor_and_progress_reaches_one(one_thread):
    here, seen, shares = threading.get_ident(), {}, []

    def run(case, names):
        seen[case] = threading.get_ident()
        return {"": 0, **dict.fromkeys(names, case)}

    run_study(run, CASES, ["pi"], executor=one_thread, progress=shares.append)
    assert seen[0] == here
    assert here not in {seen[case] for case in (1, 2, 3)}
    assert shares == [0.25, 0.5, 0.75, 1.0]


def test_a_file_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        run_study(Counting(), CASES, ["pi"], store=Store(tmp_path / "taken" / "runs.jsonl", "now"), workers=1)


def process(case, names):
    return {"": os.getpid(), **dict.fromkeys(names, 0)}


@pytest.mark.parametrize("compiled", [True, False])
def test_two_workers_of_what_is_not_compiled_are_processes_that_run_all_but_the_first(compiled, monkeypatch):
    monkeypatch.setattr(study, "compiles", lambda: compiled)
    found = run_study(process, CASES, ["pi"], workers=2, threads=not compiled)
    assert [one[""] == os.getpid() for one in found.values()] == [True, False, False, False]


def test_workers_of_what_is_compiled_are_threads_that_take_short_turns():
    def thread(case, names):
        return {"": (threading.get_ident(), sys.getswitchinterval()), **dict.fromkeys(names, 0)}

    before = sys.getswitchinterval()
    found = run_study(thread, CASES, ["pi"], workers=2, threads=True)
    (here, first), *others = (one[""] for one in found.values())
    assert (here, first) == (threading.get_ident(), before)
    assert max(turn for _, turn in others) == pytest.approx(1e-5)
    assert here not in {ident for ident, _ in others}
    assert sys.getswitchinterval() == before
