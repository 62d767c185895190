/*
 * The closed loop of adaptive_ff/loop.py in C99, for speed comparison: joint, drive, PI loop and, where asked for, the
 * adaptive controller, with the same recorded series. What a run never uses is left out: torque known from elsewhere,
 * switching the adaptation off. Equations carry the numbers of the Python sources.
 *
 * Constants come from the Python sources at compile time: MAXIMUM_ITERATIONS, RELATIVE_TOLERANCE, GATE_HOLD, FLOOR,
 * PRIOR, INERTIA_RANGE.
 */

#include <math.h>
#include <stdint.h>
#include <string.h>

enum { INERTIA, COULOMB, STICTION, VISCOUS, FRICTION_LAG, PARAMETERS };
enum { TORQUE, VELOCITY, SLIP, ADHESION, FILTERS };

struct friction {
    double coulomb, stiction, viscous, stribeck_velocity, stribeck_shape;
};

/* What a run is given and what it fills in; the layout is that of the ctypes structure in speed.py. */
struct run {
    struct friction friction;
    double inertia, friction_lag, start_velocity, start_friction, solver_period, torque_limit;
    double proportional, integral;
    double pole, stribeck_velocity, stribeck_shape, assumed_inertia, torque_scale, largest_lag, slowest, memory, period;
    int64_t adaptive, count, phases;
    const double *scale;                   /* unit of each parameter, PARAMETERS */
    const int64_t *starts;                 /* first solver step of each phase of friction */
    const double *scales;                  /* friction factor in it */
    const int64_t *samples;                /* solver step of each sample, and of the end */
    const double *reference;               /* on the solver's grid */
    const double *noise;                   /* at the samples */
    double *velocity;                      /* on the solver's grid */
    double *friction_torque, *measured, *torque, *feedforward; /* at the samples */
    double *estimates;                     /* PARAMETERS a sample */
};

struct joint {
    struct friction friction;
    double inertia, lag;
};

struct pi {
    double integral, velocity, command;
    int64_t samples, rejected;
};

struct signals {
    double filters[FILTERS][2];
    double velocity;
};

struct adaptive {
    struct signals measured, instrument;
    double estimate[PARAMETERS];
    double information[PARAMETERS][PARAMETERS];
    double sliding, model_torque;
    double friction, reference; /* of the feedforward */
    int started;
};

static double decay_of_stiction(double speed, double stribeck_velocity, double shape)
{
    double ratio = speed / stribeck_velocity;
    if (shape == 1.0)
        return exp(-ratio);
    if (shape == 2.0)
        return exp(-ratio * ratio);
    return exp(-pow(ratio, shape));
}

/* Friction (3) and its slope at a speed above zero. */
static double sliding_friction(const struct friction *f, double speed, double *slope)
{
    double ratio = speed / f->stribeck_velocity;
    double decay = decay_of_stiction(speed, f->stribeck_velocity, f->stribeck_shape);
    double power;
    if (f->stribeck_shape == 1.0)
        power = 1.0;
    else if (f->stribeck_shape == 2.0)
        power = ratio;
    else
        power = pow(ratio, f->stribeck_shape - 1.0);
    *slope = f->viscous - (f->stiction - f->coulomb) * f->stribeck_shape * power * decay / f->stribeck_velocity;
    return f->coulomb + (f->stiction - f->coulomb) * decay + f->viscous * speed;
}

static double least(double a, double b)
{
    return b < a ? b : a;
}

static double most(double a, double b)
{
    return b > a ? b : a;
}

/* Solve x + kappa F(x) = free_speed by Newton's method inside a bracket. */
static double sliding_speed(const struct friction *f, double free_speed, double kappa, double guess)
{
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
        if (fabs(candidate - speed) <= RELATIVE_TOLERANCE * free_speed)
            return least(most(candidate, low), high);
        if (candidate <= low || candidate >= high)
            candidate = 0.5 * (low + high);
        speed = candidate;
    }
    return speed;
}

/* One implicit Euler step of joint and friction lag (1). */
static void step_joint(const struct joint *joint, double *velocity, double *friction_torque, double torque, double h)
{
    double denominator = joint->lag + h;
    double kappa = h * h / (joint->inertia * denominator);
    double carried = joint->lag * *friction_torque / denominator;
    double free_velocity = *velocity + h / joint->inertia * (torque - carried);
    double next = 0.0;
    if (fabs(free_velocity) > kappa * joint->friction.stiction) {
        double speed = sliding_speed(&joint->friction, fabs(free_velocity), kappa, fabs(*velocity));
        next = free_velocity > 0.0 ? speed : -speed;
    }
    *velocity = next;
    *friction_torque = carried + h * ((free_velocity - next) / kappa) / denominator;
}

static struct joint joint_in_phase(const struct run *run, int64_t phase)
{
    struct joint joint = {run->friction, run->inertia, run->friction_lag};
    joint.friction.coulomb *= run->scales[phase];
    joint.friction.stiction *= run->scales[phase];
    joint.friction.viscous *= run->scales[phase];
    return joint;
}

