/*
 * The closed loop of adaptive_ff/loop.py in C99, for speed comparison: joint, drive, PI loop and, where asked for, the
 * adaptive controller, with the same recorded series. What a run never uses is left out: torque known from elsewhere,
 * failed measurements, an unknown next reference, a computation delay, a lag of the measured velocity, an offset,
 * switching the adaptation or the tuning of the lag off. Numbers of equations as in Python.
 *
 * Constants come from the Python sources at compile time: MAXIMUM_ITERATIONS, RELATIVE_TOLERANCE, INERTIA_RANGE, FLOOR,
 * SMALLEST_FLOOR, LARGEST_FLOOR, PRIOR, LAG_PRIOR, GUESS, LEAST_AGREEMENT, MOST_AGREEMENT, EXCITED,
 * PEAK_FACTOR, SPEED_FACTOR, JUMP, JUMP_WINDOW, LEAST_ERROR, DISBELIEF, LONGEST, GROWTH, FIRST, CLIP, LEAST_LEFT,
 * LEAST_SUM, MOVED, YOUNG, LARGEST_SLOPE.
 */

#include "closed_loop.h"
#include "closed_loop_estimator.h"

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

static double model_friction(const struct run *run, const double model[PARAMETERS], double speed) {
    double share = decay_of_stiction(speed, run->stribeck_velocity, run->stribeck_shape);
    return model[COULOMB] * (1.0 - share) + model[STICTION] * share + model[VISCOUS] * speed;
}

