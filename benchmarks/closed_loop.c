/*
 * The closed loop of adaptive_ff/loop.py in C99, for speed comparison: joint, drive, PI loop and, where asked for, the
 * adaptive controller, with the same recorded series. What a run never uses is left out: torque known from elsewhere,
 * failed measurements, an unknown next reference, a computation delay, a lag of the measured velocity, an offset,
 * switching the adaptation or the tuning of the lag off. Numbers of equations as in Python.
 *
 * Constants come from the Python sources at compile time: MAXIMUM_ITERATIONS, RELATIVE_TOLERANCE, INERTIA_RANGE, FLOOR,
 * SMALLEST_FLOOR, LARGEST_FLOOR, PRIOR, LAG_PRIOR, GUESS, LEAST_AGREEMENT, MOST_AGREEMENT, EXCITED,
 * PEAK_FACTOR, SPEED_FACTOR, JUMP, JUMP_WINDOW, LEAST_ERROR, DISBELIEF, LONGEST, GROWTH, FIRST, CLIP, LEAST_LEFT,
 * LEAST_SUM, LARGEST_SLOPE.
 */

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
    double lag;                            /* of the feedforward */
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

static double least(double a, double b) { return b < a ? b : a; }

static double most(double a, double b) { return b > a ? b : a; }

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

/* Advance one filter (p/(s + p))^2 over an input that is linear in time. */
static void advance_filter(double state[2], double pole, double decay, double start, double end, double duration) {
    double rate = (end - start) / duration;
    double offset = 2.0 * rate / pole;
    double value = state[0] - (start - offset);
    double slope = state[1] - rate;
    double step = pole * duration;
    state[0] = end - offset + decay * ((1.0 + step) * value + duration * slope);
    state[1] = rate + decay * (-pole * step * value + (1.0 - step) * slope);
}

static void advance_friction(const struct run *run, struct signals *s, double start, double end, double duration) {
    if (duration <= 0.0)
        return;
    double direction = start + end != 0.0 ? copysign(1.0, start + end) : 0.0;
    double first = decay_of_stiction(fabs(start), run->stribeck_velocity, run->stribeck_shape);
    double last = decay_of_stiction(fabs(end), run->stribeck_velocity, run->stribeck_shape);
    double decay = exp(-run->pole * duration);
    advance_filter(s->filters[SLIP], run->pole, decay, direction * (1.0 - first), direction * (1.0 - last), duration);
    advance_filter(s->filters[ADHESION], run->pole, decay, direction * first, direction * last, duration);
}

static void advance_signals(const struct run *run, struct signals *s, double torque, double velocity, double duration) {
    double start = s->velocity;
    double decay = exp(-run->pole * duration);
    advance_filter(s->filters[TORQUE], run->pole, decay, torque, torque, duration);
    advance_filter(s->filters[VELOCITY], run->pole, decay, start, velocity, duration);
    if (start * velocity < 0.0) {
        double turn = duration * start / (start - velocity);
        advance_friction(run, s, start, 0.0, turn);
        advance_friction(run, s, 0.0, velocity, duration - turn);
    } else {
        advance_friction(run, s, start, velocity, duration);
    }
    s->velocity = velocity;
}

static void settle_signals(const struct run *run, struct signals *s, double velocity) {
    double share = decay_of_stiction(fabs(velocity), run->stribeck_velocity, run->stribeck_shape);
    double direction = velocity != 0.0 ? copysign(1.0, velocity) : 0.0;
    s->velocity = s->filters[VELOCITY][0] = velocity;
    s->filters[SLIP][0] = direction * (1.0 - share);
    s->filters[ADHESION][0] = direction * share;
}

static double write_regressors(const struct run *run, const struct signals *s, double row[REGRESSORS]) {
    const double *velocity = s->filters[VELOCITY];
    row[0] = run->pole * run->pole * (s->velocity - velocity[0]) - 2.0 * run->pole * velocity[1];
    row[1] = velocity[1];
    row[2] = s->filters[SLIP][0];
    row[3] = s->filters[ADHESION][0];
    row[4] = velocity[0];
    row[5] = -s->filters[TORQUE][1];
    return s->filters[TORQUE][0];
}

/* Overwrite the lower triangle of a symmetric positive definite matrix by its Cholesky factor. */
static void factor_in_place(double matrix[PARAMETERS][PARAMETERS]) {
    for (int i = 0; i < PARAMETERS; i++) {
        for (int j = 0; j < i; j++) {
            double total = matrix[i][j];
            for (int k = 0; k < j; k++)
                total -= matrix[i][k] * matrix[j][k];
            matrix[i][j] = total / matrix[j][j];
        }
        double total = matrix[i][i];
        for (int k = 0; k < i; k++)
            total -= matrix[i][k] * matrix[i][k];
        matrix[i][i] = sqrt(total);
    }
}

