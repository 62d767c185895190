"""Help that can be read, and names of modules that stay those of what they hold."""

import inspect
import pydoc
import re
import subprocess
import sys

import pytest

import adaptive_ff
import controllers
from adaptive_ff import InputError, Scenario, load_scenario
from plant import JointModel
from plant.fields import StrictTable

NOISE = ("numpy._typing", "numpy.ndarray[", "FieldInfo", "pydantic_core", "__pydantic", "Discriminator", "model_dump")


def text_of(thing):
    return pydoc.plain(pydoc.render_doc(thing))


@pytest.mark.parametrize("package", [adaptive_ff, controllers], ids=lambda package: package.__name__)
def test_help_of_public_names_shows_no_internals(package):
    texts = {name: text_of(getattr(package, name)) for name in package.__all__}
    assert [(name, word) for name, text in texts.items() for word in NOISE if word in text] == []


def test_help_of_package_begins_with_what_is_there_for_which_task():
    overview = inspect.getdoc(adaptive_ff)
    left_out = "PER_DIRECTION PER_DIRECTION_WITH_GRAVITY WITH_GRAVITY WITH_OFFSET identify_series identify_torque_form"
    missing = [name for name in adaptive_ff.__all__ if name not in overview]
    assert missing == [*left_out.split(), "parse_scenario", "read_baseline"]
    assert len(overview.splitlines()) < 40


@pytest.mark.parametrize(("thing", "most"), [(Scenario, 150), (JointModel, 70), (adaptive_ff.compare, 40)])
def test_help_is_short(thing, most):
    lines = text_of(thing).splitlines()  # from Python 3.13 on each argument has a line, which does not count
    assert len([line for line in lines if not re.fullmatch(r"[ |]+[*\w]+(: .*)?,", line)]) < most


def test_signature_of_scenario_names_fields_types_and_defaults():
    parameters = inspect.signature(Scenario).parameters
    assert list(parameters) == list(Scenario.model_fields)
    assert str(parameters["duration"]) == "duration: float | None = None"
    assert str(parameters["sensor"]) == "sensor: Sensor = Sensor()"
    assert str(parameters["feedback"]) == "feedback: Feedback"
    assert str(parameters["change"]) == "change: list[FrictionChange] = []"
    assert "JointModel | LuGreJoint" in str(parameters["joint"])


def test_completion_offers_fields_and_still_checks_them():
    scenario = load_scenario()
    assert {"feedback", "modified", "length"} <= set(dir(scenario))
    assert not any(name.startswith("model_") for name in dir(scenario))
    with pytest.raises(InputError, match=r"feedback\.bandwidth"):
        scenario.modified(feedback={"bandwidth": -1.0})


def test_types_of_arrays_are_named_in_signatures():
    assert "velocity: ArrayLike" in str(inspect.signature(adaptive_ff.fit_stribeck))
    assert "standard_error: ArrayLike | None = None" in str(inspect.signature(adaptive_ff.fit_stribeck))
    assert adaptive_ff.Run.__annotations__["time"].__repr__() == "NDArray[float64]"


class Described(StrictTable):
    """A table."""

    # above two fields,
    # in two lines
    one: float = 0.0
    two: float = 0.0
    own: float = 0.0  # beside its field
    needed: float  # without a default
    bare: float = 0.0


class Inherited(Described):
    more: float = 0.0  # of the subclass


def test_field_has_its_own_comment_or_that_above_its_group():
    lines = [line.strip() for line in Described.__doc__.splitlines()]
    assert lines == [
        *("A table.", "", "Parameters", "----------", "one, two : float, optional"),
        *("Above two fields, in two lines.", "own : float, optional", "Beside its field."),
        *("needed : float", "Without a default."),
    ]


def test_subclass_without_a_text_has_that_of_its_base():
    assert Inherited.__doc__.startswith("A table.\n\nParameters\n----------\nmore : float, optional\n")


@pytest.mark.parametrize("stranger", ["controllers.py", "plant/__init__.py"])
def test_stranger_is_named(tmp_path, stranger):
    path = tmp_path / stranger
    path.parent.mkdir(exist_ok=True)
    path.write_text("X = 1\n", encoding="utf-8")
    command = [sys.executable, "-c", "import adaptive_ff"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    last = done.stderr.strip().splitlines()[-1]
    name = stranger.partition("/")[0].removesuffix(".py")
    assert last.startswith("ImportError: ")
    assert stranger in last
    assert f"stands in the place of the package {name!r}" in last
    assert "rename that file or folder" in last


def test_folder_without_code_hides_no_installed_package_or_is_named(tmp_path):
    (tmp_path / "plant").mkdir()
    code = "import adaptive_ff, plant; print(adaptive_ff.load_scenario().joint.inertia)"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
    if done.returncode == 0:
        assert done.stdout == "20.0\n"
    else:  # an editable installation, whose packages come last
        assert f"{tmp_path / 'plant'} stands in the place of the package 'plant'" in done.stderr
