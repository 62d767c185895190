"""Command ``adaptive-ff replay``."""

from dataclasses import dataclass
from pathlib import Path

from adaptive_ff.cli.columns import chosen_columns
from adaptive_ff.cli.options import Linear, LogFile, MeasuredColumns, TorqueDelay, ViewerOutput
from adaptive_ff.cli.output import bars, staged_results, warn_of_skips
from adaptive_ff.errors import read_text

BAND = 20.0  # default of ``--band``; that of ``replay_log``, which the tests compare


@dataclass
class Learning:
    """Arguments of ``replay_log``."""

    inertia: float | None = None  # inertia that is assumed, kg m^2; learnt if not given
    stribeck_velocity: float | None = None  # Stribeck velocity that is assumed, rad/s
    memory: float | None = None  # memory, s of sliding motion; 5 if not given
    identify: str = "offset"  # what is learnt: symmetric, offset, directions, gravity or directions_and_gravity
    torque_delay: TorqueDelay = None
    bandwidth: float | None = None  # band in which the fixed model is fitted, Hz
    band: float = BAND  # band in which torques are judged, Hz
    linear: Linear = False


def replay_command(
    log: LogFile,
    columns: MeasuredColumns = MeasuredColumns(),  # noqa: B008 - the defaults of the options
    feedforward: str | None = None,  # column of the feedforward that the machine had, N m, to compare with
    learning: Learning = Learning(),  # noqa: B008
    # period of a torque over the position that is learnt, rad. May be given several times
    ripple_period: list[float] | None = None,
    state: Path | None = None,  # state to start from, as --save-state wrote it
    save_state: Path | None = None,  # write the state at the end there
    output: ViewerOutput = ViewerOutput(),  # noqa: B008
) -> None:
    """Replay a recorded log, and show which torque adaptive feedforward would have left to the feedback."""
    from adaptive_ff.replay.learning import learn_in_place
    from adaptive_ff.replay.replay import FEEDFORWARD, replay_log
    from adaptive_ff.report.log_words import left_table, replay_lines

    extra = {} if feedforward is None else {FEEDFORWARD: feedforward}
    taken = chosen_columns(log, columns, linear=learning.linear, further=extra)
    given = taken.read(log, extra)
    saved, ripples = None if state is None else read_text(state, "cannot be read"), tuple(ripple_period or ())
    with staged_results(output, save_state) as results:
        with bars(loop=learn_in_place):
            found = replay_log(
                given, ripple_periods=ripples, state=saved, is_current=taken.is_current, **vars(learning)
            )
        shown = [left_table(found), *replay_lines(found.verdict), taken.sentence, *found.notes]
        for name, estimates in found.estimates.items():
            values = ", ".join(f"{key} {value:.4g} {found.units[key]}" for key, value in estimates.items())
            shown.append(f"Estimates at the end, {name}: {values}")
        result = {**found.to_dict(), "columns": taken.columns}
        results.write("replay.json", result, shown, found.plot(None), title=f"Replay of {log}", series=found)
        if save_state is not None:
            results.beside[save_state].write_text(found.state_to_json(), encoding="utf-8")
        results.shown.append(f"Plots and replay.json are in {output.out}")
    warn_of_skips(found.data.skipped, "replay.json")