/* PI loop with back-calculation from the realised torque. */
static double step_pi(const struct run *run, struct pi *pi, double reference, double measured, double realised,
                      double feedforward, double dt)
{
    int valid = isfinite(measured);
    double velocity = valid ? measured : pi->velocity;
    double error = reference - velocity;
    if (run->integral > 0.0 && pi->samples > 0 && isfinite(realised)) {
        double share = run->proportional <= 0.0 ? 1.0 : least(1.0, dt * run->integral / run->proportional);
        pi->integral += share * (realised - pi->command);
    }
    if (valid)
        pi->integral += run->integral * dt * error;
    else
        pi->rejected++;
    pi->velocity = velocity;
    pi->command = run->proportional * error + pi->integral + feedforward;
    pi->samples++;
    return pi->command;
}

/* Advance one filter (p/(s + p))^2 over an input that is linear in time. */
static void advance_filter(double state[2], double pole, double decay, double start, double end, double duration)
{
    double rate = (end - start) / duration;
    double offset = 2.0 * rate / pole;
    double value = state[0] - (start - offset);
    double slope = state[1] - rate;
    double step = pole * duration;
    state[0] = end - offset + decay * ((1.0 + step) * value + duration * slope);
    state[1] = rate + decay * (-pole * step * value + (1.0 - step) * slope);
}

static void advance_friction(const struct run *run, struct signals *s, double start, double end, double duration)
{
    if (duration <= 0.0)
        return;
    double direction = start + end != 0.0 ? copysign(1.0, start + end) : 0.0;
    double first = decay_of_stiction(fabs(start), run->stribeck_velocity, run->stribeck_shape);
    double last = decay_of_stiction(fabs(end), run->stribeck_velocity, run->stribeck_shape);
    double decay = exp(-run->pole * duration);
    advance_filter(s->filters[SLIP], run->pole, decay, direction * (1.0 - first), direction * (1.0 - last), duration);
    advance_filter(s->filters[ADHESION], run->pole, decay, direction * first, direction * last, duration);
}

