"""Picture of an open-loop score."""

from pathlib import Path

from matplotlib import rc_context
from matplotlib.figure import Figure

from adaptive_ff.identify.score import Score
from adaptive_ff.report.drawing import (
    STYLE,
    Look,
    draw_series,
    explain_looks,
    label_above,
    make_panels,
    stamp,
    write_into,
)

MEASURED: Look = {"color": "#a6a6a6", "linewidth": 2.0, "label": "measured"}
SIMULATED: Look = {"color": "#d55e00", "linewidth": 1.0, "label": "simulated from the torque alone"}
ERROR: Look = {"color": "#0072b2", "linewidth": 1.0, "label": "simulated − measured"}


def plot_score(score: Score, folder: str | Path | None = None) -> dict[str, Figure]:
    """Draw measured and simulated position of the other log, and their difference below; ``score.png`` in a folder."""
    unit, small, factor = ("m", "mm", 1e3) if score.linear else ("rad", "mrad", 1e3)
    with rc_context(STYLE):
        figure, (whole, error) = make_panels(2, 5.2)
        draw_series(whole, score.time, score.measured, MEASURED)
        draw_series(whole, score.time, score.simulated, SIMULATED)
        draw_series(error, score.time, factor * (score.simulated - score.measured), ERROR)
        label_above(whole, f"position ({unit}) of {Path(score.tested).name}, trained on {Path(score.trained).name}")
        label_above(error, f"error ({small}), {factor * score.rms:.3g} rms")
        error.set_xlim(float(score.time[0]), float(score.time[-1]))
        error.set_xlabel("time (s)")
        explain_looks(figure, [MEASURED, SIMULATED, ERROR])
        stamp([figure], f"{score.tested}, trained on {score.trained}")
        write_into({"score": figure}, folder)
    return {"score": figure}


SAYS = {
    "follows": "the model follows the joint",
    "drifts": "the model drifts away from the joint within seconds, as open loop does where little holds a position",
    "does not follow": "the model does not follow the joint",
}
"""Verdicts in words."""


def score_lines(score: Score) -> list[str]:
    """Return what an open-loop score says, a sentence each."""
    unit = "mm" if score.linear else "mrad"
    whole, windows, moved, training, close = (
        f"{1e3 * value:.3g} {unit}"
        for value in (score.rms, score.windows, score.moved, score.training_rms, score.training_windows)
    )
    return [
        f"Open loop on {score.tested}: {whole} rms, fit {score.fit:.4g} %; in windows of 1 s "
        f"{windows} of the {moved} moved.",
        f"On the log that was identified: {training}; in windows {close}. Torque left on the other: "
        f"{100.0 * score.torque_left:.2g} %.",
        f"Verdict: {SAYS[score.grade]}.",
    ]
