// The functions of an exported header under names that are the same for every axis.
//
// FRICTION_COMPENSATION_AXIS_WITH_REGRESSORS is for a controller that was made for further known regressors: its header
// has PREFIX_REGRESSORS.
#pragma once

#include <cstddef>

#define FRICTION_COMPENSATION_AXIS(Name, prefix, PREFIX)                                                     \
  struct Name                                                                                                \
  {                                                                                                          \
    using Controller = prefix##_Controller;                                                                  \
    using Inputs = prefix##_Inputs;                                                                          \
    using Output = prefix##_Output;                                                                          \
    using Real = decltype(Inputs::reference);                                                                \
    static constexpr std::size_t regressors = 0;                                                             \
    static constexpr std::size_t state_size = PREFIX##_STATE_SIZE;                                           \
    static void init(Controller * c) { prefix##_init(c); }                                                   \
    static void restart(Controller * c) { prefix##_restart(c); }                                             \
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

#define FRICTION_COMPENSATION_AXIS_WITH_REGRESSORS(Name, prefix, PREFIX)                                     \
  FRICTION_COMPENSATION_AXIS(Name##Alone, prefix, PREFIX)                                                    \
  struct Name : Name##Alone                                                                                  \
  {                                                                                                          \
    static constexpr std::size_t regressors = PREFIX##_REGRESSORS;                                           \
    static int set_regressors(Controller * c, const Real * r) { return prefix##_set_regressors(c, r); }      \
  };