static void advance_signals(const struct run *run, struct signals *s, double torque, double velocity, double duration)
{
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

static void settle_signals(const struct run *run, struct signals *s, double velocity)
{
    double share = decay_of_stiction(fabs(velocity), run->stribeck_velocity, run->stribeck_shape);
    double direction = velocity != 0.0 ? copysign(1.0, velocity) : 0.0;
    s->filters[VELOCITY][0] = velocity;
    s->filters[SLIP][0] = direction * (1.0 - share);
    s->filters[ADHESION][0] = direction * share;
    s->velocity = velocity;
}

static double write_regressors(const struct run *run, const struct signals *s, double row[PARAMETERS + 1])
{
    const double *velocity = s->filters[VELOCITY];
    row[0] = run->pole * run->pole * (s->velocity - velocity[0]) - 2.0 * run->pole * velocity[1];
    row[1] = velocity[1];
    row[2] = s->filters[SLIP][0];
    row[3] = s->filters[ADHESION][0];
    row[4] = velocity[0];
    row[5] = -s->filters[TORQUE][1];
    return s->filters[TORQUE][0];
}

/* Solve for a symmetric positive definite matrix by Cholesky's factors; both arguments are overwritten. */
static void solve_in_place(double matrix[PARAMETERS][PARAMETERS], double vector[PARAMETERS])
{
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
    for (int i = 0; i < PARAMETERS; i++) {
        double total = vector[i];
        for (int k = 0; k < i; k++)
            total -= matrix[i][k] * vector[k];
        vector[i] = total / matrix[i][i];
    }
    for (int i = PARAMETERS - 1; i >= 0; i--) {
        double total = vector[i];
        for (int k = i + 1; k < PARAMETERS; k++)
            total -= matrix[k][i] * vector[k];
        vector[i] = total / matrix[i][i];
    }
}

static void confine(const struct run *run, double estimate[PARAMETERS])
{
    double inertia = run->assumed_inertia;
    estimate[INERTIA] = least(most(estimate[INERTIA], inertia / INERTIA_RANGE), inertia * INERTIA_RANGE);
    estimate[COULOMB] = most(estimate[COULOMB], 0.0);
    estimate[STICTION] = most(estimate[STICTION], 0.0);
    estimate[VISCOUS] = most(estimate[VISCOUS], 0.0);
    estimate[FRICTION_LAG] = least(most(estimate[FRICTION_LAG], 0.0), run->largest_lag);
}

/* Correct the estimate by one equation of the regression: exponential resetting with an instrument. */
static void learn(const struct run *run, struct adaptive *a, double dt)
{
    double x[PARAMETERS + 1], z[PARAMETERS + 1], gradient[PARAMETERS], correction[PARAMETERS];
    double work[PARAMETERS][PARAMETERS];
    double torque = write_regressors(run, &a->measured, x);
    write_regressors(run, &a->instrument, z);
    double inertia = a->estimate[INERTIA], lag = a->estimate[FRICTION_LAG];
    double prediction = inertia * (x[1] + lag * x[0]) + lag * x[5];
    for (int i = 1; i < PARAMETERS - 1; i++)
        prediction += a->estimate[i] * x[i + 1];
    gradient[INERTIA] = z[1] + lag * z[0];
    for (int i = 1; i < PARAMETERS - 1; i++)
        gradient[i] = z[i + 1];
    gradient[FRICTION_LAG] = inertia * z[0] + z[5];
    for (int i = 0; i < PARAMETERS; i++)
        gradient[i] *= run->scale[i] / run->torque_scale;
    double error = (torque - prediction) / run->torque_scale;
    double keep = exp(-dt / run->memory), gain = 1.0 - keep;
    for (int i = 0; i < PARAMETERS; i++) {
        for (int j = 0; j <= i; j++) {
            double entry = keep * a->information[i][j] + gain * gradient[i] * gradient[j];
            if (i == j)
                entry += gain * FLOOR;
            a->information[i][j] = entry;
            work[i][j] = entry;
        }
        correction[i] = gain * error * gradient[i];
    }
    solve_in_place(work, correction);
    for (int i = 0; i < PARAMETERS; i++)
        a->estimate[i] += correction[i] * run->scale[i];
    confine(run, a->estimate);
}

static double model_friction(const struct run *run, const double model[PARAMETERS], double speed)
{
    double share = decay_of_stiction(speed, run->stribeck_velocity, run->stribeck_shape);
    return model[COULOMB] * (1.0 - share) + model[STICTION] * share + model[VISCOUS] * speed;
}

/* Integral of the lagged friction over a motion that does not reverse. */
static double one_way_friction(const struct run *run, const double model[PARAMETERS], double *friction, double start,
                               double end, double duration)
{
    double direction = start + end, first = 0.0, last = 0.0, lag = model[FRICTION_LAG];
    if (direction != 0.0) {
        first = copysign(model_friction(run, model, fabs(start)), direction);
        last = copysign(model_friction(run, model, fabs(end)), direction);
    }
    if (lag <= 0.0 || duration <= 0.0) {
        *friction = last;
        return 0.5 * (first + last) * duration;
    }
    double rate = (last - first) / duration;
    double transient = *friction - first + rate * lag;
    double decay = exp(-duration / lag);
    *friction = last - rate * lag + transient * decay;
    return (first - rate * lag) * duration + 0.5 * rate * duration * duration + transient * lag * (1.0 - decay);
}

/* Feedforward torque of the coming period. */
static double step_feedforward(const struct run *run, const double model[PARAMETERS], struct adaptive *a,
                               double reference, double next)
{
    double period = run->period, integral;
    if (!isfinite(next))
        next = a->started ? 2.0 * reference - a->reference : reference;
    if (reference * next < 0.0) {
        double turn = period * reference / (reference - next);
        integral = one_way_friction(run, model, &a->friction, reference, 0.0, turn);
        integral += one_way_friction(run, model, &a->friction, 0.0, next, period - turn);
    } else {
        integral = one_way_friction(run, model, &a->friction, reference, next, period);
    }
    a->reference = reference;
    a->started = 1;
    return (model[INERTIA] * (next - reference) + integral) / period;
}

/* Learn from the period that ends and return the feedforward of the one that begins. */
static double step_adaptive(const struct run *run, struct adaptive *a, const struct pi *pi, double reference,
                            double measured, double next_reference, double realised, double dt, double *row)
{
    int valid = isfinite(measured);
    double velocity = valid ? measured : pi->velocity;
    if (!isfinite(realised))
        realised = pi->command;
    if (pi->samples == 0) {
        settle_signals(run, &a->measured, velocity);
        settle_signals(run, &a->instrument, reference);
    }
    advance_signals(run, &a->measured, realised, velocity, dt);
    advance_signals(run, &a->instrument, a->model_torque, reference, dt);
    a->sliding = valid && fabs(velocity) >= run->slowest && velocity * reference > 0.0 ? a->sliding + dt : 0.0;
    if (a->sliding * run->pole > GATE_HOLD)
        learn(run, a, dt);
    memcpy(row, a->estimate, sizeof a->estimate);
    row[STICTION] = most(row[STICTION], row[COULOMB]);
    a->model_torque = step_feedforward(run, row, a, reference, next_reference);
    return a->model_torque;
}

static void start_adaptive(const struct run *run, struct adaptive *a)
{
    memset(a, 0, sizeof *a);
    a->estimate[INERTIA] = run->assumed_inertia;
    for (int i = 0; i < PARAMETERS; i++)
        a->information[i][i] = PRIOR / run->memory + FLOOR;
    a->sliding = -GATE_HOLD / run->pole;
}

void run_loop(const struct run *run)
{
    struct joint joint = joint_in_phase(run, 0);
    struct adaptive adaptive;
    struct pi pi = {0.0, 0.0, 0.0, 0, 0};
    double velocity = run->start_velocity, friction_torque = run->start_friction, realised = NAN;
    int64_t phase = 0;
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
            if (phase + 1 < run->phases && i >= run->starts[phase + 1])
                joint = joint_in_phase(run, ++phase);
            step_joint(&joint, &velocity, &friction_torque, realised, run->solver_period);
            run->velocity[i + 1] = velocity;
        }
    }
}
