"""Commands ``adaptive-ff excite`` and ``adaptive-ff commission``: a motion that identifies, and what it leads to."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import adaptive_ff
from adaptive_ff.cli.columns import chosen_columns
from adaptive_ff.cli.options import Limits, LogColumns, Output, ScenarioFile, TorqueDelay
from adaptive_ff.cli.output import bars, staged_results, warn, warn_of_skips
from adaptive_ff.errors import InputError

if TYPE_CHECKING:
    from adaptive_ff.identify.result import LogIdentification
    from adaptive_ff.logs.log import Log
    from adaptive_ff.scenario.scenario import Scenario
    from adaptive_ff.studies.motion import Excitation

GAINED = (
    "On the simulated joint: settled rms error {before:.3g} with the PI loop as given ({before_bandwidth:.3g} Hz), "
    "{best_pi:.3g} with the bandwidth that suits PI ({best_pi_bandwidth:.3g} Hz), {after:.3g} commissioned "
    "({after_bandwidth:.3g} Hz).",
    "On a real joint: run excitation.csv several times in a row under its own loop, record time, velocity and torque, "
    "and give the log with --log (and half a period as --torque-delay where the torque of a row acts over the coming "
    "period).",
)
"""What was gained on the simulated joint, and what to do on a real one."""

PERIOD = Annotated[float, typer.Option(help="Period of the exciting motion, s.")]


def excite_command(
    scenario: ScenarioFile = None,
    period: PERIOD = 10.0,
    fastest: float | None = None,  # largest frequency, Hz; 4 or 0.4 of the loop's bandwidth if not given
    limits: Limits = Limits(),  # noqa: B008 - the defaults of the options
    output: Output = Output(),  # noqa: B008
) -> None:
    """Find a motion that makes the parameters of a joint identifiable, within its limits. Takes minutes."""
    from adaptive_ff.report.study_pictures import plot_excitation
    from adaptive_ff.report.tables import motion_tables
    from adaptive_ff.scenario.file import to_toml
    from adaptive_ff.studies.exciting_motion import default_limits, exciting_motion

    loaded = adaptive_ff.load_scenario(scenario)
    linear = loaded.joint.axis == "linear"
    with staged_results(output) as results:
        chosen = default_limits(loaded, **vars(limits))
        with bars("motions") as done:
            motion = exciting_motion(
                loaded, chosen, period=period, fastest=fastest, workers=None, progress=done["motions"]
            )
        _write_motion(motion, loaded, results.stage)
        results.write(
            "excitation.json",
            motion.to_dict(),
            motion_tables(motion, linear=linear),
            {"excitation": plot_excitation(motion, linear=linear)},
            title=f"Exciting motion for {loaded.name}",
            details={"Scenario": to_toml(loaded)},
            source=loaded.name,
        )
        results.shown.append(
            f"excitation.csv, the table [reference] in excitation.toml, and the picture are in {output.out}"
        )


def _write_motion(motion: "Excitation", scenario: "Scenario", folder: Path) -> None:
    from adaptive_ff.files import write_csv
    from adaptive_ff.scenario.file import toml_text

    write_csv(folder / "excitation.csv", motion.columns(scenario.sampling.period))
    text = toml_text({"reference": motion.reference.model_dump()})
    (folder / "excitation.toml").write_text(text, encoding="utf-8")


def commission_command(
    scenario: ScenarioFile = None,
    # log of a real joint (CSV, NPZ, MAT, HDF5, Parquet or MCAP: time, position or velocity, torque or current) instead
    # of a simulated recording
    log: Path | None = None,
    columns: LogColumns = LogColumns(),  # noqa: B008
    torque_delay: TorqueDelay = None,
    period: PERIOD = 10.0,
    limits: Limits = Limits(),  # noqa: B008
    output: Output = Output(out=Path("commissioned")),  # noqa: B008
) -> None:
    """Excite, identify, tune and write the scenario, in one go: the recipe for a real joint. Takes minutes."""
    from adaptive_ff.files import write_csv
    from adaptive_ff.report.log_words import parameters_table, verdict_lines
    from adaptive_ff.report.study_pictures import plot_excitation
    from adaptive_ff.report.tables import best_table
    from adaptive_ff.scenario.file import to_toml
    from adaptive_ff.studies.commissioning import gain_on_the_true_joint, identified_scenario, record, tuned
    from adaptive_ff.studies.exciting_motion import default_limits

    loaded = adaptive_ff.load_scenario(scenario)
    linear = loaded.joint.axis == "linear"
    given, taken = _given(log, columns, torque_delay, linear=linear)
    with staged_results(output) as results:
        pictures, gain, stage = {}, None, results.stage
        with bars("motion", "bandwidth") as done:
            if given is None:
                chosen = default_limits(loaded, **vars(limits))
                motion, series = record(loaded, chosen, period=period, workers=None, progress=done["motion"])
                _write_motion(motion, loaded, stage)
                pictures["excitation"] = plot_excitation(motion, linear=linear)
                write_csv(stage / "log.csv", series)
                given = adaptive_ff.read_log(stage / "log.csv", time="time", velocity="velocity", torque="torque")
                torque_delay = 0.5 * loaded.sampling.period  # the torque of a row is held over the coming period
            found = adaptive_ff.identify_log(given, torque_delay=torque_delay, linear=linear)
            result, study = tuned(identified_scenario(loaded, found), workers=None, progress=done["bandwidth"])
            if log is None:
                gain = gain_on_the_true_joint(loaded, result, study)
        pictures |= found.plot(None) | {"tune": study.plot()}
        shown = [parameters_table(found), best_table(study), *taken, *verdict_lines(found)]
        shown += _taken_from(loaded.name, found) if gain is None else [text.format(**gain) for text in GAINED]
        (stage / "scenario.toml").write_text(to_toml(result), encoding="utf-8")
        summary = {
            "identification": found.to_dict(),
            "bandwidth": study.to_dict()["controllers"],
            "gain": gain,
            "scenario": result.model_dump(mode="json", exclude_none=True),
        }
        name = loaded.name if log is None else str(log)
        title, details = f"Commissioning of {name}", {"Scenario": to_toml(result)}
        results.write("commission.json", summary, shown, pictures, title=title, details=details, source=name)
        results.shown.append(
            f"scenario.toml, ready for compare and export, commission.json and the pictures are in {output.out}"
        )
    warn(found.cautions)
    warn_of_skips(found.data.skipped, "commission.json")


def _given(
    log: Path | None, given: LogColumns, torque_delay: float | None, *, linear: bool
) -> "tuple[Log | None, list[str]]":
    """Read the log that is given, if one is, and say which columns were taken."""
    if log is None:
        if any(value not in (None, []) for value in (*vars(given).values(), torque_delay)):
            raise InputError("columns, --scale, --torque-constant and --torque-delay are those of a --log; give one")
        return None, []
    chosen = chosen_columns(log, given.measured(), linear=linear, ending="-column", takes_current=False)
    return chosen.read(log), [chosen.sentence]


def _taken_from(source: str, found: "LogIdentification") -> list[str]:
    """Return what of the scenario is not from the log, and what of the log is not in the scenario."""
    from adaptive_ff.identify.scenario_text import left_out

    left = left_out(found)
    return [
        f"In scenario.toml sampling, drive, sensor and reference are those of {source}, not of the log; set them.",
        *([f"The log shows {' and '.join(left)} as well; the simulated joint does without."] if left else []),
    ]
