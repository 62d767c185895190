"""Section III, Fig. 3: what the friction sign of ``w(k-1)`` costs at motion reversal, against reversal speed.

The joint of Fig. 4 is driven by noise of one rms and several corner frequencies: the lower, the slower its reversals.
"""

from adaptive_ff.learning.batch_least_squares import fit_least_squares
from benchmarks.paper.data import CORNER, SEED, simulate_noise
from benchmarks.paper.experiment import Experiment, Row
from benchmarks.paper.figures import figure_03
from benchmarks.paper.identification import FIRST, series, series_one_step
from benchmarks.paper.reversal_errors import Reversals, kinds_of, measure, old_sign_error, shares_of, with_current_sign

CORNERS = (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)  # Hz
DURATION = 300.0  # s


def run() -> Experiment:
    """Measure the errors at reversal against reversal speed."""
    data = simulate_noise(SEED)
    sliding = series(data.velocity, data.acting, sliding=True)
    rows, outputs = with_current_sign(data.velocity, data.acting)
    used = sliding.used[FIRST:]
    current = fit_least_squares(rows[used], outputs[used]).values
    records = {corner: simulate_noise(SEED, duration=DURATION, corner=corner) for corner in CORNERS}
    found = [measure(record, sliding.regression.values, current) for record in records.values()]
    plain = series(data.velocity, data.acting, sliding=False).regression.values
    shares = shares_of(series_one_step(plain, data.velocity, data.acting)[FIRST:], kinds_of(data.velocity))
    table = [
        *share_rows(found),
        Row("the paper's fit to Fig. 4: share of the squared one-step error, %", in_words(shares)),
        *size_rows(found),
    ]
    figure = figure_03(records[CORNER], found)
    return Experiment("Fig. 3, section III: sign of friction at reversal", table, list(NOTES), {"figure_03": figure})


def share_rows(found: list[Reversals]) -> list[Row]:
    """Return how the squared error is shared, for each reversal speed."""
    rows = []
    for corner, reversals in zip(CORNERS, found, strict=True):
        name = f"reversals at {reversals.speed:.1f} rad/s^2 (noise to {corner:g} Hz)"
        rows.append(Row(f"{name}: their share of the squared error, %", 100.0 * reversals.shares["reversal"]))
        rows.append(Row(f"{name}: their share of the samples, %", 100.0 * reversals.counts["reversal"]))
        rest = {kind: share for kind, share in reversals.shares.items() if kind != "reversal"}
        rows.append(Row(f"{name}: the rest of the error, %", in_words(rest)))
    return rows


def size_rows(found: list[Reversals]) -> list[Row]:
    """Return the size of the error on reversals, by predictor, over all reversal speeds."""
    sizes = {
        "(4)": [reversals.sizes["reversal"] for reversals in found],
        "(4) with the sign of w(k), not a predictor": [reversals.current_sign for reversals in found],
        "torque form, simulated": [reversals.form for reversals in found],
    }
    rows = [
        Row(f"{name}: one-step error on reversals, mrad/s rms, slowest to fastest", in_milli(values))
        for name, values in sizes.items()
    ]
    rows.append(
        Row("closed form: friction keeps the old sign to the end of the period, mrad/s rms", 1e3 * old_sign_error())
    )
    rows.append(Row("(4): one-step error while sliding, mrad/s rms", in_milli([r.sizes["sliding"] for r in found])))
    return rows


def in_milli(values: list[float]) -> str:
    """Return numbers times a thousand as a line of text."""
    return ", ".join(f"{1e3 * value:.3g}" for value in values)


def in_words(shares: dict[str, float]) -> str:
    """Return shares as a line of text, %."""
    return ", ".join(f"{name} {100.0 * share:.1f}" for name, share in shares.items())


NOTES = (
    "Agrees: the friction of w(k-1) has the wrong sign for one sample at each reversal, and that sample and the next "
    "are where sliding data contradict (4).",
    "Against the paper: the size of that error does not depend on the speed of reversal; it is about what friction of "
    "the old sign until the end of the period makes in closed form. What slow reversals bring is rest, where (4) "
    "knows no friction at all: there nearly all of the error lies.",
    "Against the paper: taking the sign of w(k), which it calls the normal case, would double the error at reversal, "
    "because friction lags: most of it still has the old sign.",
    "Around a slow reversal the velocity crosses zero several times before it rests (figure, right): with friction "
    "lag the dynamics does oscillate there, which section II-B denies.",
    "Errors of (4) are those of the fit to the sliding samples of Fig. 4, in which reversals have no say; the fit to "
    "all samples spreads them over the others.",
)
