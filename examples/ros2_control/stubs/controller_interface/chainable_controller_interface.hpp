// Stub of what the example uses of ros2_control (Jazzy), for compiling and running it without ROS 2. Written from the
// documented interfaces: names and signatures only, none of the behaviour of the real classes.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace rclcpp
{
struct Time {};
class Duration
{
public:
  explicit Duration(double seconds) : seconds_(seconds) {}
  double seconds() const { return seconds_; }

private:
  double seconds_;
};
}  // namespace rclcpp

namespace rclcpp_lifecycle
{
struct State {};
class LifecycleNode
{
public:
  std::string name = "controller";
  std::map<std::string, std::string> texts;
  std::map<std::string, double> numbers;
  std::map<std::string, bool> flags;
  const char * get_name() const { return name.c_str(); }
};
}  // namespace rclcpp_lifecycle

namespace hardware_interface
{
class CommandInterface
{
public:
  CommandInterface(const std::string & prefix, const std::string & name, double * value)
  : name_(prefix + "/" + name), value_(value)
  {
  }
  const std::string & get_name() const { return name_; }
  void set_value(double value) { *value_ = value; }

private:
  std::string name_;
  double * value_;
};

class LoanedInterface
{
public:
  explicit LoanedInterface(double * value) : value_(value) {}
  double get_value() const { return *value_; }
  void set_value(double value) { *value_ = value; }

private:
  double * value_;
};
}  // namespace hardware_interface

namespace controller_interface
{
enum class CallbackReturn { SUCCESS, FAILURE, ERROR };
enum class return_type { OK, ERROR };
enum class interface_configuration_type { ALL, INDIVIDUAL, NONE };
struct InterfaceConfiguration
{
  interface_configuration_type type;
  std::vector<std::string> names;
};

class ChainableControllerInterface
{
public:
  virtual ~ChainableControllerInterface() = default;
  virtual CallbackReturn on_init() = 0;
  virtual InterfaceConfiguration command_interface_configuration() const = 0;
  virtual InterfaceConfiguration state_interface_configuration() const = 0;
  virtual CallbackReturn on_configure(const rclcpp_lifecycle::State &) = 0;
  virtual CallbackReturn on_activate(const rclcpp_lifecycle::State &) = 0;
  virtual CallbackReturn on_deactivate(const rclcpp_lifecycle::State &) = 0;

  std::shared_ptr<rclcpp_lifecycle::LifecycleNode> get_node() { return node_; }
  std::vector<hardware_interface::CommandInterface> export_reference_interfaces()
  {
    return on_export_reference_interfaces();
  }
  return_type update(const rclcpp::Time & time, const rclcpp::Duration & period)
  {
    const auto read = update_reference_from_subscribers(time, period);
    return read == return_type::OK ? update_and_write_commands(time, period) : read;
  }
  std::vector<hardware_interface::LoanedInterface> command_interfaces_, state_interfaces_;

protected:
  virtual std::vector<hardware_interface::CommandInterface> on_export_reference_interfaces() = 0;
  virtual return_type update_reference_from_subscribers(const rclcpp::Time &, const rclcpp::Duration &) = 0;
  virtual return_type update_and_write_commands(const rclcpp::Time &, const rclcpp::Duration &) = 0;

  template <class T>
  T auto_declare(const std::string & name, const T & fallback)
  {
    return given(name, fallback);
  }
  std::vector<double> reference_interfaces_;

private:
  std::string given(const std::string & name, const std::string & fallback)
  {
    return node_->texts.count(name) ? node_->texts[name] : fallback;
  }
  double given(const std::string & name, double fallback)
  {
    return node_->numbers.count(name) ? node_->numbers[name] : fallback;
  }
  bool given(const std::string & name, bool fallback)
  {
    return node_->flags.count(name) ? node_->flags[name] : fallback;
  }
  std::shared_ptr<rclcpp_lifecycle::LifecycleNode> node_ = std::make_shared<rclcpp_lifecycle::LifecycleNode>();
};
}  // namespace controller_interface