/* Integral of the lagged friction over a motion that does not reverse. */
static double one_way_friction(const struct run *run, const double model[PARAMETERS], double *friction, double start,
                               double end, double duration) {
    double direction = start + end, first = 0.0, last = 0.0, lag = model[FRICTION_LAG];
    if (direction != 0.0) {
        first = copysign(model_friction(run, model, fabs(start)), direction);
        last = copysign(model_friction(run, model, fabs(end)), direction);
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
static double step_feedforward(const struct run *run, const double model[PARAMETERS], double *friction,
                               double reference, double next) {
    double period = run->period, integral;
    if (reference * next < 0.0) {
        double turn = period * reference / (reference - next);
        integral = one_way_friction(run, model, friction, reference, 0.0, turn);
        integral += one_way_friction(run, model, friction, 0.0, next, period - turn);
    } else {
        integral = one_way_friction(run, model, friction, reference, next, period);
    }
    return (model[INERTIA] * (next - reference) + integral) / period;
}

/* Mean over a period of a constant torque behind a low-pass, whose output moves on to the end of the period. */
static double lag_torque(double lag, double *lagged, double torque, double duration) {
    if (lag <= 0.0)
        return *lagged = torque;
    double share = -expm1(-duration / lag), gap = *lagged - torque;
    *lagged = torque + gap * (1.0 - share);
    return torque + gap * share * lag / duration;
}

/* Advance the loop's response to a change of the feedforward's lag over the period that has ended. */
static void advance_response(const struct run *run, struct timing *t, double duration) {
    t->slope += duration / run->first[INERTIA] * (t->mean - t->command);
    t->integral += run->integral * duration * t->slope;
    t->command = run->proportional * t->slope + t->integral;
    if (!(fabs(t->command) < LARGEST_SLOPE * run->proportional))
        t->slope = t->integral = t->command = 0.0;
}

/* Take the tracking error at one sample into account. */
static void learn_timing(const struct run *run, struct timing *t, double error, double learnt, double duration) {
    double square = t->slope * t->slope, keep = exp(-duration / run->memory);
    t->energy = keep * t->energy + square;
    t->squares = keep * t->squares + square * error * error;
    t->cross = keep * t->cross + square * t->slope * error;
    t->fourth = keep * t->fourth + square * square;
    keep = exp(-duration / least(LONGEST * run->memory, GROWTH * learnt));
    t->information *= keep;
    t->weighted *= keep;
    if (!(t->squares > LEAST_SUM && t->fourth > LEAST_SUM))
        return;
    double limit = CLIP * sqrt(t->squares / t->energy);
    double left = t->squares - t->cross * t->cross / t->fourth;
    double weight = t->energy / most(left, LEAST_LEFT * t->squares);
    t->information += weight * square;
    t->weighted += weight * t->slope * (least(most(error, -limit), limit) + t->slope * t->lag);
}

static void tune_lag(const struct run *run, struct adaptive *a, double error, double duration) {
    const struct estimator *e = &a->estimator;
    advance_response(run, &a->timing, duration);
    if (fabs(error) < SPEED_FACTOR * e->speed && e->learnt > FIRST * run->memory)
        learn_timing(run, &a->timing, error, e->learnt, duration);
}

/* Lag of the feedforward that the errors so far ask for. */
static double best_lag(const struct run *run, struct timing *t, double identified, int young) {
    if (t->energy == 0.0 || (young && fabs(identified - t->since) > MOVED * t->since + run->period)) {
        t->information = t->weighted = t->energy = t->squares = t->cross = t->fourth = 0.0;
        t->since = identified;
    }
    double root = DISBELIEF * run->period, believed = 1.0 / (root * root);
    double correction = t->weighted - t->information * identified;
    return least(most(identified + correction / (t->information + believed), 0.0), run->largest_lag);
}

static void write_model(const struct adaptive *a, double model[PARAMETERS]) {
    memcpy(model, a->estimator.estimate, sizeof a->estimator.estimate);
    model[STICTION] = most(model[STICTION], model[COULOMB]);
    model[FRICTION_LAG] = a->timing.lag;
}

/* Learn; what the new model adds to the feedforward is taken out of the integral. Return the feedforward. */
static double learn_bumpless(const struct run *run, struct adaptive *a, struct pi *pi, double reference,
                             double next_reference, double dt, int learns, double model[PARAMETERS]) {
    double friction = a->friction, speed = fabs(reference), old = model_friction(run, model, speed);
    double before = step_feedforward(run, model, &friction, reference, next_reference);
    if (learns)
        learn(run, &a->estimator, &a->measured, &a->model, dt);
    else
        guess_friction(&a->estimator, &a->measured, &a->model);
    int young = a->estimator.learnt < YOUNG * run->memory;
    a->timing.lag = best_lag(run, &a->timing, a->estimator.estimate[FRICTION_LAG], young);
    write_model(a, model);
    if (reference != 0.0)
        a->friction += copysign(1.0, reference) * (model_friction(run, model, speed) - old);
    double after = step_feedforward(run, model, &a->friction, reference, next_reference);
    if (run->integral > 0.0)
        pi->integral -= after - before;
    return after;
}

/* Learn from the period that ends and return the feedforward of the one that begins. */
static double step_adaptive(const struct run *run, struct adaptive *a, struct pi *pi, double reference,
                            double velocity, double next_reference, double realised, double dt, double *model) {
    if (pi->samples == 0) {
        realised = pi->command;
        settle_signals(run, &a->measured, velocity);
        settle_signals(run, &a->model, reference);
    }
    advance_signals(run, &a->measured, realised, velocity, dt);
    advance_signals(run, &a->model, a->model_torque, reference, dt);
    a->sliding = fabs(velocity) >= run->slowest && velocity * reference > 0.0 ? a->sliding + dt : 0.0;
    int learns = a->sliding > run->hold;
    double start = a->friction, period = run->period;
    struct timing *t = &a->timing;
    tune_lag(run, a, reference - velocity, dt);
    write_model(a, model);
    if (learns || !(a->estimator.learnt > 0.0))
        a->model_torque = learn_bumpless(run, a, pi, reference, next_reference, dt, learns, model);
    else
        a->model_torque = step_feedforward(run, model, &a->friction, reference, next_reference);
    t->mean = lag_torque(t->lag, &t->sensitivity, (start - a->friction) / period, period);
    model[FRICTION_LAG] = a->estimator.estimate[FRICTION_LAG]; /* recorded as identified */
    return a->model_torque;
}

static void start_adaptive(const struct run *run, struct adaptive *a) {
    memset(a, 0, sizeof *a);
    memcpy(a->estimator.estimate, run->first, sizeof a->estimator.estimate);
    for (int i = 0; i < PARAMETERS; i++)
        a->estimator.information[i][i] = i == FRICTION_LAG ? PRIOR * LAG_PRIOR : PRIOR;
    a->timing.lag = a->timing.since = run->first[FRICTION_LAG];
    a->sliding = -run->hold;
}

void run_loop(const struct run *run) {
    struct friction friction = friction_in_phase(run, 0);
    struct adaptive adaptive;
    struct pi pi = {0.0, 0.0, 0};
    double velocity = run->start_velocity, friction_torque = run->start_friction, realised = NAN;
    int64_t phase = 0;
    if (run->adaptive)
        start_adaptive(run, &adaptive);
    for (int64_t k = 0; k < run->count; k++) {
        int64_t first = run->samples[k], last = run->samples[k + 1];
        int64_t previous = k > 0 ? run->samples[k - 1] : first - (last - first);
        double dt = (double)(first - previous) * run->solver_period;
        double measured = velocity + run->noise[k], feedforward = 0.0;
        run->velocity[first] = velocity;
        if (run->adaptive)
            feedforward = step_adaptive(run, &adaptive, &pi, run->reference[first], measured, run->reference[last],
                                        realised, dt, run->estimates + PARAMETERS * k);
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
