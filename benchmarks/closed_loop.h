/* What all parts of the C loop share: types, and the smallest functions. */

#ifndef CLOSED_LOOP_H
#define CLOSED_LOOP_H

#include <math.h>
#include <stdint.h>
#include <string.h>

enum { INERTIA, COULOMB, STICTION, VISCOUS, FRICTION_LAG, PARAMETERS, REGRESSORS };
enum { TORQUE, VELOCITY, SLIP, ADHESION, FILTERS };

struct friction {
    double coulomb, stiction, viscous, stribeck_velocity, stribeck_shape;
};

/* What a run is given and what it fills in; the layout is that of the ctypes structure in closed_loop.py. */
struct run {
    struct friction friction;
    double inertia, friction_lag, start_velocity, start_friction, solver_period, torque_limit;
    double proportional, integral;
    double pole, stribeck_velocity, stribeck_shape, torque_scale, largest_lag, memory, slowest, hold, period;
    int64_t adaptive, count, phases;
    const double *first, *scale;                               /* first estimate and unit of each parameter */
    const int64_t *starts;                                     /* first solver step of each phase of friction */
    const double *scales;                                      /* friction factor in it */
    const int64_t *samples;                                    /* solver step of each sample, and of the end */
    const double *reference, *noise;                           /* on the solver's grid; at the samples */
    double *velocity;                                          /* on the solver's grid */
    double *friction_torque, *measured, *torque, *feedforward; /* at the samples */
    double *estimates;                                         /* PARAMETERS a sample */
};

struct pi {
    double integral, command;
    int64_t samples;
};

struct signals {
    double filters[FILTERS][2], velocity;
};

struct estimator {
    double estimate[PARAMETERS];
    double information[PARAMETERS][PARAMETERS];
    double agreement[PARAMETERS][2]; /* fading means of z^2 and z x */
    double error, torque, speed;     /* mean squared prediction error; largest filtered torque and reference speed */
    double learnt;                   /* for how long there has been something to learn from */
    double surprise[2];              /* short means of error times predicted friction, and of the latter squared */
};

struct timing {
    double sensitivity, mean;              /* of the friction fed forward to its lag: as the period ends, and over it */
    double slope, integral, command;       /* what the loop makes of that: s of the error, integral, feedback */
    double information, weighted;          /* fading sums of s^2 and s (e + s lag), both over the level of the error */
    double energy, squares, cross, fourth; /* fading sums of s^2, s^2 e^2, s^3 e, s^4 */
    double since, lag;                     /* identified lag when the sums began; lag of the feedforward */
};

struct adaptive {
    struct signals measured, model;
    struct estimator estimator;
    struct timing timing;
    double sliding, model_torque, friction; /* friction: of the feedforward */
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
