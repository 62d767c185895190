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
    std::printf("%.17g\n", command);
  }
  const double last = command;
  references[3].set_value(1e7);
  if (axis.update(rclcpp::Time(), period) != controller_interface::return_type::ERROR || command != last) { return 6; }
  return 0;
}
