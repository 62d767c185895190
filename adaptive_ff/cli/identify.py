"""Commands on recorded logs: ``identify`` a joint, ``score`` its model on another log, ``replay`` the controller."""

import os
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import adaptive_ff
from adaptive_ff.cli.columns import chosen_columns
from adaptive_ff.cli.options import (
    Columns,
    Linear,
    LogFile,
    MeasuredColumns,
    Output,
    OverPosition,
    TorqueDelay,
    ViewerOutput,
    named_parts,
)
from adaptive_ff.cli.output import bars, error_console, progress_bars, staged_results, warn, warn_of_skips
from adaptive_ff.errors import InputError

if TYPE_CHECKING:
    from adaptive_ff.identify.result import LogIdentification

SCENARIO, REFERENCE = "scenario.toml", "reference.csv"  # files of the identified joint
BAND = 20.0  # default of ``--band``; that of ``replay_log``, which the tests compare


@dataclass
class Regression:
    """Arguments of ``identify_log``."""

    bandwidth: float | None = None  # band of the regression, Hz; chosen if not given
    held_out: float = 0.0  # fraction of the log, at its end, that is validated on instead of fitted
    torque_delay: TorqueDelay = None
    # terms: coulomb-viscous, symmetric, offset, directions, gravity or gravity-directions; auto takes gravity where it
    # takes torque. All but coulomb-viscous may be refined
    model: str = "auto"
    # friction may rise with the torque of --known-torque
    load_friction: Annotated[bool, typer.Option("--load-friction")] = False
    linear: Linear = False


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


def identify_command(
    log: LogFile,
    columns: MeasuredColumns = MeasuredColumns(),  # noqa: B008 - the defaults of the options
    # column of the motor's voltage, V, instead of a torque; of a PWM duty with --scale NAME=SUPPLY. Takes --resistance
    # and --torque-constant
    voltage: str | None = None,
    resistance: float | None = None,  # resistance of the motor, ohm, for --voltage
    validate: Path | None = None,  # another log, of the same columns, to validate on
    regression: Regression = Regression(),  # noqa: B008
    over_position: OverPosition = OverPosition(),  # noqa: B008
    write: str = "",  # files for simulators as well: mjcf, urdf, isaac, drake, or several: mjcf,urdf
    details: Annotated[bool, typer.Option("--details")] = False,  # also say how the numbers came about
    output: ViewerOutput = ViewerOutput(),  # noqa: B008
) -> None:
    """Identify inertia and friction of a joint from a recorded log."""
    from adaptive_ff.identify.simulators import ENDINGS
    from adaptive_ff.report.log_pictures import PICTURES
    from adaptive_ff.report.log_words import next_step

    simulators = named_parts(write, tuple(ENDINGS), "--write {name} is not known; allowed: {known}")
    constant, linear = columns.torque_constant, regression.linear
    taken = chosen_columns(log, columns, linear=linear, voltage=voltage, resistance=resistance)
    given, other = taken.read(log), None if validate is None else taken.read(validate)
    with staged_results(output) as results:
        with progress_bars(error_console()) as progress:
            progress.add_task("identify", total=None)
            found = adaptive_ff.identify_log(
                given, validation=other, is_current=taken.is_current, **vars(regression), **over_position.arguments()
            )
        refused, files = _write_scenario(found, results.stage), dict[str, str]()
        unwritten = [] if refused is None else [f"No scenario is written: {refused}{_left_behind(output.out)}"]
        try:
            files = {ENDINGS[name]: found.simulator(name) for name in simulators}
        except InputError as error:
            unwritten.append(f"No {', '.join(ENDINGS[name] for name in simulators)} is written: {error}")
        for name, text in files.items():
            (results.stage / name).write_text(text, encoding="utf-8")
        result = {**found.to_dict(), "columns": taken.columns, "scenario": SCENARIO if refused is None else None}
        page = {} if refused else {SCENARIO: (results.stage / SCENARIO).read_text(encoding="utf-8")}
        step = next_step(found, str(output.out), written=refused is None, simulated=bool(files))
        shown = _shown(found, taken.sentence, [*unwritten, step], details=details)
        title = f"Joint identified from {log}"
        results.write("identification.json", result, shown, found.plot(None), title=title, details=page, series=found)
        made = ["Plots", "identification.json", *([] if refused else [SCENARIO, REFERENCE])]
        results.shown.append(f"{', '.join([*made, *files])} are in {output.out}")
        results.left_behind(PICTURES, [])
    warn(
        [*found.cautions, *_of_voltage(constant, resistance, voltage, linear), *([] if refused else _of_current(found))]
    )
    warn_of_skips(found.data.skipped, "identification.json")


