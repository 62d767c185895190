"""Scenarios that are derived, cautioned against, or cannot be read."""

import pytest
from scenario_files import REMOVED, built_in, changed, refused, short, to_toml, write_scenario

from adaptive_ff import InputError, load_scenario, parse_scenario
from adaptive_ff.scenario.reference import Multisine, Recorded


def test_modified_merges_into_a_table_and_leaves_the_original_alone():
    scenario = load_scenario()
    modified = scenario.modified(seed=2, joint={"viscous": 70.0}, change=[{"time": 30.0, "friction_scale": 0.6}])
    assert scenario == load_scenario()
    assert modified.model_dump(exclude_unset=True) == {
        **built_in(),
        "seed": 2,
        "joint": {**built_in()["joint"], "viscous": 70.0},
        "change": [{"time": 30.0, "friction_scale": 0.6}],
    }
    assert modified.modified(change=[]).change == []


def test_modified_replaces_a_reference_of_another_kind_and_merges_into_one_of_the_same(tmp_path):
    path = tmp_path / "motion.csv"
    path.write_text("time,velocity\n" + "".join(f"{t},0.1\n" for t in range(61)), encoding="utf-8")
    scenario = load_scenario().modified(reference={"kind": "csv", "path": str(path)})
    assert scenario.reference == Recorded(kind="csv", path=str(path))
    assert load_scenario().modified(reference={"kind": "multisine", "peak": 0.1}).reference.fade_in == 2.0
    assert scenario.modified(reference={"kind": "multisine", "fade_in": 1.0}).reference == Multisine(fade_in=1.0)


def test_modified_merges_into_a_table_that_was_left_out():
    content = changed(built_in(), "reference", REMOVED)
    modified = parse_scenario(content, "here").modified(reference={"peak": 0.1}, fixed={"inertia": 1.0})
    assert modified.reference == Multisine(peak=0.1)
    without = parse_scenario(changed(content, "fixed", REMOVED), "here")
    assert without.modified(fixed={"inertia": 1.0}).fixed.coulomb == 0


def test_modified_checks_like_a_file():
    with pytest.raises(InputError, match=r"^scenario: joint\.inertia = -1\.0 is not allowed: it must be positive$"):
        load_scenario().modified(joint={"inertia": -1.0})
    with pytest.raises(InputError, match=r"^scenario: load = 1 is not known; allowed there: duration, seed"):
        load_scenario().modified(load=1)


def test_result_of_a_scenario_as_json_is_a_scenario():
    scenario = load_scenario().modified(change=[{"time": 30.0, "friction_scale": 0.6}])
    assert parse_scenario(scenario.model_dump(mode="json", exclude_none=True), "result") == scenario


def test_torque_limit_below_stiction_is_cautioned_against():
    assert load_scenario().modified(actuator={"torque_limit": 90.0}).cautions() == []
    assert load_scenario().modified(actuator={"torque_limit": 80.0}).cautions() == [
        "actuator.torque_limit = 80 N m is below joint.stiction = 90 N m: tracking is impossible, the joint cannot "
        "break away from rest"
    ]


def test_friction_that_falls_more_steeply_than_the_gain_is_cautioned_against():
    slow = {"inertia": 20.0, "proportional": 519.0, "integral": 1000.0}  # the curve falls by 30/0.05 - 80 = 520 at rest
    content = {**built_in(), "feedback": slow}
    assert parse_scenario(changed(content, "feedback.proportional", 521.0), "here").cautions() == []
    assert parse_scenario(content, "here").cautions() == [
        "the friction curve falls by up to 520 N m s/rad, more than the proportional gain of 519 N m s/rad can hold: "
        "the loop will hunt at low speed"
    ]


@pytest.mark.parametrize(
    "content",
    [b"duration = ", b"[joint", b"a = 1\na = 2", b"\xff\xfeduration = 1", b"\x00", b"[[[[", b"x = " + b"[" * 3000],
)
def test_file_that_is_no_toml_is_refused_with_its_name(tmp_path, content):
    path = tmp_path / "scenario.toml"
    path.write_bytes(content)
    assert refused(f"{path}: is not valid TOML: ", load_scenario, path)


def test_empty_file_lacks_its_tables(tmp_path):
    path = write_scenario(tmp_path, {})
    assert refused(f"{path}: ", load_scenario, path) == "joint, feedback and adaptation are missing; they must be given"


@pytest.mark.parametrize("name", [".", "missing.toml", "scenario.toml/inside", "x" * 300])
def test_file_that_cannot_be_read_is_refused_with_its_name(tmp_path, name):
    write_scenario(tmp_path, short())
    assert refused(f"{tmp_path / name}: cannot be read: ", load_scenario, tmp_path / name)


def test_path_of_a_recorded_reference_is_relative_to_the_scenario_file(tmp_path, monkeypatch):
    folder = tmp_path / "inside"
    folder.mkdir()
    (folder / "motion.csv").write_text("time,velocity\n" + "".join(f"{t},0.1\n" for t in range(61)), encoding="utf-8")
    path = write_scenario(folder, {**built_in(), "reference": {"kind": "csv", "path": "motion.csv"}})
    monkeypatch.chdir(tmp_path)
    assert load_scenario("inside/scenario.toml").motion.duration == 60.0
    assert load_scenario(path).motion.duration == 60.0
    path.write_text(to_toml({**built_in(), "reference": {"kind": "csv", "path": "gone.csv"}}), encoding="utf-8")
    with pytest.raises(InputError, match=r"gone\.csv: cannot be read: No such file"):
        load_scenario(path)
    assert load_scenario(path, reference="inside/motion.csv").motion.duration == 60.0


def test_modified_merges_into_a_joint_of_the_same_kind_and_replaces_one_of_another():
    scenario = load_scenario()
    assert scenario.modified(joint={"kind": "stribeck", "inertia": 5.0}).joint.coulomb == scenario.joint.coulomb
    bristles = {name: getattr(scenario.joint, name) for name in ("inertia", "coulomb", "stiction", "viscous")}
    bristles |= {"kind": "lugre", "stribeck_velocity": 0.05, "stiffness": 1e5}
    other = scenario.modified(joint=bristles)
    assert other.joint.kind == "lugre"
    assert other.modified(joint={"stiffness": 2e5}).joint.coulomb == 60.0
    said = r"joint\.inertia, joint\.coulomb, joint\.stiction, joint\.viscous and .* are missing"
    with pytest.raises(InputError, match=said):
        scenario.modified(joint={"kind": "lugre", "stiffness": 1e5})
