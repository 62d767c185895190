"""Suites: their files, cases, results, fingerprints; synthetic logs, recorded machines, friction laws on a record."""

import json
import math
import pickle
import pkgutil
import shutil
from functools import partial

import numpy as np
import pytest
from typer.testing import CliRunner

from adaptive_ff.errors import InputError
from adaptive_ff.simulation.tracking_errors import TrackingErrors, ratios
from benchmarks import __main__ as command
from benchmarks import fingerprint as module
from benchmarks import running, suite
from benchmarks.cases.logs import recorded
from benchmarks.cases.logs.coverage import repetition, run_driven
from benchmarks.cases.logs.drawn_logs import driven_case, make_case
from benchmarks.cases.logs.recorded import DATA, JOBS
from benchmarks.cases.other_joints import draw
from benchmarks.cases.situations import named_scenario
from benchmarks.compare import geometric_mean, moved_lines, summary_lines
from benchmarks.fingerprint import fingerprint, import_closure
from benchmarks.friction import laws, picture
from benchmarks.mutation.operators import EQUIVALENT, mutants
from benchmarks.results import Result, Row, read_result
from benchmarks.running import gathered, run_case, run_suite, tracked
from benchmarks.suite import Case, Suite, load_suite, suite_names

NAMES = suite_names()


@pytest.mark.parametrize("name", NAMES)
def test_every_suite_has_cases_that_can_be_sent_to_processes_and_keys_of_their_own(name):
    loaded = load_suite(name)
    cases = loaded.generated(quick=True)
    assert cases
    assert len({case.key for case in cases}) == len(cases)
    assert [case.key for case in pickle.loads(pickle.dumps(cases))] == [case.key for case in cases]


def test_unknown_suites_cases_and_fields_are_refused(tmp_path, monkeypatch):
    with pytest.raises(InputError, match="--only = 'none' matches no case of matrix"):
        CliRunner().invoke(command.app, ["run", "matrix", "--only", "none"], catch_exceptions=False)
    with pytest.raises(InputError, match="suite = 'none' is not known; there are"):
        load_suite("none")
    monkeypatch.setattr(suite, "SUITES", tmp_path)
    (tmp_path / "one.toml").write_text('title = "a"\ncases = []\nseeds = 3\n')
    with pytest.raises(InputError, match=r"one.toml: seeds is not known"):
        load_suite("one")


def test_rows_outside_the_contract_are_named_by_patterns():
    loaded = load_suite("situations")
    assert loaded.is_outside("lag_untold_10")
    assert not loaded.is_outside("paper_100hz")


def made_up(value, controllers):
    return {"": {"row": "odd" if value % 2 else "even"}, **{name: {"settled": value + 1.0} for name in controllers}}


def refuses(controllers):
    raise ValueError("there is none")


@pytest.fixture
def two_rows(tmp_path, monkeypatch):
    monkeypatch.setattr(running, "KEPT", tmp_path)
    cases = [Case(f"made/{value}", value, partial(made_up, value)) for value in range(4)]
    return run_suite(Suite("made", "made up", []), [*cases, Case("refused/1", 1, refuses)], ["pi", "own"], workers=1)


def test_cases_are_gathered_into_rows_and_refusals_are_named(two_rows):
    assert two_rows.rows["odd"] == Row([1, 3], {"pi": {}, "own": {"settled": [2.0, 4.0]}})
    assert two_rows.refused == {"refused/1": "there is none"}


def test_a_result_is_read_as_it_was_written(two_rows, tmp_path):
    two_rows.rows["odd"].figures["own"]["window"] = [math.inf, 0.123456]
    file = two_rows.write(tmp_path)
    again = read_result(tmp_path, "made")
    assert again.rows["odd"].figures["own"] == {"settled": [2.0, 4.0], "window": [math.inf, 0.12346]}
    assert vars(again) | {"rows": None} == vars(two_rows) | {"rows": None}
    assert json.loads(file.read_text())["suite"] == "made"
    assert read_result(tmp_path, "another") is None


def test_a_result_keeps_fewer_digits_where_it_is_large_and_is_refused_where_that_does_not_do(two_rows, tmp_path):
    two_rows.rows["odd"].figures["own"]["settled"] = [1.2345] * 18_000
    two_rows.write(tmp_path)
    assert read_result(tmp_path, "made").rows["odd"].figures["own"]["settled"][:2] == [1.23, 1.23]
    two_rows.rows["odd"].figures["own"]["settled"] = [1.2345] * 20_000
    with pytest.raises(InputError, match="bytes are not allowed"):
        two_rows.write(tmp_path)


