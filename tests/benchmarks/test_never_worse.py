"""The benchmark "never worse than PI": its rows, what it asks for, and its command."""

import json

import numpy as np
import pytest
from typer import Typer
from typer.testing import CliRunner

from adaptive_ff.comparison.drawn_joints import CLASSES
from adaptive_ff.comparison.matrix.cells import scenario_names
from adaptive_ff.comparison.windows import Errors, Judgement
from benchmarks.drawn_machines import (
    INERTIAS,
    PERIODS,
    RESONANCES,
    SPEEDS,
    WEIGHTS,
    draw_cascade,
    draw_elastic,
    draw_machine,
)
from benchmarks.never_worse import __main__ as command
from benchmarks.never_worse.cases import cascade_cases, drawn_cases, elastic_cases, machine_cases, named_cases
from benchmarks.never_worse.pages import PAGES, with_figures
from benchmarks.never_worse.rows import row_of
from benchmarks.never_worse.situations import (
    DATA_SHEETS,
    DRIVES_UNTOLD,
    ENCODERS,
    LIGHT_PEAKS,
    MAPS,
    RIPPLED,
    SENSOR_FAULTS,
    SITUATIONS,
    TOLD_INERTIAS,
    TOLD_NOTHING,
    asked_of,
)


def judgement(settled=2.0, window=0.5, start=0.2, after=(0.2,)):
    base = Errors(np.array([1.0, 1.0]), 1.0, 1.0, tuple(1.0 for _ in after))
    return Judgement(base, Errors(np.array([window, 0.4]), 1.0 / settled, start, after))


def test_situations_are_scenarios_of_the_matrix():
    made = {*MAPS, *LIGHT_PEAKS, *TOLD_INERTIAS, *TOLD_NOTHING, *DRIVES_UNTOLD, *SENSOR_FAULTS, *RIPPLED, *DATA_SHEETS}
    made |= ENCODERS.keys()
    assert SITUATIONS.keys() - made <= set(scenario_names())


def test_a_joint_of_data_sheet_numbers_moves_for_minutes_at_1_khz():
    (case,) = named_cases(["data_sheet"], 101, 1)
    assert (case.scenario.seed, case.scenario.duration, case.scenario.sampling.period) == (101, 240.0, 0.001)
    assert (case.scenario.joint.inertia, case.scenario.actuator.torque_limit) == (0.5, 20.0)


def test_maps_are_given_to_the_controller_over_the_planned_positions():
    (case,) = named_cases(["map_short_hats"], 101, 1)
    lowest, highest = case.scenario.adaptation.position_range
    assert (highest - lowest) / (case.scenario.adaptation.position_hats - 1) <= 0.06
    (loaded,) = named_cases(["map_no_need_load"], 101, 1)
    assert loaded.scenario.adaptation.load_friction
    assert {"map_short_period", "map_no_need_period"} <= MAPS.keys() <= SITUATIONS.keys()


@pytest.mark.parametrize(
    ("name", "figures", "missed"),
    [
        ("load_step_80", {"settled": 7.0}, []),
        ("load_step_80", {"settled": 5.9}, ["settled"]),
        ("load_step_80", {"settled": 7.0, "after": (0.6,)}, ["after"]),
        ("payload_half", {"settled": 0.99}, ["settled"]),
        ("payload_half", {"window": 1.21}, ["window"]),
        ("gravity_100", {"settled": 4.0, "window": 1.4}, []),
        ("steep_20", {"window": 9.0}, []),
        ("paper_100hz", {"start": 0.4}, ["start"]),
        ("above 20 Kp", {"window": 9.0}, []),
        ("5 to 10 Kp", {"window": 1.3}, ["window"]),
    ],
)
def test_what_is_asked_and_missed_is_named(name, figures, missed):
    assert row_of(name, [judgement(**figures)] * 3)["missed"] == missed


def test_one_bad_reference_is_not_hidden_by_the_median():
    good = judgement(start=0.2)
    row = row_of("paper_100hz", [good, good, judgement(settled=0.9, start=1.1, window=1.3)])
    assert row["missed"] == ["settled", "window", "start"]
    assert (row["settled"], row["settled_worst"]) == (2.0, pytest.approx(0.9))
    assert (row["settled_under"], row["windows_over"]) == (1, 1)


def test_cases_are_references_of_their_own_and_joints_by_class():
    seeds = [case.scenario.seed for case in named_cases(["payload_half"], 101, 3)]
    assert seeds == [101, 102, 103]
    assert {case.name for case in drawn_cases(20, 101)} <= CLASSES.keys()
    assert asked_of("slow_stribeck") == asked_of("up to 0.5 Kp")


def test_machines_are_drawn_over_decades_and_each_seed_has_its_own():
    drawn = [case.scenario for case in machine_cases(60, 101)]
    assert {scenario.sampling.period for scenario in drawn} == set(PERIODS)
    assert {scenario.joint.kind for scenario in drawn} == {"stribeck", "lugre", "elasto_plastic"}
    assert {scenario.reference.kind for scenario in drawn} == {"multisine", "triangle", "point_to_point"}
    inertias = [scenario.joint.inertia for scenario in drawn]
    assert INERTIAS[0] <= min(inertias) < 1e-3 * max(inertias) <= 1e-3 * INERTIAS[1]
    peaks = [np.max(np.abs(scenario.reference_velocity())) for scenario in drawn]
    assert SPEEDS[0] <= 1.01 * min(peaks) < 0.1 * max(peaks) <= 0.101 * SPEEDS[1]
    assert draw_machine(101, 3) == drawn[3]
    assert draw_machine(102, 3) != drawn[3]
    assert asked_of("machine, lugre") == asked_of("payload_half")


