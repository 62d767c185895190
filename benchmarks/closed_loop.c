/*
 * The closed loop of adaptive_ff/simulation/loop.py in C99, by hand, for speed comparison: joint, drive, PI loop and,
 * where asked for, feedforward from fixed parameters, with the same recorded series. What a run never uses is left out:
 * torque known from elsewhere, failed measurements, an unknown next reference, a computation delay, an offset, gravity.
 * Numbers of equations as in Python. The adaptive controller is not mirrored here: with EXPORTED defined, the loop runs
 * the controller that adaptive-ff export wrote with the prefix "exported". What that controller watches itself by
 * (monitors) is recorded in Python alone, which costs C nothing.
 *
 * Constants come from the Python sources at compile time: MAXIMUM_ITERATIONS, RELATIVE_TOLERANCE, UPDATES,
 * LONGEST_UPDATE, ERROR_LEFT.
 */

#include "closed_loop.h"

#ifdef EXPORTED
#include "exported.h"
#endif

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

/* Constants of the step in a phase of friction. */
static struct ready ready_joint(const struct run *run, int64_t phase) {
    double h = run->solver_period, denominator = run->friction_lag + h, kappa = h * h / (run->inertia * denominator);
    struct ready r = {.friction = run->friction, .kappa = kappa};
    struct friction *f = &r.friction;
    f->coulomb *= run->scales[phase];
    f->stiction *= run->scales[phase];
    f->viscous *= run->scales[phase];
    r.breakaway = kappa * f->stiction;
    r.coulomb = kappa * f->coulomb;
    r.excess = kappa * (f->stiction - f->coulomb);
    r.linear = 1.0 + kappa * f->viscous;
    r.per_linear = 1.0 / r.linear;
    r.per_velocity = 1.0 / f->stribeck_velocity;
    r.gain = h / run->inertia;
    r.kept = run->friction_lag / denominator;
    r.taken = h / denominator;
    r.per_kappa = 1.0 / kappa;
    return r;
}

/* The same speed with one exponential, where the guess is good. */
static double speed_near(const struct ready *r, double free_speed, double friction_torque) {
    double low = (free_speed - r->breakaway) * r->per_linear, high = (free_speed - r->coulomb) * r->per_linear;
    double guess = least(most(free_speed - r->kappa * friction_torque, low), high);
    if (r->friction.stribeck_shape == 1.0) {
        double falling = r->excess * exp(-guess * r->per_velocity);
        double slope = r->linear - falling * r->per_velocity;
        double per_slope = slope > 0.0 ? 1.0 / slope : INFINITY;
        double residual = r->linear * guess + (r->coulomb - free_speed) + falling;
        double first = -residual * per_slope * r->per_velocity;
        if (fabs(first) < LONGEST_UPDATE) {
            double ratio = falling * r->per_velocity * per_slope;
            double allowed = ERROR_LEFT * free_speed * r->per_velocity, y = first;
            for (int i = 0; i < UPDATES; i++) {
                double square = y * y;
                double corrected = first - ratio * square * (0.5 - y * (1.0 / 6.0 - y * (1.0 / 24.0)));
                double left = ratio * fabs(y) * (fabs(corrected - y) + square * square);
                y = corrected;
                if (left <= allowed)
                    return least(most(guess + y * r->friction.stribeck_velocity, low), high);
            }
        }
    }
    return sliding_speed(&r->friction, free_speed, r->kappa, guess);
}

/* One implicit Euler step of joint and friction lag (1). */
static void step_joint(const struct ready *r, double *velocity, double *torque, double drive) {
    double carried = r->kept * *torque;
    double free_velocity = *velocity + r->gain * (drive - carried), next = 0.0;
    if (free_velocity > r->breakaway)
        next = speed_near(r, free_velocity, *torque);
    else if (free_velocity < -r->breakaway)
        next = -speed_near(r, -free_velocity, -*torque);
    *velocity = next;
    *torque = carried + r->taken * ((free_velocity - next) * r->per_kappa);
}

#ifdef EXPORTED
typedef exported_Controller controller;

static void start(controller *own) { exported_init(own); }

/* The controller that was exported to C, given what the loop in Python gives it. */
static double control(const struct run *run, controller *own, const struct sample *now, double *feedforward) {
    exported_Inputs inputs = exported_default_inputs();
    exported_Output output;
    inputs.reference = now->reference;
    inputs.velocity = now->measured;
    inputs.next_reference = now->next_reference;
    inputs.position = now->position;
    inputs.realised_torque = now->realised;
    inputs.dt = now->dt;
    if (exported_step(own, &inputs, &output) != EXPORTED_OK)
        return NAN;
    exported_estimates(own, run->estimates + EXPORTED_ESTIMATES * now->index);
    *feedforward = output.feedforward;
    return output.torque;
}
#else
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

#define HELD 0.87    /* share of the Coulomb friction that is held where the plan comes to rest */
#define FADING 0.32  /* time constant with which it fades, s */
#define TURNED 0.027 /* speed at which a reversed plan turns friction, over the change that breakaway makes in a period */
#define TOUCHED 1.35 /* path beyond zero for which it is not turned, over the way that breakaway moves the joint by */
#define STEEP 2.0    /* fall of friction, in gains, from which that path is shorter */
#define RISEN 1.5    /* speed up to which friction is held then, over the highest one that is expected */