def test_several_joints_of_a_case_count_each():
    cases = {"arm/1": Case("arm/1", 1, refuses)}
    rows, _ = gathered(cases, {"arm/1": {"": {"row": "arm"}, "own": {"settled": [2.0, 3.0]}}}, {"own": "other name"})
    assert rows["arm"].figures == {"other name": {"settled": [2.0, 3.0]}}


def result(name, **settled):
    rows = {row: Row(list(range(len(values))), {"own": {"settled": values}}) for row, values in settled.items()}
    return Result(name, "", "", 0.0, "", {}, rows)


def test_comparison_pairs_the_cases_that_both_have_by_geometric_means():
    assert geometric_mean([1.0, 4.0]) == pytest.approx(2.0)
    before, after = result("made", one=[2.0, 8.0, 1.0], two=[0.9]), result("made", one=[1.0, 4.0], two=[0.96])
    inside, outside = summary_lines(Suite("made", "", [], outside=["two"]), before, after, ["own"])
    assert inside[1:7] == ["inside", "own", "2", "4.000 2.000", "0.500", "0 0"]
    assert outside[3:7] == ["1", "0.900 0.960", "1.067", "1 0"]
    (moved,) = moved_lines(Suite("made", "", []), before, after, ["own"])
    assert moved == ["made", "inside", "own", "one", "settled", "5", "2.5", "0.50"]


def test_a_scenario_that_is_made_here_is_compared_with_pi():
    case = Case("label/3", 3, partial(tracked, "row", partial(named_scenario, "light"), 1, 3))
    found = run_case(case, ["pi", "adaptive"])
    assert found[""] == {"row": "row"}
    assert found["adaptive"]["settled"] == pytest.approx(found["pi"]["error"] / found["adaptive"]["error"])
    same = TrackingErrors(1.0, 1.0, (1.0,))
    assert set(ratios(same, same)) < set(found["adaptive"])


def test_command_runs_a_suite_and_compares_two_folders(tmp_path, monkeypatch):
    monkeypatch.setattr(running, "KEPT", tmp_path / "kept")
    words = ["run", "matrix", "--only", "slow_010", "--quick", "--workers", "1", "--controllers", "oracle"]
    done = CliRunner().invoke(command.app, [*words, "--as", "adaptive", "--out", str(tmp_path / "before")])
    assert done.exit_code == 0, done.output
    shutil.copytree(tmp_path / "before", tmp_path / "after")
    assert list(read_result(tmp_path / "before", "matrix").rows["slow_010"].figures) == ["pi", "adaptive"]
    done = CliRunner().invoke(command.app, ["compare", str(tmp_path / "before"), str(tmp_path / "after")])
    assert done.exit_code == 0
    assert "1.000" in done.output


def test_stale_suites_are_run_and_one_that_fails_does_not_end_the_others(tmp_path, monkeypatch):
    monkeypatch.setattr(running, "KEPT", tmp_path / "kept")
    monkeypatch.setattr(command, "stale_since", {"push": None, "matrix": "abc", "arms": ""}.get)
    words = ["run", "push", "matrix", "arms", "--stale", "--only", "slow_010", "--quick", "--workers", "1"]
    done = CliRunner().invoke(command.app, [*words, "--controllers", "oracle", "--out", str(tmp_path / "out")])
    assert done.exit_code == 1
    assert [file.name for file in (tmp_path / "out").iterdir()] == ["matrix.json"]
    assert done.stderr.splitlines()[-1] == "benchmarks: arms: --only = 'slow_010' matches no case of arms"


def test_data_counts_for_suites_with_a_module_beside_it_alone(tmp_path, monkeypatch):
    marks = {}
    for text in ("", "one = 1"):
        (tmp_path / "mutation").mkdir(exist_ok=True)
        (tmp_path / "mutation" / "equivalent.toml").write_text(text)
        monkeypatch.setattr(running, "SUITES", tmp_path / "suites")
        marks[text] = {name: running.suite_fingerprint(load_suite(name)) for name in ("mutation", "machines")}
    assert [name for name, mark in marks[""].items() if marks["one = 1"][name] != mark] == ["mutation"]


