/* What all parts of the C loop share: types, and the smallest functions. */

#ifndef CLOSED_LOOP_H
#define CLOSED_LOOP_H

#include <math.h>
#include <stdint.h>

struct friction {
    double coulomb, stiction, viscous, stribeck_velocity, stribeck_shape;
};

/* What the feedforward assumes of the joint; the fields of TorqueModel up to the shape, in another order. */
struct model {
    struct friction friction;
    double inertia, friction_lag;
};

/* What a run is given and what it fills in; the layout is that of the ctypes structure in speed_rivals.py. */
struct run {
    struct friction friction;
    double inertia, friction_lag, start_velocity, start_friction, solver_period, torque_limit, position_step;
    double proportional, integral;
    struct model model;
    double period;
    int64_t feeds, count, phases;
    const int64_t *starts;                                     /* first solver step of each phase of friction */
    const double *scales;                                      /* friction factor in it */
    const int64_t *samples;                                    /* solver step of each sample, and of the end */
    const double *reference, *noise;                           /* on the solver's grid; at the samples */
    double *velocity, *position;                               /* on the solver's grid */
    double *friction_torque, *measured, *torque, *feedforward; /* at the samples */
    double *estimates;                                         /* at the samples, of the exported controller */
};

/* A joint with the constants of its step; names as in plant/sliding.py and plant/step.py. */
struct ready {
    struct friction friction;
    double kappa, breakaway, coulomb, excess, linear, per_linear, per_velocity, gain, kept, taken, per_kappa;
};

/* What a controller is given at a sample. */
struct sample {
    int64_t index;
    double reference, next_reference, measured, position, realised, dt;
};

struct pi {
    double integral, command;
    int64_t samples;
};

static double decay_of_stiction(double speed, double stribeck_velocity, double shape) {
    double ratio = speed / stribeck_velocity;
    if (shape == 1.0)
        return exp(-ratio);
    if (shape == 2.0)
        return exp(-ratio * ratio);
    if (ratio > 1.0 && shape * log(ratio) > 7.0)
        return 0.0;
    return exp(-pow(ratio, shape));
}

static double least(double a, double b) { return b < a ? b : a; }

static double most(double a, double b) { return b > a ? b : a; }

#endif