/* Integral of the friction while the reference rests. */
static double resting_friction(const struct model *m, double *friction, double duration) {
    double bound = HELD * m->friction.coulomb, held = fmin(fmax(*friction, -bound), bound), excess = *friction - held;
    double faded = -expm1(-duration / FADING), integral = held * FADING * faded;
    *friction = held * (1.0 - faded);
    if (m->friction_lag > 0.0) {
        double settled = -expm1(-duration / m->friction_lag);
        integral += excess * m->friction_lag * settled;
        *friction += excess * (1.0 - settled);
    }
    return integral;
}

/* Integral of the lagged friction over a motion that does not reverse. */
static double one_way_friction(const struct model *m, double *friction, double start, double end, double duration,
                               double turned) {
    double direction = start + end, lag = m->friction_lag;
    int held = *friction * direction < 0.0 && fmax(fabs(start), fabs(end)) < turned;
    if (direction == 0.0 || held) {
        return resting_friction(m, friction, duration);
    }
    double first = copysign(model_friction(m, fabs(start)), direction);
    double last = copysign(model_friction(m, fabs(end)), direction);
    if (lag <= 0.0 || duration <= 0.0) {
        *friction = last;
        return 0.5 * (first + last) * duration;
    }
    double rate = (last - first) / duration, settled = -expm1(-duration / lag), gap = *friction - first;
    *friction = last + gap * (1.0 - settled) - rate * lag * settled;
    double integral = (first + 0.5 * rate * duration) * duration + gap * lag * settled;
    return integral + rate * lag * (lag * settled - duration);
}

/* What the feedforward remembers. */
struct feedforward {
    double friction, reference, turned;
    int started;
};

/* Speed up to which the friction of the last direction is held. */
static double held_speed(const struct run *run, const struct feedforward *own, double start, double end, double dt) {
    const struct model *m = &run->model;
    double step = end - start, bend = step - (start - own->reference) * run->period / dt;
    if (m->inertia <= 0.0)
        return 0.0;
    double throw = fmax(m->friction.coulomb, m->friction.stiction) / m->inertia * run->period, speed = TURNED * throw;
    if (!own->started)
        return speed;
    if (step * end <= 0.0)
        return fmax(speed, own->turned);
    if (step * bend >= 0.0)
        return speed;
    double fall = (m->friction.stiction - m->friction.coulomb) / m->friction.stribeck_velocity;
    double path = TOUCHED * throw * run->period, limit = STEEP * run->proportional;
    double slope = step + 0.5 * bend, highest = fabs(end) + 0.5 * slope * slope / fabs(bend);
    double expected = 4.0 / 3.0 * highest * sqrt(2.0 * highest / fabs(bend)) * run->period;
    return expected < (fall > limit ? path * limit / fall : path) ? fmax(speed, RISEN * highest) : speed;
}

/* Feedforward torque of the coming period. */
static double step_feedforward(const struct run *run, struct feedforward *own, double start, double end, double dt) {
    const struct model *m = &run->model;
    double integral, period = run->period, turned = held_speed(run, own, start, end, dt);
    if (start * end < 0.0) {
        double turn = period * start / (start - end);
        integral = one_way_friction(m, &own->friction, start, 0.0, turn, turned);
        integral += one_way_friction(m, &own->friction, 0.0, end, period - turn, turned);
    } else {
        integral = one_way_friction(m, &own->friction, start, end, period, turned);
    }
    own->reference = start, own->turned = turned, own->started = 1;
    return (m->inertia * (end - start) + integral) / period;
}

typedef struct {
    struct pi pi;
    struct feedforward feedforward;
} controller;

static void start(controller *own) { *own = (controller){{0.0, 0.0, 0}, {0.0, 0.0, 0.0, 0}}; }

/* The PI loop and, where asked for, the feedforward. */
static double control(const struct run *run, controller *own, const struct sample *now, double *feedforward) {
    if (run->feeds)
        *feedforward = step_feedforward(run, &own->feedforward, now->reference, now->next_reference, now->dt);
    return step_pi(run, &own->pi, now->reference, now->measured, now->realised, *feedforward, now->dt);
}
#endif

void run_loop(const struct run *run) {
    struct ready joint = ready_joint(run, 0);
    controller own;
    double velocity = run->start_velocity, friction_torque = run->start_friction, position = 0.0, realised = NAN;
    int64_t phase = 0;
    start(&own);
    for (int64_t k = 0; k < run->count; k++) {
        int64_t first = run->samples[k], last = run->samples[k + 1];
        int64_t previous = k > 0 ? run->samples[k - 1] : first - (last - first);
        struct sample now = {
            .index = k,
            .reference = run->reference[first],
            .next_reference = run->reference[last],
            .measured = velocity + run->noise[k],
            .position = run->position_step * floor(position / run->position_step + 0.5),
            .realised = realised,
            .dt = (double)(first - previous) * run->solver_period,
        };
        double feedforward = 0.0;
        run->velocity[first] = velocity;
        run->position[first] = position;
        double command = control(run, &own, &now, &feedforward);
        realised = least(most(command, -run->torque_limit), run->torque_limit);
        run->friction_torque[k] = friction_torque;
        run->measured[k] = now.measured;
        run->torque[k] = realised;
        run->feedforward[k] = feedforward;
        for (int64_t i = first; i < last; i++) {
            while (phase + 1 < run->phases && i >= run->starts[phase + 1])
                joint = ready_joint(run, ++phase);
            step_joint(&joint, &velocity, &friction_torque, realised);
            position += run->solver_period * velocity;
            run->velocity[i + 1] = velocity;
            run->position[i + 1] = position;
        }
    }
}