@pytest.mark.parametrize("seed", [2, 3, 8, 11])
def test_records_of_a_joint_share_it_but_not_their_motion(seed):
    one, other = (make_case(seed, record=record) for record in (0, 1))
    assert one.truth["inertia"] == other.truth["inertia"]
    assert one.kind == other.kind
    assert not np.array_equal(one.log.position[:100], other.log.position[:100])
    again = make_case(seed)
    assert np.array_equal(again.log.torque, one.log.torque)


def test_repetition_agrees_within_both_half_widths():
    one = {"inertia_error": [0.0], "inertia_width": [0.03]}
    near, far = ({"inertia_error": [error], "inertia_width": [0.04]} for error in (0.049, 0.051))
    assert repetition(one, near) == {"inertia_repeats": [1.0]}
    assert repetition(one, far) == {"inertia_repeats": [0.0]}


@pytest.mark.parametrize("seed", [101, 102, 103])
def test_the_recorded_torque_is_what_the_joint_needs(seed):
    """Over the log, inertia gives back what it takes: what is left of the work is done against friction and load."""
    case = driven_case(seed)
    joint, loop, _ = draw(seed)
    log = case.log
    assert case.delay == 0.5 * loop.period
    assert (log.velocity is None) != (loop.sensor == "tachometer")
    velocity = np.gradient(log.position, log.time) if log.velocity is None else log.velocity
    friction = joint.coulomb * np.abs(velocity) + joint.viscous * velocity**2
    done = float(np.mean((log.torque - joint.load) * velocity))
    assert float(np.mean(friction)) == pytest.approx(done, rel=0.25)


@pytest.mark.nightly
def test_inertia_of_joints_that_stick_for_long_is_within_its_interval():
    found = [run_driven(seed, ["identify"])["identify"] for seed in (315, 332, 364)]
    assert [one["inertia_inside"] for one in found] == [[1.0]] * 3
    for name in ("inertia", "coulomb"):
        assert np.median([abs(one[f"{name}_error"][0]) for one in found]) < 0.05, name


def test_absent_data_are_said_with_their_source(tmp_path, monkeypatch):
    monkeypatch.setattr(recorded, "DATA", tmp_path)
    for job, case in zip(JOBS.values(), recorded.joints(), strict=True):
        refused = run_case(case, ["identify"])[""]["refused"]
        assert job.table["origin"] in refused
        assert all(file in refused for file in job.table["files"])


MISSING = JOBS["KUKA KR300 axis 6"].missing()


@pytest.mark.skipif(bool(MISSING), reason=f"the recorded data lie outside the repository and are not there: {DATA}")
def test_axis_is_identified_replayed_and_put_into_a_closed_loop():
    (case,) = [case for case in recorded.joints() if case.key == "KUKA KR300 axis 6"]
    found = run_case(case, load_suite("recorded").controllers)
    assert found[""] == {"row": "KUKA KR300 axis 6"}
    assert found["closed loop"]["pi"] > 5.0
    assert 0.0 < found["identify"]["unexplained"] < found["identify"]["validation"] + 0.2 < 0.5
    first, second = found["adaptive"]["left"]
    assert first < found["none"]["left"][0]
    assert second < found["none"]["left"][1]
    assert len(found["adaptive_saved"]["left"]) == 1


BY_NAME = {law.name: law for law in laws.LAWS}


def made(name, *values, cycles=4):
    """A record of a law along a cycle with rests, with an offset of 0.1 N."""
    way = np.concatenate([np.linspace(0.0, 2e-4, 120), np.full(40, 2e-4), np.linspace(2e-4, 0.0, 120), np.zeros(40)])
    position = np.tile(way, cycles)
    velocity, period = np.diff(position) / 0.005, np.full(position.size - 1, 0.005)
    force = laws.force_along(BY_NAME[name].make(*values), velocity, period) + 0.1
    return laws.PreslidingRecord(period, position[1:], velocity, force)


@pytest.mark.parametrize(("name", "values"), [("LuGre", (2.0, 4e4)), ("elasto-plastic", (2.0, 1.3e-4))])
def test_fit_finds_the_parameters_that_a_record_was_made_with(name, values):
    fit = laws.fit_law(BY_NAME[name], made(name, *values))
    assert list(fit.values.values()) == pytest.approx([*values, 0.1], rel=1e-3)
    assert fit.tested < 1e-3


