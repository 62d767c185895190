/*
 * The closed loop of adaptive_ff/simulation/loop.py in C99, by hand, for speed comparison: joint, drive, PI loop and,
 * where asked for, feedforward from fixed parameters, with the same recorded series. What a run never uses is left out:
 * torque known from elsewhere, failed measurements, an unknown next reference, a computation delay, an offset.
 * Numbers of equations as in Python. The adaptive controller is not mirrored here.
 *
 * Constants come from the Python sources at compile time: MAXIMUM_ITERATIONS, RELATIVE_TOLERANCE.
 */

#include "closed_loop.h"

/* Friction (3) and its slope at a speed above zero. */
static double sliding_friction(const struct friction *f, double speed, double *slope) {
    double ratio = speed / f->stribeck_velocity;
    double decay = decay_of_stiction(speed, f->stribeck_velocity, f->stribeck_shape);
    double power;
    if (decay == 0.0)
        power = 0.0;
    else if (f->stribeck_shape == 1.0)
        power = 1.0;
    else if (f->stribeck_shape == 2.0)
        power = ratio;
    else
        power = pow(ratio, f->stribeck_shape - 1.0);
    *slope = f->viscous - (f->stiction - f->coulomb) * f->stribeck_shape * power * decay / f->stribeck_velocity;
    return f->coulomb + (f->stiction - f->coulomb) * decay + f->viscous * speed;
}

/* Solve x + kappa F(x) = free_speed by Newton's method inside a bracket. */
static double sliding_speed(const struct friction *f, double free_speed, double kappa, double guess) {
    double viscous_part = 1.0 + kappa * f->viscous;
    double low = (free_speed - kappa * f->stiction) / viscous_part;
    double high = (free_speed - kappa * f->coulomb) / viscous_part;
    double speed = least(most(guess, low), high);
    for (int i = 0; i < MAXIMUM_ITERATIONS; i++) {
        double slope;
        double residual = speed + kappa * sliding_friction(f, speed, &slope) - free_speed;
        if (residual > 0.0)
            high = speed;
        else
            low = speed;
        slope = 1.0 + kappa * slope;
        double candidate = slope > 0.0 ? speed - residual / slope : low;
        if (slope > 0.0 && fabs(candidate - speed) <= RELATIVE_TOLERANCE * free_speed)
            return least(most(candidate, low), high);
        if (candidate <= low || candidate >= high)
            candidate = 0.5 * (low + high);
        speed = candidate;
    }
    return speed;
}

/* One implicit Euler step of joint and friction lag (1). */
static void step_joint(const struct run *run, const struct friction *f, double *velocity, double *torque,
                       double drive) {
    double h = run->solver_period, denominator = run->friction_lag + h;
    double kappa = h * h / (run->inertia * denominator);
    double carried = run->friction_lag * *torque / denominator;
    double free_velocity = *velocity + h / run->inertia * (drive - carried);
    double next = 0.0;
    if (fabs(free_velocity) > kappa * f->stiction) {
        double speed = sliding_speed(f, fabs(free_velocity), kappa, fabs(*velocity));
        next = free_velocity > 0.0 ? speed : -speed;
    }
    *velocity = next;
    *torque = carried + h * ((free_velocity - next) / kappa) / denominator;
}

static struct friction friction_in_phase(const struct run *run, int64_t phase) {
    struct friction friction = run->friction;
    friction.coulomb *= run->scales[phase];
    friction.stiction *= run->scales[phase];
    friction.viscous *= run->scales[phase];
    return friction;
}

/* PI loop with back-calculation from the realised torque. */
static double step_pi(const struct run *run, struct pi *pi, double reference, double velocity, double realised,
                      double feedforward, double dt) {
    double error = reference - velocity;
    if (run->integral > 0.0 && pi->samples > 0) {
        double share = run->proportional <= 0.0 ? 1.0 : least(1.0, dt * run->integral / run->proportional);
        pi->integral += share * (realised - pi->command);
    }
    pi->integral += run->integral * dt * error;
    pi->samples++;
    return pi->command = run->proportional * error + pi->integral + feedforward;
}

static double model_friction(const struct model *m, double speed) {
    double share = decay_of_stiction(speed, m->friction.stribeck_velocity, m->friction.stribeck_shape);
    return m->friction.coulomb * (1.0 - share) + m->friction.stiction * share + m->friction.viscous * speed;
}

/* Integral of the lagged friction over a motion that does not reverse. */
static double one_way_friction(const struct model *m, double *friction, double start, double end, double duration) {
    double direction = start + end, first = 0.0, last = 0.0, lag = m->friction_lag;
    if (direction != 0.0) {
        first = copysign(model_friction(m, fabs(start)), direction);
        last = copysign(model_friction(m, fabs(end)), direction);
    }
    if (lag <= 0.0 || duration <= 0.0) {
        *friction = last;
        return 0.5 * (first + last) * duration;
    }
    double rate = (last - first) / duration, settled = -expm1(-duration / lag), gap = *friction - first;
    *friction = last + gap * (1.0 - settled) - rate * lag * settled;
    double integral = (first + 0.5 * rate * duration) * duration + gap * lag * settled;
    return integral + rate * lag * (lag * settled - duration);
}

/* Feedforward torque of the coming period. */
static double step_feedforward(const struct model *m, double period, double *friction, double reference, double next) {
    double integral;
    if (reference * next < 0.0) {
        double turn = period * reference / (reference - next);
        integral = one_way_friction(m, friction, reference, 0.0, turn);
        integral += one_way_friction(m, friction, 0.0, next, period - turn);
    } else {
        integral = one_way_friction(m, friction, reference, next, period);
    }
    return (m->inertia * (next - reference) + integral) / period;
}

void run_loop(const struct run *run) {
    struct friction friction = friction_in_phase(run, 0);
    struct pi pi = {0.0, 0.0, 0};
    double velocity = run->start_velocity, friction_torque = run->start_friction, realised = NAN;
    double modelled = 0.0; /* friction of the feedforward */
    int64_t phase = 0;
    for (int64_t k = 0; k < run->count; k++) {
        int64_t first = run->samples[k], last = run->samples[k + 1];
        int64_t previous = k > 0 ? run->samples[k - 1] : first - (last - first);
        double dt = (double)(first - previous) * run->solver_period;
        double measured = velocity + run->noise[k], feedforward = 0.0;
        run->velocity[first] = velocity;
        if (run->feeds)
            feedforward = step_feedforward(&run->model, run->period, &modelled, run->reference[first],
                                           run->reference[last]);
        double command = step_pi(run, &pi, run->reference[first], measured, realised, feedforward, dt);
        realised = least(most(command, -run->torque_limit), run->torque_limit);
        run->friction_torque[k] = friction_torque;
        run->measured[k] = measured;
        run->torque[k] = realised;
        run->feedforward[k] = feedforward;
        for (int64_t i = first; i < last; i++) {
            while (phase + 1 < run->phases && i >= run->starts[phase + 1])
                friction = friction_in_phase(run, ++phase);
            step_joint(run, &friction, &velocity, &friction_torque, realised);
            run->velocity[i + 1] = velocity;
        }
    }
}
