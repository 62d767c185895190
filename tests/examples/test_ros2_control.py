"""The wrapper for ros2_control compiles against stub interfaces, and commands what Python does."""

import json
import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from exports import adaptive, made, printed

from adaptive_ff import WITH_GRAVITY, WITH_OFFSET, export_controller, run_in_c

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "ros2_control"
WARNINGS = ("-Wall", "-Wextra", "-Wshadow", "-pedantic", "-Werror")
CPP = ("-std=c++17", "-O1", *WARNINGS, "-I", EXAMPLE, "-I", EXAMPLE / "stubs")

needs_compilers = pytest.mark.skipif(
    shutil.which("g++") is None or shutil.which("gcc") is None, reason="there is no g++ on this machine"
)


def build(folder, program, prefixes):
    """Build a program ``use`` of exported controllers, from a file beside this one."""
    printed("g++", *CPP, "-I", folder, "-c", Path(__file__).with_name(program), "-o", "use.o", cwd=folder)
    printed("gcc", "-std=c99", "-O1", "-c", *(f"{prefix}.c" for prefix in prefixes), cwd=folder)
    printed("g++", "use.o", *(f"{prefix}.o" for prefix in prefixes), "-o", "use", "-lm", cwd=folder)


@pytest.mark.nightly
@needs_compilers
def test_the_wrapper_compiles_and_commands_what_python_does(tmp_path):
    for place in range(1, 7):
        export_controller(adaptive(WITH_GRAVITY) if place == 1 else made("pi"), tmp_path, prefix=f"axis{place}")
    printed("g++", *CPP, "-I", tmp_path, "-c", EXAMPLE / "plugins.cpp", "-o", tmp_path / "plugins.o")
    build(tmp_path, "axes.cpp", [f"axis{place}" for place in range(1, 7)])
    commanded = {}
    for mode in ("alone", "cascaded"):
        found = np.loadtxt(printed("./use", f"{mode}.state", mode, cwd=tmp_path).splitlines())
        commanded[mode] = commands_of_python(mode == "cascaded")
        assert np.ptp(commanded[mode]) > 40.0
        assert np.allclose(found, commanded[mode], rtol=1e-11, atol=1e-11)
    assert np.max(np.abs(commanded["cascaded"] - commanded["alone"])) > 1.0


@pytest.mark.nightly
@needs_compilers
@pytest.mark.parametrize("single", [False, True], ids=["double", "single"])
def test_the_wrapper_hands_on_further_known_regressors(tmp_path, single):
    if single:
        pytest.importorskip("cffi", reason="cffi is not installed")
    made_for_two = adaptive(WITH_OFFSET, regressors=2)
    export_controller(made_for_two, tmp_path, prefix="elbow", single=single)
    build(tmp_path, "regressors.cpp", ["elbow"])
    found = np.loadtxt(printed("./use", cwd=tmp_path).splitlines())
    given, without = (commands_with_regressors(told, single) for told in (True, False))
    assert np.max(np.abs(given - without)) > 10.0
    rounding = 1e-6 if single else 1e-11
    assert np.allclose(found, given, rtol=rounding, atol=rounding)


def commands_with_regressors(given, single):
    """Commands of the axis with two regressors in the loop of the program, shape (300,); nothing damps that loop."""
    controller, command = adaptive(WITH_OFFSET, regressors=2), 0.0
    controller = run_in_c(controller, single=True) if single else controller.run_uncompiled()
    commands = []
    for k in range(300):
        held = [math.sin(0.05 * k), math.nan if k % 30 == 4 else math.cos(0.031 * k)]
        known = {"regressors": held} if given and k >= 20 else {}
        velocity = 0.19 * math.sin(0.03 * k - 0.03)
        command = controller.step(0.2 * math.sin(0.03 * k), velocity, realised_torque=command, **known)
        commands.append(command)
    return np.array(commands)


def commands_of_python(cascaded):
    """Commands of the first axis in the loop of the program, limited, shape (300,)."""
    controller, command = adaptive(WITH_GRAVITY).run_uncompiled(), 0.0
    commands = []
    for k in range(300):
        velocity = math.nan if k % 50 == 7 else 0.19 * math.sin(0.03 * k - 0.03)
        given = {"feedforward": 1.5, "realised_torque": command}
        if cascaded:
            given["correction"] = 0.0 if k % 30 == 4 else 0.02 * math.sin(0.07 * k)
            given["position"] = math.nan if k % 40 == 9 else 0.5 - 6.0 * math.cos(0.03 * k)
        torque = controller.step(0.2 * math.sin(0.03 * k), velocity, **given)
        command = min(max(torque, -40.0), 40.0)
        commands.append(command)
    return np.array(commands)


def test_the_parameters_name_a_class_and_a_joint_for_each_axis():
    text, classes = (EXAMPLE / "controllers.yaml").read_text(), (EXAMPLE / "plugins.xml").read_text()
    for place in range(1, 7):
        assert f"type: friction_compensation/Axis{place}\n" in text
        assert f"joint: joint_{place}\n" in text
        assert f'name="friction_compensation/Axis{place}"' in classes
    assert json.dumps(text).count("effort_limit") == json.dumps(text).count("use_position: true") == 6