def test_law_that_is_not_the_records_leaves_an_error():
    record = made("elasto-plastic", 2.0, 1.3e-4)
    coulomb = laws.fit_coulomb(record)
    assert laws.fit_law(BY_NAME["LuGre"], record).tested > 0.01
    assert laws.fit_lagged(record).tested < coulomb.tested
    error = coulomb.force - record.force
    assert coulomb.tested == pytest.approx(np.sqrt(np.mean(error[error.size // 2 :] ** 2)), rel=1e-12)


def test_play_takes_flicker_out_and_keeps_motion():
    position = np.array([0.0, 1e-7, 0.0, 1e-7, 5e-6, 5e-6, 4.9e-6, 0.0])
    assert laws.without_flicker(position, 2e-7) == pytest.approx([0.0, 0.0, 0.0, 0.0, 4.8e-6, 4.8e-6, 4.8e-6, 2e-7])


@pytest.mark.skipif(not laws.DATA.is_file(), reason="the measured record is not beside this repository")
def test_laws_meet_the_targets_on_the_measured_record():
    record = laws.read_record()
    assert 0.2e-3 < np.ptp(record.position) < 0.3e-3
    every = record.part(slice(None, 8000))
    fits = [
        laws.fit_coulomb(every),
        *(laws.fit_law(BY_NAME[name], every) for name in ("LuGre", "rolling", "elasto-plastic")),
    ]
    shares = {fit.law: fit.tested / fits[0].tested for fit in fits}
    assert shares["LuGre"] < 0.5
    assert shares["rolling"] < 0.5
    assert shares["elasto-plastic"] < 0.25
    figure = picture.draw(every, fits)
    assert [axes.get_title().partition(":")[0] for axes in figure.axes][6:10] == [fit.law for fit in fits]


FILES = {
    "plant/__init__.py": "",
    "plant/joint.py": '"""A joint."""\ndef step(velocity):\n    """Return it."""\n    return velocity  # as it is\n',
    "controllers/__init__.pyi": "from .pi import PI as PI\n",
    "controllers/pi.py": "import plant.joint\n\nPI = plant.joint.step\n",
    "controllers/other.py": "X = 1\n",
    "adaptive_ff/run.py": "def run():\n    from controllers import PI\n\n    return PI\n",
}


@pytest.fixture
def tree(tmp_path, monkeypatch):
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.setattr(module, "ROOT", tmp_path)
    return tmp_path


def digest():
    for cached in (module._imports, module._stub, module._tree_digest):
        cached.cache_clear()
    return fingerprint(["adaptive_ff.run"])


def test_closure_goes_through_stubs_and_imports_inside_functions(tree):
    assert import_closure(["adaptive_ff.run"]) == {"adaptive_ff.run", "controllers.pi", "plant.joint"}


@pytest.mark.parametrize(
    ("name", "old", "new", "changes"),
    [
        ("plant/joint.py", "A joint.", "Another text.", False),
        ("plant/joint.py", "  # as it is", "", False),
        ("plant/joint.py", "return velocity", "return -velocity", True),
        ("controllers/other.py", "X = 1", "X = 2", False),
        ("adaptive_ff/run.py", "return PI", "return None", True),
    ],
)
def test_it_changes_with_the_code_that_runs_alone(tree, name, old, new, changes):
    before = digest()
    file = tree / name
    file.write_text(file.read_text().replace(old, new))
    assert (digest() != before) is changes


def test_further_files_count_to_the_byte(tmp_path):
    scenario = tmp_path / "one.toml"
    scenario.write_text("seed = 1\n")
    before = fingerprint(["plant"], [scenario])
    scenario.write_text("seed = 1 \n")
    assert fingerprint(["plant"], [scenario]) != before


@pytest.mark.parametrize("name", sorted({name for name, _, _ in EQUIVALENT}))
def test_every_equivalent_mutant_is_one_of_those_that_are_made(name):
    found, listed = pkgutil.resolve_name(name), {key for key in EQUIVALENT if key[0] == name}
    lines = {before for _, before, _ in listed}
    every = mutants(name, getattr(found, "fget", getattr(found, "py_func", found)))  # of a property, or a kernel
    assert listed <= {mutant.key for mutant in every if mutant.before in lines}
