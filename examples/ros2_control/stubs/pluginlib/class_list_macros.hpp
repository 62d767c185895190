// Stub, for compiling without ROS 2: registers nothing, but checks that the class has the base.
#pragma once

#include <type_traits>

#define PLUGINLIB_EXPORT_CLASS(Class, Base) static_assert(std::is_base_of<Base, Class>::value, "not a plug-in");