def _write_scenario(found: "LogIdentification", stage: Path) -> str | None:
    """Write the scenario and its reference; where it cannot be, say why."""
    from adaptive_ff.files import write_csv
    from adaptive_ff.identify.scenario_text import reference_columns, scenario_text

    files = stage / SCENARIO, stage / REFERENCE
    try:
        text = scenario_text(found, REFERENCE)
        files[0].write_text(text, encoding="utf-8")
        write_csv(files[1], reference_columns(found))
        with warnings.catch_warnings(action="ignore"):  # compare says them again
            adaptive_ff.load_scenario(files[0])
    except InputError as error:
        for file in files:
            file.unlink(missing_ok=True)
        return str(error).replace(str(stage) + os.sep, "")
    return None


def _shown(found: "LogIdentification", columns: str, sentences: list[str], *, details: bool) -> list[Any]:
    from adaptive_ff.report.log_words import details as explained
    from adaptive_ff.report.log_words import map_table, parameters_table, verdict_lines
    from adaptive_ff.report.tables import present

    tables = present(parameters_table(found), map_table(found))
    return [*tables, columns, *verdict_lines(found), *sentences, *(explained(found) if details else [])]


def _left_behind(out: Path) -> str:
    """Say that a scenario which is there already is none of this log; it stays, as it may have been edited."""
    there = [name for name in (SCENARIO, REFERENCE) if (out / name).exists()]
    if not there:
        return ""
    verb = "is" if len(there) == 1 else "are"
    return f". The {' and '.join(there)} in {out} {verb} of an earlier log, not of this one"


def _of_current(found: "LogIdentification") -> list[str]:
    """Warn that a scenario is in amperes where compare and simulate read newtons."""
    if found.units["torque"] != "A":
        return []
    torque = "N" if found.linear else "N m"
    return [
        f"the torque of the log is a current, so {SCENARIO} has A and {found.units['inertia']} where it says {torque} "
        f"and {'kg' if found.linear else 'kg m²'}; for these give --torque-constant, in {torque}/A"
    ]


def _of_voltage(constant: float | None, resistance: float | None, voltage: str | None, linear: bool) -> list[str]:
    """Say how much of the viscous coefficient is the back-EMF."""
    if voltage is None or constant is None or resistance is None:
        return []
    unit = "N s/m" if linear else "N m s/rad"
    return [f"the torque is that of a voltage: {constant**2 / resistance:.4g} {unit} of viscous are the back-EMF"]


def score_command(
    train: LogFile,
    test: Annotated[Path, typer.Argument(show_default=False)],  # another log of the joint, of the same columns
    columns: Columns = Columns(),  # noqa: B008
    torque_delay: TorqueDelay = None,
    over_position: OverPosition = OverPosition(),  # noqa: B008
    linear: Linear = False,
    output: Output = Output(),  # noqa: B008
) -> None:
    """Identify one log, and simulate another one with that model from its torque alone, in open loop."""
    from adaptive_ff.identify.score import score_log
    from adaptive_ff.report.log_words import parameters_table, score_lines

    taken = chosen_columns(train, columns, linear=linear)
    logs = [taken.read(path) for path in (train, test)]
    with staged_results(output) as results:
        score = score_log(*logs, linear=linear, torque_delay=torque_delay, **over_position.arguments())
        shown = [parameters_table(score.found), taken.sentence, *score_lines(score)]
        title, result = f"Model of {train}, simulated on {test}", {**score.to_dict(), "columns": taken.columns}
        results.write("score.json", result, shown, score.plot(None), title=title)
        results.shown.append(f"score.json and its picture are in {output.out}")
    warn(score.cautions)
    warn_of_skips(score.found.data.skipped, "score.json")


def replay_command(
    log: LogFile,
    columns: MeasuredColumns = MeasuredColumns(),  # noqa: B008
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
    given, ripples = taken.read(log, extra), tuple(ripple_period or ())
    with staged_results(output, save_state) as results:
        with bars(loop=learn_in_place):
            found = replay_log(
                given, ripple_periods=ripples, state=state, is_current=taken.is_current, **vars(learning)
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
