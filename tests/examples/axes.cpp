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
    std::printf("%.17g\n", command);
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
