/* The estimator of the C loop: filters, regressors, resetting least squares, jumps of friction. */

#include "closed_loop.h"

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