static void solve_in_place(double factor[PARAMETERS][PARAMETERS], double vector[PARAMETERS]) {
    for (int i = 0; i < PARAMETERS; i++) {
        double total = vector[i];
        for (int k = 0; k < i; k++)
            total -= factor[i][k] * vector[k];
        vector[i] = total / factor[i][i];
    }
    for (int i = PARAMETERS - 1; i >= 0; i--) {
        double total = vector[i];
        for (int k = i + 1; k < PARAMETERS; k++)
            total -= factor[k][i] * vector[k];
        vector[i] = total / factor[i][i];
    }
}

/* Move one parameter by a distance, the others along with it so that the fit suffers least. */
static void move_parameter(double factor[PARAMETERS][PARAMETERS], int index, double distance,
                           double correction[PARAMETERS]) {
    double moves[PARAMETERS] = {0.0};
    moves[index] = 1.0;
    solve_in_place(factor, moves);
    double share = distance / moves[index];
    for (int i = 0; i < PARAMETERS; i++)
        correction[i] += share * moves[i];
}

/* Exponential resetting: take one equation into account. */
static void update_resetting(double information[PARAMETERS][PARAMETERS], double floor, double keep,
                             const double instrument[PARAMETERS], double error, double correction[PARAMETERS],
                             double factor[PARAMETERS][PARAMETERS]) {
    double gain = 1.0 - keep;
    for (int i = 0; i < PARAMETERS; i++) {
        for (int j = 0; j <= i; j++) {
            double entry = keep * information[i][j] + gain * instrument[i] * instrument[j];
            if (i == j)
                entry += gain * floor;
            information[i][j] = entry; /* the lower triangle is enough */
            factor[i][j] = entry;
        }
        correction[i] = gain * error * instrument[i];
    }
    factor_in_place(factor);
    solve_in_place(factor, correction);
}

/* A torque and the friction torque that an estimate predicts from a row of regressors. */
static double add_friction(double torque, const double estimate[PARAMETERS], const double row[REGRESSORS]) {
    for (int i = COULOMB; i < FRICTION_LAG; i++)
        torque += estimate[i] * row[i + 1];
    return torque;
}

static void write_gradient(const struct run *run, const double estimate[PARAMETERS], const double row[REGRESSORS],
                           double gradient[PARAMETERS]) {
    gradient[INERTIA] = row[1] + estimate[FRICTION_LAG] * row[0];
    for (int i = COULOMB; i < FRICTION_LAG; i++)
        gradient[i] = row[i + 1];
    gradient[FRICTION_LAG] = estimate[INERTIA] * row[0] + row[5];
    for (int i = 0; i < PARAMETERS; i++)
        gradient[i] *= run->scale[i] / run->torque_scale;
}

static int gradients_agree(double agreement[PARAMETERS][2], double model[PARAMETERS],
                           const double measured[PARAMETERS], double keep, double unexcited) {
    int alike = 1;
    for (int i = 0; i < PARAMETERS; i++) {
        agreement[i][0] = keep * agreement[i][0] + (1.0 - keep) * model[i] * model[i];
        agreement[i][1] = keep * agreement[i][1] + (1.0 - keep) * model[i] * measured[i];
        if (agreement[i][1] < LEAST_AGREEMENT * agreement[i][0] - unexcited
            || agreement[i][1] > MOST_AGREEMENT * agreement[i][0] + unexcited)
            alike = 0;
        if (agreement[i][0] < EXCITED * unexcited)
            model[i] = 0.0;
    }
    return alike;
}

/* The part of the mean squared error that a factor on friction explains, over a short window. */
static double note_surprise(double surprise[2], double friction, double error, double duration, double window) {
    double share = duration / (window + duration);
    surprise[0] += share * (friction * error - surprise[0]);
    surprise[1] += share * (friction * friction - surprise[1]);
    return surprise[1] > 0.0 ? surprise[0] * surprise[0] / surprise[1] : 0.0;
}

/* Reduce the information about a common factor on friction to what the short window tells. */
static void forget_friction(const struct run *run, struct estimator *e, double known) {
    double work[PARAMETERS] = {0.0}, total = 0.0;
    for (int i = 0; i < PARAMETERS; i++)
        for (int j = COULOMB; j < FRICTION_LAG; j++) {
            double entry = j <= i ? e->information[i][j] : e->information[j][i];
            work[i] += entry * (e->estimate[j] / run->scale[j]);
        }
    for (int i = COULOMB; i < FRICTION_LAG; i++)
        total += work[i] * (e->estimate[i] / run->scale[i]);
    if (!(total > known))
        return;
    double share = (1.0 - known / total) / total;
    for (int i = 0; i < PARAMETERS; i++)
        for (int j = 0; j <= i; j++)
            e->information[i][j] -= share * work[i] * work[j];
}

