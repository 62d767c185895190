"""Section IV-B: what rounding does to (13), evaluated as printed and in two ways that save work."""

from typing import NamedTuple

import numpy as np

from adaptive_ff.friction.model import model_friction
from adaptive_ff.learning.batch_least_squares import Array
from adaptive_ff.learning.rls import RLSState, initial_rls_state, update_rls_in_place
from adaptive_ff.simulation.metrics import rms
from benchmarks.cases.reports import Row
from benchmarks.paper.estimators import regression, rls_loop
from benchmarks.paper.experiment import Experiment, notes
from benchmarks.paper.records import PERIOD, SEED, TRUE, simulate_noise

FORGETTING_FACTOR = 0.99
COVARIANCE = 1e4
LARGEST = 1e100
LONG = 3600.0  # s of noise-driven motion
CHUNK = 100  # samples between looks at the covariance
STEADY_SPEED = 0.2  # rad/s
STEADY_NOISE = 0.002  # rad/s
STEADY = 60.0  # s of motion at constant speed
FORMS = PRINTED, ECONOMICAL, SYMMETRIC = (
    "(13) as printed, (I - gamma X') R",
    "(13) as R - gamma (R X)'",
    "(13), one triangle copied",
)


class History(NamedTuple):
    """What became of the covariance, a value every few samples, and the one-step errors of all samples, rad/s."""

    asymmetry: Array  # largest difference across the diagonal of the covariance, scaled to a unit diagonal
    smallest: Array  # smallest eigenvalue of its symmetric part, scaled alike
    errors: Array

    def indefinite(self) -> float:
        """Return the time after which the covariance was found indefinite, s; infinite where it never was."""
        found = np.flatnonzero(~(self.smallest > 0.0))
        return float((found[0] + 1) * CHUNK * PERIOD) if found.size else float("inf")


def update_rls(form: str, state: RLSState, regressors: Array, output: float, forgetting_factor: float) -> float:
    """Take one equation into account by (11), (12) and a form of (13); return the error."""
    if form == SYMMETRIC:
        return update_rls_in_place(state, regressors, output, forgetting_factor)
    estimate, covariance, gain = state
    projected = covariance @ regressors
    error = output - regressors @ estimate
    gain[:] = projected / (forgetting_factor + regressors @ projected)  # (12)
    estimate += gain * error  # (11)
    if form == PRINTED:
        kept = np.eye(gain.size) - np.outer(gain, regressors)
        covariance[:] = kept @ covariance / forgetting_factor  # (13)
    else:
        covariance[:] = (covariance - np.outer(gain, projected)) / forgetting_factor
    return float(error)


def watch(form: str, rows: Array, outputs: Array, covariance: float) -> History:
    """Run one form of the recursion and watch its covariance; stop where it has grown beyond all bounds."""
    size = rows.shape[1]
    state = initial_rls_state(np.zeros(size), covariance * np.eye(size))
    kept_matrices, errors = [], np.zeros(outputs.size)
    for start in range(0, outputs.size - CHUNK + 1, CHUNK):
        part = slice(start, start + CHUNK)
        if form == SYMMETRIC:
            room = np.empty((CHUNK, size))
            rls_loop(state, rows[part], outputs[part], FORGETTING_FACTOR, room, errors[part])
        else:
            pairs = zip(rows[part], outputs[part], strict=True)
            errors[part] = [update_rls(form, state, *pair, FORGETTING_FACTOR) for pair in pairs]
        kept_matrices.append(state.covariance.copy())
        if not np.max(np.abs(state.covariance)) < LARGEST:
            break
    matrices = np.array(kept_matrices)
    scale = np.sqrt(np.abs(np.diagonal(matrices, axis1=1, axis2=2)))
    scaled = matrices / (scale[:, :, np.newaxis] * scale[:, np.newaxis, :])
    turned = np.swapaxes(scaled, 1, 2)
    return History(
        np.max(np.abs(scaled - turned), axis=(1, 2)),
        np.linalg.eigvalsh(0.5 * (scaled + turned))[:, 0],
        errors[: CHUNK * len(kept_matrices)],
    )


def steady_motion() -> tuple[Array, Array]:
    """Return regressors and outputs of a motion at constant speed, with noise in its velocity, none in its torque."""
    count = round(STEADY / PERIOD)
    velocity = STEADY_SPEED + STEADY_NOISE * np.random.default_rng(SEED).standard_normal(count)
    return regression(velocity, np.full(count, model_friction(TRUE, STEADY_SPEED)))


def run() -> Experiment:
    """Run (13) in three forms for an hour of noise-driven motion and for a minute at constant speed."""
    data = simulate_noise(SEED, duration=LONG)
    histories = {form: watch(form, *regression(data.velocity, data.acting), COVARIANCE) for form in FORMS}
    rows = []
    for form, history in histories.items():
        broken = history.indefinite()
        largest = float(np.max(history.asymmetry))
        rows += [
            Row(f"{form}: largest asymmetry in {LONG:g} s of excitation, relative", largest),
            Row(f"{form}: indefinite", "never" if np.isinf(broken) else f"after {broken:g} s"),
            Row(f"{form}: one-step error, mrad/s rms", 1e3 * rms(history.errors)),
        ]
    growth = f"{ECONOMICAL}: growth of the asymmetry a sample; 1/lambda = {1.0 / FORGETTING_FACTOR:.5f}"
    rows.append(Row(growth, growth_per_sample(histories[ECONOMICAL])))
    for form in FORMS:
        broken = watch(form, *steady_motion(), COVARIANCE).indefinite()
        rows.append(Row(f"{form}, constant speed: indefinite after, s", broken))
    return Experiment(f"(13), section IV-B: rounding, lambda = {FORGETTING_FACTOR:g}", rows, notes("rounding"))


def growth_per_sample(history: History) -> float:
    """Return the factor by which the asymmetry grows a sample, while it is small."""
    small = np.flatnonzero(history.asymmetry > 1e-3)[0]
    values = np.log(history.asymmetry[:small])
    return float(np.exp(np.polyfit(CHUNK * np.arange(small), values, 1)[0]))
