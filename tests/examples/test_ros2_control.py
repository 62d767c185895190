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
PROGRAM = """
#include <cstdio>
#include "axes.hpp"

int main(int, char ** arguments)
{
  const bool cascaded = std::string(arguments[2]) == "cascaded";
  friction_compensation::Axis1 axis;
  axis.get_node()->name = "axis1_velocity";
  using controller_interface::CallbackReturn;
  if (axis.on_init() != CallbackReturn::ERROR) { return 1; }  // no joint is named
  axis.get_node()->texts["joint"] = "joint_1";
  axis.get_node()->numbers["effort_limit"] = 40.0;
  axis.get_node()->texts["state_file"] = arguments[1];
  if (cascaded) { axis.get_node()->flags["use_position"] = true; }
  double velocity = 0.0, effort = 0.0, position = 0.0, command = 0.0;
  using hardware_interface::LoanedInterface;
  axis.state_interfaces_ = {LoanedInterface(&velocity), LoanedInterface(&effort)};
  if (cascaded) { axis.state_interfaces_.emplace_back(&position); }
  axis.command_interfaces_ = {LoanedInterface(&command)};
  const rclcpp_lifecycle::State state;
  if (axis.on_init() != CallbackReturn::SUCCESS || axis.on_configure(state) != CallbackReturn::SUCCESS) { return 2; }
  auto references = axis.export_reference_interfaces();
  if (axis.on_activate(state) != CallbackReturn::SUCCESS) { return 3; }
  if (references[0].get_name() != "axis1_velocity/joint_1/velocity") { return 4; }
  if (references[2].get_name() != "axis1_velocity/joint_1/velocity_correction") { return 9; }
  const auto claimed = axis.state_interface_configuration().names;
  if (claimed.size() != axis.state_interfaces_.size()) { return 10; }
  if (cascaded && claimed[2] != "joint_1/position") { return 11; }
  const rclcpp::Duration period(0.01);
  for (int k = 0; k < 300; k++) {
    references[0].set_value(0.2 * std::sin(0.03 * k));
    references[1].set_value(1.5);
    if (cascaded) { references[2].set_value(k % 30 == 4 ? std::nan("") : 0.02 * std::sin(0.07 * k)); }
    position = k % 40 == 9 ? std::nan("") : 0.5 - 6.0 * std::cos(0.03 * k);
    velocity = k % 50 == 7 ? std::nan("") : 0.19 * std::sin(0.03 * k - 0.03);
    effort = command;
    if (axis.update(rclcpp::Time(), period) != controller_interface::return_type::OK) { return 5; }
    std::printf("%.17g\\n", command);
  }
  references[0].set_value(std::nan(""));
  if (axis.update(rclcpp::Time(), period) != controller_interface::return_type::ERROR) { return 6; }
  if (axis.on_deactivate(state) != CallbackReturn::SUCCESS || command != 0.0) { return 7; }
  if (axis.on_configure(state) != CallbackReturn::SUCCESS) { return 8; }  // the state that it has left
  if (axis.on_activate(state) != CallbackReturn::SUCCESS) { return 12; }
  references[0].set_value(0.0);
  references[1].set_value(0.0);
  if (cascaded) { references[2].set_value(0.0); }
  velocity = effort = 0.0;
  if (axis.update(rclcpp::Time(), period) != controller_interface::return_type::OK) { return 13; }
  if (std::fabs(command) > 1.0) { return 14; }  // a joint at rest is not thrown by the integral of the last motion
  return 0;
}
"""


WITH_REGRESSORS = """
#include <cstdio>
#include "axis.hpp"
#include "friction_compensation.hpp"
#include "elbow.h"

FRICTION_COMPENSATION_AXIS_WITH_REGRESSORS(Elbow, elbow, ELBOW)

int main()
{
  friction_compensation::FrictionCompensation<Elbow> axis;
  axis.get_node()->texts["joint"] = "joint_2";
  double velocity = 0.0, effort = 0.0, command = 0.0;
  using hardware_interface::LoanedInterface;
  axis.state_interfaces_ = {LoanedInterface(&velocity), LoanedInterface(&effort)};
  axis.command_interfaces_ = {LoanedInterface(&command)};
  const rclcpp_lifecycle::State state;
  using controller_interface::CallbackReturn;
  if (axis.on_init() != CallbackReturn::SUCCESS || axis.on_configure(state) != CallbackReturn::SUCCESS) { return 1; }
  auto references = axis.export_reference_interfaces();
  if (axis.on_activate(state) != CallbackReturn::SUCCESS) { return 2; }
  if (references.size() != 5 || references[3].get_name() != "controller/joint_2/regressor_1") { return 3; }
  if (references[4].get_name() != "controller/joint_2/regressor_2") { return 4; }
  const rclcpp::Duration period(0.01);
  for (int k = 0; k < 300; k++) {
    references[0].set_value(0.2 * std::sin(0.03 * k));
    if (k >= 20) {
      references[3].set_value(std::sin(0.05 * k));
      references[4].set_value(k % 30 == 4 ? std::nan("") : std::cos(0.031 * k));
    }
    velocity = 0.19 * std::sin(0.03 * k - 0.03);
    effort = command;
    if (axis.update(rclcpp::Time(), period) != controller_interface::return_type::OK) { return 5; }
    std::printf("%.17g\\n", command);
  }
  const double last = command;
  references[3].set_value(1e7);
  if (axis.update(rclcpp::Time(), period) != controller_interface::return_type::ERROR || command != last) { return 6; }
  return 0;
}
"""

needs_compilers = pytest.mark.skipif(
    shutil.which("g++") is None or shutil.which("gcc") is None, reason="there is no g++ on this machine"
)


def build(folder, program, prefixes):
    """Build a program ``use`` of exported controllers."""
    (folder / "use.cpp").write_text(program)
    printed("g++", *CPP, "-I", folder, "-c", "use.cpp", cwd=folder)
    printed("gcc", "-std=c99", "-O1", "-c", *(f"{prefix}.c" for prefix in prefixes), cwd=folder)
    printed("g++", "use.o", *(f"{prefix}.o" for prefix in prefixes), "-o", "use", "-lm", cwd=folder)


@pytest.mark.nightly
@needs_compilers
def test_the_wrapper_compiles_and_commands_what_python_does(tmp_path):
    for place in range(1, 7):
        export_controller(adaptive(WITH_GRAVITY) if place == 1 else made("pi"), tmp_path, prefix=f"axis{place}")
    printed("g++", *CPP, "-I", tmp_path, "-c", EXAMPLE / "plugins.cpp", "-o", tmp_path / "plugins.o")
    build(tmp_path, PROGRAM, [f"axis{place}" for place in range(1, 7)])
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
    build(tmp_path, WITH_REGRESSORS, ["elbow"])
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