/* Add a scaled correction to the estimate; what would leave its bounds is moved back with the others adjusted. */
static void correct(const struct run *run, double estimate[PARAMETERS], double correction[PARAMETERS],
                    double factor[PARAMETERS][PARAMETERS], const double low[PARAMETERS],
                    const double high[PARAMETERS]) {
    for (int i = 0; i < PARAMETERS; i++) {
        double value = estimate[i] + correction[i] * run->scale[i];
        double possible = least(most(value, low[i]), high[i]);
        if (possible != value)
            move_parameter(factor, i, (possible - value) / run->scale[i], correction);
    }
    for (int i = 0; i < PARAMETERS; i++)
        estimate[i] = least(most(estimate[i] + correction[i] * run->scale[i], low[i]), high[i]);
}

/* Guess friction from the largest friction torque so far, before there is anything to learn. */
static void guess_friction(struct estimator *e, const struct signals *measured, const struct signals *model) {
    e->speed = most(e->speed, fabs(model->filters[VELOCITY][0]));
    if (!(fabs(measured->filters[VELOCITY][0]) < SPEED_FACTOR * e->speed))
        return;
    double torque = measured->filters[TORQUE][0];
    e->torque = most(e->torque, fabs(torque));
    double friction = torque - e->estimate[INERTIA] * measured->filters[VELOCITY][1];
    double guess = least(GUESS * copysign(friction, friction * model->velocity), PEAK_FACTOR * e->torque);
    if (guess > e->estimate[COULOMB])
        e->estimate[COULOMB] = e->estimate[STICTION] = guess;
}

/* Take one sample of sliding motion into account. */
static void learn(const struct run *run, struct estimator *e, const struct signals *measured,
                  const struct signals *model, double duration) {
    double row[REGRESSORS], gradient[PARAMETERS], instrument[PARAMETERS];
    double correction[PARAMETERS], factor[PARAMETERS][PARAMETERS];
    write_regressors(run, model, row);
    write_gradient(run, e->estimate, row, instrument);
    double torque = write_regressors(run, measured, row);
    write_gradient(run, e->estimate, row, gradient);
    e->speed = most(e->speed, fabs(model->filters[VELOCITY][0]));
    if (!(fabs(measured->filters[VELOCITY][0]) < SPEED_FACTOR * e->speed))
        return;
    e->torque = most(e->torque, fabs(torque));
    e->learnt += duration;
    double peak = PEAK_FACTOR * e->torque, largest = peak / run->torque_scale;
    double inertia = run->first[INERTIA], lag = e->estimate[FRICTION_LAG];
    double keep = exp(-duration / run->memory);
    double floor = least(FLOOR * e->error + SMALLEST_FLOOR, LARGEST_FLOOR);
    int alike = gradients_agree(e->agreement, instrument, gradient, keep, floor);
    double predicted = add_friction(e->estimate[INERTIA] * (row[1] + lag * row[0]) + lag * row[5], e->estimate, row);
    double error = least(most((torque - predicted) / run->torque_scale, -largest), largest);
    double squared = error * error, usual = JUMP * (e->error + LEAST_ERROR), window = JUMP_WINDOW / run->pole;
    double friction = add_friction(0.0, e->estimate, row) / run->torque_scale;
    double explained = note_surprise(e->surprise, friction, error, duration, window);
    if (e->learnt > run->memory && explained > usual) {
        squared = least(squared, usual); /* what a change of friction explains does not make errors usual */
        forget_friction(run, e, window / run->memory * e->surprise[1]);
    }
    e->error = keep * e->error + (1.0 - keep) * squared;
    update_resetting(e->information, floor, keep, alike ? instrument : gradient, error, correction, factor);
    double low[PARAMETERS] = {inertia / INERTIA_RANGE, 0.0, 0.0, 0.0, 0.0};
    double high[PARAMETERS] = {inertia * INERTIA_RANGE, peak, peak, peak / e->speed, run->largest_lag};
    correct(run, e->estimate, correction, factor, low, high);
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
static double best_lag(const struct run *run, const struct timing *t, double identified) {
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
    a->timing.lag = best_lag(run, &a->timing, a->estimator.estimate[FRICTION_LAG]);
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
    a->timing.lag = run->first[FRICTION_LAG];
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