def test_cascades_are_the_same_machines_with_a_weight_behind_a_position_loop():
    cases = cascade_cases(20, 101)
    for draw, case in enumerate(cases):
        machine, cascade = draw_machine(101, draw), case.scenario
        weight = cascade.joint.gravity / machine.joint.coulomb
        assert WEIGHTS[0] <= weight <= WEIGHTS[1]
        assert cascade.actuator.torque_limit > machine.actuator.torque_limit + 2.0 * cascade.joint.gravity
        assert (cascade.position is not None, machine.position) == (True, None)
        assert cascade.adaptation.identify == "gravity"
        assert cascade.joint.model_copy(update={"gravity": 0.0, "gravity_phase": 0.0}) == machine.joint
        assert cascade.reference == machine.reference
        assert cascade.sampling == machine.sampling
    assert {case.name for case in cases} == {"cascade, stribeck", "cascade, lugre", "cascade, elasto_plastic"}
    assert draw_cascade(101, 3) == cases[3].scenario
    assert len({case.scenario.joint.gravity for case in cases}) == len(cases)


def test_gears_are_drawn_for_the_same_machines_whatever_their_friction():
    cases = elastic_cases(20, 101)
    for draw, case in enumerate(cases):
        machine, joint = draw_machine(101, draw), case.scenario.joint
        assert joint.kind == ("backlash" if draw % 2 else "elastic")
        assert (joint.inertia, joint.coulomb, joint.viscous) == pytest.approx(
            (machine.joint.inertia, machine.joint.coulomb, machine.joint.viscous)
        )
        reduced = joint.link_share * (1.0 - joint.link_share) * joint.inertia
        resonance = np.sqrt(joint.link_stiffness / reduced) / (2.0 * np.pi * machine.feedback.bandwidth)
        assert RESONANCES[0] <= resonance <= RESONANCES[1]
        assert case.scenario.reference == machine.reference
    assert {case.name for case in cases} == {"machine, elastic gear", "machine, play"}
    assert draw_elastic(101, 3) == cases[3].scenario


def test_command_prints_the_rows_and_writes_them(tmp_path, monkeypatch):
    def short(names, first, references):
        cases = named_cases(names, first, references)
        return [case._replace(scenario=case.scenario.modified(duration=6.0, change=[])) for case in cases]

    monkeypatch.setattr(command, "named_cases", short)
    app = Typer()
    app.command()(command.main)
    target = tmp_path / "rows.json"
    options = ["--scenario", "payload_half", "--references", "1", "--draws", "1", "--workers", "1"]
    result = CliRunner().invoke(app, [*options, "--controller", "pi_inertia", "--json", str(target)])
    assert result.exit_code == 0, result.output
    assert "payload_half" in result.output
    (row,) = json.loads(target.read_text())["rows"]
    assert row["settled"] == pytest.approx(1.0, rel=0.1)  # friction is nearly all of this error
    assert row["missed"] == ([] if row["settled"] >= 1.0 else ["settled"])
    result = CliRunner().invoke(app, [*options, "--controller", "pi", "--json", str(target)])
    assert "under other noise" in " ".join(result.output.split())
    (chance,) = json.loads(target.read_text())["rows"]
    assert chance["pi"] == row["pi"]
    assert 0.8 < chance["settled"] < 1.2
    assert chance["settled"] != 1.0
    few = CliRunner().invoke(app, ["--pages", "--references", "2"])
    assert few.exit_code == 2
    refused = CliRunner().invoke(app, ["--scenario", "nothing"])
    assert refused.exit_code == 2
    assert "'nothing' is not known" in " ".join(refused.output.replace("│", " ").split())


def figures_of(name, place):
    """A row whose figures tell its place."""
    return {**row_of(name, [judgement(settled=1.0 + place / 8.0)]), "situation": name}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: f"{page.path.parent.name}/{page.path.name}")
def test_figures_of_a_run_are_written_into_the_tables_and_nothing_else(page):
    rows = [figures_of(name, place) for place, name in enumerate(SITUATIONS)]
    old = page.path.read_text(encoding="utf-8")
    new = with_figures(old, page, rows)
    assert with_figures(new, page, rows) == new
    changed = [pair for pair in zip(old.splitlines(), new.splitlines(), strict=True) if pair[0] != pair[1]]
    assert changed
    settled = {row["situation"]: row["settled"] for row in rows}
    for before, after in changed:
        first = after.split("|")[1]
        assert before.split("|")[1] == first
        assert before.count("|") == after.count("|")
        assert float(after.split("|")[3].split()[0]) == pytest.approx(settled[page.name_of(first.strip())], abs=0.006)


def test_every_situation_has_a_row_on_a_page():
    listed = set()
    for page in PAGES:
        table = page.path.read_text(encoding="utf-8").split("<!-- never_worse -->")[1].split("<!-- /never_worse -->")[0]
        listed |= {page.name_of(row.split("|")[1].strip()) for row in table.strip().splitlines()[2:]}
    assert listed == SITUATIONS.keys()
