"""``adaptive-ff export``: files of a controller of a scenario, or of a state; bad input leaves nothing."""

from command_line import refusal, run_command_line
from exports import inputs, made, steps_in_python

from adaptive_ff.scenario.new import new_scenario_text


def test_it_writes_the_adaptive_controller_of_the_built_in_scenario(tmp_path):
    outcome = run_command_line("export", "--out", tmp_path / "out")
    assert outcome.status == 0
    assert outcome.err == ""
    names = {"adaptive.h", "adaptive.c", "adaptive_selftest.c", "main.c", "CMakeLists.txt"}
    assert {path.name for path in (tmp_path / "out").iterdir()} == names
    assert all(name in outcome.out for name in names)
    assert ".torque_limit = 400.0" in (tmp_path / "out" / "adaptive.c").read_text()


def test_controller_prefix_precision_and_fmu_are_chosen(tmp_path):
    options = ("--controller", "oracle", "--prefix", "axis1", "--float", "--fmu", "3.0")
    assert run_command_line("export", *options, "--out", tmp_path).status == 0
    assert "float torque;" in (tmp_path / "axis1.h").read_text()
    assert (tmp_path / "axis1.fmu").stat().st_size > 5000
    assert run_command_line("export", "--controller", "pi", "--out", tmp_path).status == 0
    assert "realised_torque" in (tmp_path / "main.c").read_text()  # which is not given the limit of the drive


def test_it_starts_in_a_saved_state(tmp_path):
    controller = made("adaptive")
    steps_in_python(controller, inputs(controller, 60))
    (tmp_path / "state.json").write_text(controller.state_to_json())
    assert run_command_line("export", "--state", tmp_path / "state.json", "--out", tmp_path / "out").status == 0
    text = (tmp_path / "out" / "adaptive.c").read_text()
    assert repr(controller.estimates["inertia"]) in text[text.index("START_STATE") :]


def test_refusals_name_what_is_wrong_and_write_nothing(tmp_path):
    texts = {"broken": "{", "number": "3", "replay": '{"replay": ["inertia"]}', "file": ""}
    texts["pi"] = made("pi").state_to_json()
    for name, text in texts.items():
        (tmp_path / name).write_text(text)
    of_a_replay = "is the state of a replay, not of a controller; identify the log, and give its scenario.toml"
    out, file = ("--out", tmp_path / "out"), tmp_path / "file"
    cases = {
        ("--controller", "none"): "controllers = 'none' is not known; there are pi,",
        ("--fmu", "1.0"): "with_fmu = '1.0' is not allowed: it must be one of 2.0, 3.0",
        ("--prefix", "1st"): "prefix = '1st' is not allowed",
        ("--state", tmp_path / "pi"): "controller = 'PI' is not allowed: this is a 'AdaptiveController'",
        ("--state", tmp_path / "broken"): "is no saved state",
        ("--state", tmp_path / "number"): "must be a JSON object",
        ("--state", tmp_path / "replay"): of_a_replay,
        ("--state", tmp_path / "missing.json"): "cannot be read",
        (tmp_path / "missing.toml",): "missing.toml",
    }
    for options, message in cases.items():
        assert message in refusal("export", *options, *out)
    assert "cannot be written" in refusal("export", "--out", file)
    assert not (tmp_path / "out").exists()
    assert file.read_text() == ""


def test_a_scenario_without_a_limit_of_the_drive_is_exported_without_one(tmp_path):
    """As ``identify`` writes it: no log tells the limit."""
    text = new_scenario_text(0.5, 123.5, 6.0)
    scenario = "".join(line for line in text.splitlines(keepends=True) if not line.startswith("torque_limit"))
    (tmp_path / "scenario.toml").write_text(scenario)
    outcome = run_command_line("export", tmp_path / "scenario.toml", "--out", tmp_path / "out")
    assert (outcome.status, outcome.err) == (0, "")
    assert ".torque_limit = (double)INFINITY" in (tmp_path / "out" / "adaptive.c").read_text()
