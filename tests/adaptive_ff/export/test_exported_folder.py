"""The folder that an export writes: any compiler takes it without a warning, and its self-test passes."""

import shutil
import subprocess

import pytest
from closed_loops import sampled
from exports import SIZES, WARNINGS, adaptive, compiled, inputs, made, needs_gcc, printed, steps_in_python

from adaptive_ff import export_controller, load_scenario
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.errors import InputError

pytestmark = needs_gcc

OPTIMISED = ("-O2", "-fno-pie", *WARNINGS)
ALLOWED = {"exp", "expm1", "log", "pow", "sqrt", "memcpy", "memset"}
"""What the object may need from elsewhere; the oracle's weight needs a sine as well."""

MADE = {
    "pi": lambda: made("pi"),
    "oracle": lambda: made("oracle"),
    "feedback_error": lambda: made("feedback_error"),
    "adaptive": lambda: adaptive(SIZES["directions"], 1.5, 0.004),
}


@pytest.fixture(scope="module", params=sampled(MADE, ("pi", "adaptive")))
def folder(request, tmp_path_factory):
    out = tmp_path_factory.mktemp("exported") / "new" / "folder"
    files = export_controller(MADE[request.param](), out, prefix="drive")
    assert sorted(out.iterdir()) == sorted(files)
    compiled(out, ["drive.c"], *OPTIMISED, "-c", out="gcc.o")
    return out


@pytest.mark.parametrize("program", sampled(["gcc", "clang"], ["gcc"]))
def test_the_self_test_finds_no_difference_and_nothing_warns(folder, program):
    drive = "gcc.o" if program == "gcc" else "drive.c"
    built = compiled(folder, [drive, "drive_selftest.c"], *OPTIMISED, "-no-pie", program=program)
    assert "largest difference 0 of" in printed(built)


def test_sanitizers_are_silent(folder):
    flags = ("-O0", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    try:
        built = compiled(folder, ["drive.c", "drive_selftest.c"], *flags, out="sane")
    except AssertionError as error:
        pytest.skip(f"there are no sanitizers on this machine: {error}")
    assert "largest difference" in printed(built)


@pytest.mark.parametrize("name", sampled([*MADE, "repetitive"], ["pi", "adaptive", "repetitive"]))
def test_the_example_is_of_an_inertia_that_the_controller_follows_the_plan_with(tmp_path, name):
    """Of a light joint at 1 kHz, ten times heavier or lighter than what it was made for, it would not."""
    light = load_scenario().modified(
        joint={"inertia": 0.5}, feedback={"inertia": 0.5, "bandwidth": 60.0}, sampling={"period": 0.001}
    )
    export_controller(CONTROLLERS[name](light), tmp_path, prefix="drive")
    text = printed(compiled(tmp_path, ["drive.c", "main.c"], "-O0", *WARNINGS, out="example"))
    assert text.count("rad/s") == 5
    found = [tuple(map(float, line.replace("rad/s", "").split(":")[1].split("of"))) for line in text.splitlines()]
    assert all(abs(velocity - planned) < 0.02 for velocity, planned in found[1:])


def test_it_is_cpp_and_refuses_fast_math_and_needs_nothing_but_mathematics_and_copying(folder):
    needed = {line.split()[-1] for line in printed("nm", "-u", "gcc.o", cwd=folder).splitlines()}
    assert needed <= ALLOWED | ({"sin"} if "step_model_based" in (folder / "drive.c").read_text() else set())
    writable = [line for line in printed("nm", "gcc.o", cwd=folder).splitlines() if line.split()[-2] in "dDbBC"]
    assert writable == []  # no global variables
    with pytest.raises(AssertionError, match="fast-math"):
        compiled(folder, ["drive.c"], "-Ofast", "-c", out="fast.o")
    (folder / "use.cpp").write_text('#include "drive.h"\nint main() { drive_Controller c; drive_init(&c); }\n')
    subprocess.run(["g++", "-std=c++17", *WARNINGS, "-c", "use.cpp"], cwd=folder, check=True)


def test_in_single_precision_it_warns_of_nothing_and_stays_near(tmp_path):
    export_controller(adaptive(SIZES["offset"]), tmp_path, prefix="drive", single=True)
    subprocess.run(["gcc", "-std=c99", *WARNINGS, "-O2", "-c", "drive.c"], cwd=tmp_path, check=True)
    assert "largest difference" in printed(compiled(tmp_path, ["drive.o", "drive_selftest.c"], "-O0"))


def test_a_controller_that_has_learnt_is_exported_so(tmp_path):
    controller = made("pi")
    export_controller(controller, tmp_path / "new", prefix="drive")
    steps_in_python(controller, inputs(controller, 100))
    export_controller(controller, tmp_path / "learnt", prefix="drive")
    assert "START_STATE" not in (tmp_path / "new" / "drive.c").read_text()
    assert "controller->state = START_STATE;" in (tmp_path / "learnt" / "drive.c").read_text()
    assert "largest difference 0 of" in printed(compiled(tmp_path / "learnt", ["drive.c", "drive_selftest.c"], "-O0"))


@pytest.mark.usefixtures("compiled_quickly")
def test_the_same_controller_gives_the_same_files(tmp_path):
    folders = [tmp_path / name for name in ("first", "second")]
    for folder in folders:
        export_controller(made("pi"), folder, prefix="drive", with_fmu=True)
    first, second = ({file.name: file.read_bytes() for file in folder.iterdir()} for folder in folders)
    assert {"drive.c", "drive.fmu"} < set(first)
    assert first == second


def test_a_folder_that_cannot_be_written_is_left_as_it_is(tmp_path):
    (tmp_path / "file").write_text("kept")
    (tmp_path / "drive.c").mkdir()
    for place, message in ((tmp_path / "file", "cannot be written"), (tmp_path, "it is a folder")):
        with pytest.raises(InputError, match=message):
            export_controller(made("pi"), place, prefix="drive")
    assert {path.name for path in tmp_path.iterdir()} == {"file", "drive.c"}


@pytest.mark.skipif(shutil.which("cmake") is None, reason="there is no cmake on this machine")
def test_cmake_builds_the_library_and_its_test_passes(tmp_path):
    export_controller(made("pi"), tmp_path / "source", prefix="drive")
    for line in ("cmake -S source -B built", "cmake --build built", "ctest --test-dir built --no-tests=error"):
        printed(*line.split(), cwd=tmp_path)
