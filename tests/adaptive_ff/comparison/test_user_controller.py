"""A user's own controller: any object with a method ``step``."""

import inspect
import json
import math
import sys

import numpy as np
import pytest
from closed_loops import SCENARIO
from command_line import refusal, run_command_line
from scenario_files import write_scenario

from adaptive_ff import InputError, compare, simulate
from adaptive_ff.comparison.own import OFFERED, load_own, make_own, own_marks
from controllers import PI

SHORT = SCENARIO.modified(duration=4.0, controllers=["pi", "oracle"])
GAIN = SHORT.feedback.gains[0]


class Proportional:
    """The least that a controller can be."""

    def __init__(self, gain):
        self.gain = gain
        self.given = []

    def step(self, reference, velocity, *, next_reference, realised_torque, feedforward, dt):
        self.given.append((next_reference, realised_torque, feedforward, dt))
        return self.gain * (reference - velocity) + feedforward


def test_own_proportional_loop_is_the_pi_loop_without_integral():
    own = simulate(SHORT, Proportional(GAIN))
    expected = simulate(SHORT, PI(GAIN, 0.0, SHORT.sampling.period))
    assert np.ptp(expected.torque) > 100.0
    assert own.torque == pytest.approx(expected.torque, rel=1e-12, abs=1e-12)
    assert own.velocity == pytest.approx(expected.velocity, rel=1e-12, abs=1e-15)
    assert vars(own.metrics) == pytest.approx(vars(expected.metrics), rel=1e-10)
    assert own.name == "Proportional"
    assert own.estimates == {}
    assert not np.any(own.feedforward)


def test_own_controller_is_given_the_preview_the_realised_torque_and_the_time_step():
    scenario = SHORT.modified(actuator={"torque_limit": 30.0})
    controller = Proportional(1000.0)
    run = simulate(scenario, controller)
    following, realised, feedforward, steps = (list(column) for column in zip(*controller.given, strict=True))
    assert np.array_equal(following, run.reference[scenario.substeps :: scenario.substeps])
    assert realised[0] is None
    assert np.array_equal(realised[1:], run.torque[:-1])
    assert np.max(np.abs(run.torque)) == 30.0  # the torque of the drive, not what was asked
    assert set(feedforward) == {0.0}
    assert steps == pytest.approx([scenario.sampling.period] * scenario.samples, rel=1e-12)


class Switching(Proportional):
    """Replaces its own step, as a machine of states does."""

    def step(self, reference, velocity, **others):
        self.step = lambda reference, velocity, **others: 0.0
        return self.gain * (reference - velocity)


def test_own_controller_may_replace_its_step_on_the_way():
    run = simulate(SHORT, Switching(GAIN))
    assert abs(run.torque[0]) > 0.0
    assert not np.any(run.torque[1:])


class Recording(Proportional):
    """Takes everything, and remembers the positions."""

    def step(self, reference, velocity, *, position, feedforward, dt, **others):
        self.given.append((position, others))
        return self.gain * (reference - velocity) + feedforward


def test_own_controller_is_given_only_what_its_step_accepts():
    class Least(Proportional):
        def step(self, reference, velocity):
            return self.gain * (reference - velocity)

    assert np.array_equal(simulate(SHORT, Least(GAIN)).torque, simulate(SHORT, Proportional(GAIN)).torque)
    recording = Recording(GAIN)
    simulate(SHORT, recording)
    others = recording.given[7][1]
    assert (others["correction"], others["inertia"]) == (0.0, None)
    previews = {"next_reference", "acting_reference", "next_acting_reference"}
    assert set(others) == previews | {"correction", "realised_torque", "inertia"}


def test_position_is_the_true_one_rounded_or_the_reading_of_the_encoder():
    resolution = 2e-4
    encoder = {"encoder_resolution": resolution, "velocity_noise": 0.0}
    for sensor, step in ({}, 1e-5), (encoder, resolution):
        scenario = SHORT.modified(sensor=sensor)
        controller = Recording(1000.0)
        run = simulate(scenario, controller)
        found = np.array([position for position, _ in controller.given])
        assert np.ptp(found) > 0.1
        assert found / step == pytest.approx(np.round(found / step), abs=1e-6)
        travelled = np.append(0.0, np.cumsum(run.velocity[:-1]) * scenario.joint.solver_period)
        assert found == pytest.approx(travelled[scenario.sample_steps[:-1]], abs=step + 1e-3)


