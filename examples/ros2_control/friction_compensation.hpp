// A chainable velocity controller of ros2_control around exported controllers, one class for each axis.
//
// Reference interfaces: the planned velocity (rad/s), a torque known from elsewhere, such as gravity (N m), and what a
// position loop adds to the plan (rad/s), which only the feedback follows; for an axis whose controller was made for
// further known regressors, such as sines of summed angles in a coupled arm, each of these, of the size of one.
// State interfaces: velocity (rad/s) and effort (N m) of the joint; with the parameter use_position its position (rad).
// Command interface: its effort (N m).
#pragma once

#include <cmath>
#include <cstddef>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "controller_interface/chainable_controller_interface.hpp"

namespace friction_compensation
{

using controller_interface::CallbackReturn;
using controller_interface::InterfaceConfiguration;
using controller_interface::return_type;

// The controller of one axis. Axis wraps the functions of one exported header, see axis.hpp.
template <class Axis>
class FrictionCompensation : public controller_interface::ChainableControllerInterface
{
public:
  CallbackReturn on_init() override
  {
    joint_ = this->template auto_declare<std::string>("joint", "");
    limit_ = this->template auto_declare<double>("effort_limit", std::numeric_limits<double>::infinity());
    state_file_ = this->template auto_declare<std::string>("state_file", "");
    use_position_ = this->template auto_declare<bool>("use_position", false);
    return joint_.empty() || !(limit_ > 0.0) ? CallbackReturn::ERROR : CallbackReturn::SUCCESS;
  }

  InterfaceConfiguration command_interface_configuration() const override
  {
    return {controller_interface::interface_configuration_type::INDIVIDUAL, {joint_ + "/effort"}};
  }

  InterfaceConfiguration state_interface_configuration() const override
  {
    std::vector<std::string> names{joint_ + "/velocity", joint_ + "/effort"};
    if (use_position_) {
      names.push_back(joint_ + "/position");
    }
    return {controller_interface::interface_configuration_type::INDIVIDUAL, names};
  }

  CallbackReturn on_configure(const rclcpp_lifecycle::State &) override
  {
    Axis::init(&controller_);
    used_ = false;
    if (!state_file_.empty()) {
      std::ifstream file(state_file_, std::ios::binary);
      if (file) {  // the first time there is none
        std::vector<char> read((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
        const auto * bytes = reinterpret_cast<const unsigned char *>(read.data());
        if (Axis::load_state(&controller_, bytes, read.size()) != 0) {
          return CallbackReturn::ERROR;  // damaged, or of another controller: nothing was changed
        }
        used_ = true;
      }
    }
    return CallbackReturn::SUCCESS;
  }

  CallbackReturn on_activate(const rclcpp_lifecycle::State &) override
  {
    begin_references();
    if (used_) {
      Axis::restart(&controller_);  // else it would go on with the integral of the motion in which it was left
    }
    used_ = true;
    last_torque_ = std::numeric_limits<double>::quiet_NaN();
    return CallbackReturn::SUCCESS;
  }

  CallbackReturn on_deactivate(const rclcpp_lifecycle::State &) override
  {
    this->command_interfaces_[0].set_value(0.0);
    if (!state_file_.empty()) {
      std::vector<unsigned char> bytes(Axis::state_size);
      std::ofstream file(state_file_, std::ios::binary);
      if (Axis::save_state(&controller_, bytes.data(), bytes.size()) != 0 ||
          !file.write(reinterpret_cast<const char *>(bytes.data()), static_cast<std::streamsize>(bytes.size()))) {
        return CallbackReturn::ERROR;
      }
    }
    return CallbackReturn::SUCCESS;
  }

protected:
  std::vector<hardware_interface::CommandInterface> on_export_reference_interfaces() override
  {
    begin_references();
    const std::string name = this->get_node()->get_name();
    std::vector<hardware_interface::CommandInterface> exported;
    exported.emplace_back(name, joint_ + "/velocity", &this->reference_interfaces_[0]);
    exported.emplace_back(name, joint_ + "/effort", &this->reference_interfaces_[1]);
    exported.emplace_back(name, joint_ + "/velocity_correction", &this->reference_interfaces_[2]);
    for (std::size_t place = plain_references; place < reference_count; place++) {
      const std::string number = std::to_string(place - plain_references + 1);
      exported.emplace_back(name, joint_ + "/regressor_" + number, &this->reference_interfaces_[place]);
    }
    return exported;
  }

  return_type update_reference_from_subscribers(const rclcpp::Time &, const rclcpp::Duration &) override
  {
    return return_type::OK;  // it has no topics: a trajectory controller before it writes the references
  }

  return_type update_and_write_commands(const rclcpp::Time &, const rclcpp::Duration & period) override
  {
    auto inputs = Axis::default_inputs();  // no preview: the controller does without
    inputs.reference = this->reference_interfaces_[0];
    inputs.feedforward = this->reference_interfaces_[1];
    const double correction = this->reference_interfaces_[2];
    inputs.correction = std::isfinite(correction) ? correction : 0.0;  // NaN where nobody has set it
    inputs.velocity = this->state_interfaces_[0].get_value();  // NaN where the reading failed: that is allowed
    if (use_position_) {
      inputs.position = this->state_interfaces_[2].get_value();  // gravity is identified; NaN holds the last one
    }
    // The measured effort is noisy where it is a current; what was commanded, limited, serves where there is none.
    const double effort = this->state_interfaces_[1].get_value();
    inputs.realised_torque = std::isfinite(effort) ? effort : last_torque_;
    inputs.dt = period.seconds();
    if (!take_regressors()) {
      return return_type::ERROR;  // one is far too large for what is of the size of one; the last command stays
    }
    typename Axis::Output output;
    if (Axis::step(&controller_, &inputs, &output) != 0) {
      return return_type::ERROR;  // a reference is not finite, or no time has passed; the last command stays
    }
    last_torque_ = std::fmin(std::fmax(output.torque, -limit_), limit_);
    this->command_interfaces_[0].set_value(last_torque_);
    return return_type::OK;
  }

private:
  static constexpr std::size_t plain_references = 3;
  static constexpr std::size_t reference_count = plain_references + Axis::regressors;

  void begin_references()
  {
    this->reference_interfaces_.assign(plain_references, 0.0);
    this->reference_interfaces_.resize(reference_count, std::numeric_limits<double>::quiet_NaN());  // the last ones hold
  }

  bool take_regressors()
  {
    if constexpr (Axis::regressors > 0) {
      typename Axis::Real values[Axis::regressors];
      for (std::size_t place = 0; place < Axis::regressors; place++) {
        values[place] = static_cast<typename Axis::Real>(this->reference_interfaces_[plain_references + place]);
      }
      return Axis::set_regressors(&controller_, values) == 0;
    }
    return true;
  }

  typename Axis::Controller controller_{};
  std::string joint_, state_file_;
  bool use_position_ = false;
  bool used_ = false;  // whether the state is that of a motion
  double limit_ = std::numeric_limits<double>::infinity();
  double last_torque_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace friction_compensation
