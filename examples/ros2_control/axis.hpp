// The functions of an exported header under names that are the same for every axis.
#pragma once

#include <cstddef>

#define FRICTION_COMPENSATION_AXIS(Name, prefix, PREFIX)                                                     \
  struct Name                                                                                                \
  {                                                                                                          \
    using Controller = prefix##_Controller;                                                                  \
    using Inputs = prefix##_Inputs;                                                                          \
    using Output = prefix##_Output;                                                                          \
    static constexpr std::size_t state_size = PREFIX##_STATE_SIZE;                                           \
    static void init(Controller * c) { prefix##_init(c); }                                                   \
    static Inputs default_inputs() { return prefix##_default_inputs(); }                                     \
    static int step(Controller * c, const Inputs * i, Output * o) { return prefix##_step(c, i, o); }         \
    static int save_state(const Controller * c, unsigned char * b, std::size_t n)                            \
    {                                                                                                        \
      return prefix##_save_state(c, b, n);                                                                   \
    }                                                                                                        \
    static int load_state(Controller * c, const unsigned char * b, std::size_t n)                            \
    {                                                                                                        \
      return prefix##_load_state(c, b, n);                                                                   \
    }                                                                                                        \
  };