def test_own_controller_stands_beside_the_others_in_a_comparison():
    seen = []

    def make(scenario):
        seen.append(scenario)
        return Proportional(scenario.feedback.gains[0])

    comparison = compare(SHORT, own={"mine": make})
    assert list(comparison.runs) == ["pi", "oracle", "mine"]
    assert seen == [SHORT]
    alone = simulate(SHORT, Proportional(GAIN))
    assert np.array_equal(comparison.runs["mine"].torque, alone.torque)
    result = comparison.to_dict()
    assert result["controllers"]["mine"] == vars(alone.metrics)
    ratio = result["controllers"]["pi"]["rms_error_settled"] / alone.metrics.rms_error_settled
    assert result["improvement"]["mine"] == pytest.approx(ratio, rel=1e-12)


def test_unknown_name_is_refused_with_those_there_are():
    with pytest.raises(InputError, match=r"'mien' is not known; there are pi, .*mine"):
        compare(SHORT.modified(controllers=["mien"]), own={"mine": lambda: Proportional(1.0)})


class Learner:
    """Feeds friction forward that it "learns", under the names of the package and one of its own."""

    def __init__(self, proportional, integral, *, period, scenario):
        self.gains, self.period, self.scenario = (proportional, integral), period, scenario
        self.feedforward = 0.0
        self.estimates = {"coulomb": 0.0, "steps": 0.0}

    def step(self, reference, velocity):
        self.estimates = {"steps": self.estimates["steps"] + 1.0, "coulomb": 55.0}
        self.feedforward = 55.0 * np.sign(reference)
        return self.gains[0] * (reference - velocity) + self.feedforward


def test_class_gets_the_gains_and_its_feedforward_and_estimates_are_recorded():
    comparison = compare(SHORT, own={"mine": Learner})
    run = comparison.runs["mine"]
    assert list(run.estimates) == ["coulomb", "steps"]
    assert run.final_estimates == {"coulomb": 55.0, "steps": float(SHORT.samples)}
    assert np.array_equal(run.estimates["steps"], 1.0 + np.arange(SHORT.samples))
    assert np.array_equal(run.feedforward, 55.0 * np.sign(run.reference[SHORT.sample_steps[:-1]]))
    assert comparison.to_dict()["controllers"]["mine"]["estimates"]["coulomb"] == 55.0


@pytest.mark.parametrize(
    ("factory", "expected"),
    [
        (lambda scenario: ("scenario", scenario), ("scenario", SHORT)),
        (lambda integral, proportional: (proportional, integral), SHORT.feedback.gains),
        (lambda period, inertia=0.0: (period, inertia), (SHORT.sampling.period, SHORT.feedback.inertia)),
        (lambda: "nothing", "nothing"),
        (lambda **given: sorted(given), sorted(OFFERED)),
    ],
)
def test_factory_is_given_what_its_arguments_are_called(factory, expected):
    made = []

    def wrapped(*arguments, **named):
        made.append(factory(*arguments, **named))
        return Proportional(1.0)

    wrapped.__signature__ = inspect.signature(factory)
    make_own("mine", wrapped, SHORT)
    assert made == [expected]


@pytest.mark.parametrize(
    ("own", "said"),
    [
        (3.0, r"own controller 'mine' = 3.0 is not allowed"),
        (lambda first, second: None, r"needs first, second; a class or factory is given scenario, proportional"),
        (lambda gain: None, r"needs gain; a class or factory is given scenario, proportional, integral"),
        (lambda scenario: 5, r"made 5, which has no method step"),
        ("mine.py", r"must be FILE.py:NAME"),
        ("nowhere.py:Mine", r"nowhere.py: cannot be read: there is no such file"),
    ],
)
def test_what_is_no_controller_is_refused(own, said):
    with pytest.raises(InputError, match=said):
        compare(SHORT, own={"mine": own})


@pytest.mark.parametrize(
    ("step", "reason"),
    [
        (lambda self, error: 0.0, r"step\(error\) \(too many positional arguments\)"),
        (lambda self, reference, velocity, gain: 0.0, r"step\(reference, velocity, gain\) \(missing .*'gain'\)"),
        (lambda self, dt, velocity: 0.0, r"step\(dt, velocity\) \(multiple values for argument 'dt'\)"),
    ],
)
def test_step_that_cannot_be_called_is_refused_before_anything_runs(step, reason):
    mine = type("Mine", (), {"step": step})
    said = rf"the own controller Mine has {reason}; it is called with reference and velocity, and by name .* of next_"
    for own in (mine, mine(), lambda scenario: mine()):
        with pytest.raises(InputError, match=said):
            make_own("mine", own, SHORT)
    with pytest.raises(InputError, match=said):
        simulate(SHORT, mine())


def test_step_that_ends_the_program_is_an_error():
    ending = type("Ending", (), {"step": lambda self, reference, velocity: sys.exit(0)})
    with pytest.raises(InputError, match="the own controller Ending ends the program: SystemExit: 0"):
        simulate(SHORT, ending())


def test_mark_follows_what_an_own_controller_loads_from_beside_it(tmp_path):
    (tmp_path / "gained.py").write_text("from gain_beside import GAIN\n\nclass Gained:\n    step = print\n")
    marks = []
    for gain in (1.0, 1.0, 2.0):
        (tmp_path / "gain_beside.py").write_text(f"GAIN = {gain}\n")
        marks.append(own_marks({"mine": f"{tmp_path / 'gained.py'}:Gained"})["mine"])
    assert marks[0] == marks[1] != marks[2]


def test_estimate_that_is_not_finite_is_refused():
    class Lost(Learner):
        def step(self, reference, velocity):
            torque = super().step(reference, velocity)
            self.estimates["coulomb"] = math.nan
            return torque

    with pytest.raises(ValueError, match=r"estimates\['coulomb'\] = nan; it must be a finite number"):
        compare(SHORT, own={"mine": Lost})


SOURCE = """
from beside import GAIN

class Mine:
    estimates = {"coulomb": 1.0}

    def step(self, reference, velocity, **_):
        return GAIN * (reference - velocity)

def make(proportional):
    return Mine()
"""


@pytest.fixture
def source(tmp_path):
    """A file with an own controller, and one beside it."""
    (tmp_path / "beside.py").write_text("GAIN = 500.0", encoding="utf-8")
    path = tmp_path / "mine.py"
    path.write_text(SOURCE, encoding="utf-8")
    return path


def test_controller_is_loaded_from_a_file_on_the_command_line(source, tmp_path, without_pictures, compiled):
    scenario = write_scenario(tmp_path, SHORT.modified(duration=1.0).model_dump(mode="json", exclude_none=True))
    places = ("--own", f"{source}:Mine", "--own", f"second={source}:make")
    outcome = run_command_line("compare", scenario, *places, "--out", tmp_path / "out")
    assert (outcome.status, outcome.err) == (0, "")
    result = json.loads((tmp_path / "out" / "result.json").read_text(encoding="utf-8"))
    assert list(result["controllers"]) == ["pi", "oracle", "Mine", "second"]
    assert result["controllers"]["Mine"] == result["controllers"]["second"]
    assert [line.split()[0] for line in outcome.out.splitlines() if line.strip().startswith(("Mine", "second"))]


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ("{}:Other", "there is no Other; there are Mine, make"),
        ("pi={}:Mine", "own = 'pi' is not allowed: that is the name of a controller of this package"),
        ("{}", "must be FILE.py:NAME"),
        ("../me={}:Mine", "own = '../me' is not allowed: it names files, so it must be printable, without any of / "),
        ("={}:Mine", "own = '' is not allowed: it names files, so it must be "),
    ],
)
def test_bad_file_or_name_is_refused_on_the_command_line(source, tmp_path, place, said):
    assert said in refusal("compare", "--own", place.format(source), "--out", tmp_path / "out")


def test_file_that_cannot_be_loaded_is_refused_with_its_error(tmp_path):
    broken = tmp_path / "broken.py"
    broken.write_text("import nowhere_to_be_found", encoding="utf-8")
    line = refusal("compare", "--own", f"{broken}:Mine", "--out", tmp_path / "out")
    assert "broken.py: cannot be loaded: ModuleNotFoundError: No module named 'nowhere_to_be_found'" in line
    broken.write_text("raise SystemExit(3)", encoding="utf-8")
    assert "broken.py: cannot be loaded: SystemExit: 3" in refusal("compare", "--own", f"{broken}:Mine")


@pytest.mark.parametrize("name", ["..", "a/b", "a\\b", "a:b", "line\n", " "])
def test_name_that_no_file_can_have_is_refused_before_anything_runs(name):
    with pytest.raises(InputError, match=r"^own = .* is not allowed: it names files"):
        compare(SHORT, own={name: lambda scenario: pytest.fail("it ran")})
    with pytest.raises(TypeError, match=r"^own: a name = 3 is not allowed: it must be a text"):
        compare(SHORT, own={3: None})


def test_own_controllers_import_what_lies_beside_them_whatever_else_has_that_name(tmp_path):
    found = []
    for gain in (100.0, 200.0):
        folder = tmp_path / f"gain_{gain:g}"
        folder.mkdir()
        (folder / "beside.py").write_text(f"GAIN = {gain}\n")
        (folder / "mine.py").write_text(SOURCE)
        found.append(load_own(f"{folder / 'mine.py'}:Mine")().step(1.0, 0.0))
    assert found == [100.0, 200.0]
