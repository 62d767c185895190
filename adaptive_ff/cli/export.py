"""Commands that write files for elsewhere: ``new`` a scenario, ``export`` a controller as C, ``playground`` a page."""

import json
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import typer

import adaptive_ff
from adaptive_ff.cli.options import Common, ScenarioFile
from adaptive_ff.cli.output import Printer
from adaptive_ff.errors import InputError, read_text


class Side(StrEnum):
    """Where an encoder is."""

    MOTOR = "motor"
    JOINT = "joint"


def new_command(
    inertia: float = 20.0,  # inertia of motor and load at the joint, kg m^2 (linear: kg)
    torque: float = 400.0,  # rated torque at the joint, N m (linear: N)
    speed: float = 2.5,  # rated speed of the joint, rad/s (linear: m/s)
    rate: float = 1000.0,  # sampling frequency of the velocity controller, Hz
    # counts of an encoder in a turn, all edges (of a linear axis: in a metre), which then takes the place of a sensor
    # of velocity
    encoder: Annotated[float | None, typer.Option(metavar="COUNTS")] = None,
    encoder_side: Side = Side.JOINT,  # where it is: on the motor, before the gear, or on the joint
    velocity_cutoff: float | None = None,  # low-pass of the encoder's velocity, Hz; chosen by default
    gear_ratio: float | None = None,  # turns of the motor in one of the joint (linear: rad of the motor in a metre)
    delay: float = 0.0,  # delay from a sample to the torque of the drive, s
    linear: Annotated[bool, typer.Option("--linear")] = False,  # a linear axis: mass, force, m/s
) -> None:
    """Print a smallest complete scenario file, from the numbers of a data sheet: adaptive-ff new > joint.toml.

    The bandwidth of the velocity loop is chosen for sensor, friction and delay.
    """
    from adaptive_ff.scenario.new import LONGEST_PERIOD, SHORTEST_PERIOD, Encoder, new_scenario_text

    least, most = 1.0 / LONGEST_PERIOD, 1.0 / SHORTEST_PERIOD
    if not least < rate <= most:
        raise InputError(f"--rate = {rate:g} is not allowed: it must be above {least:g} Hz and at most {most:.3g} Hz")
    if encoder is None and (velocity_cutoff is not None or encoder_side is Side.MOTOR):
        raise InputError("--velocity-cutoff and --encoder-side need an --encoder")
    measured = None if encoder is None else Encoder(encoder, velocity_cutoff, encoder_side is Side.MOTOR)
    text = new_scenario_text(
        inertia, torque, speed, period=1.0 / rate, linear=linear, encoder=measured, gear_ratio=gear_ratio, delay=delay
    )
    typer.echo(text, nl=False)


def export_command(
    scenario: ScenarioFile = None,
    state: Path | None = None,  # state of the scenario's controller to start in, as controller.state_to_json() wrote it
    out: Path = Path("exported"),  # folder for the source
    controller: str | None = None,  # which controller; adaptive if not given
    prefix: str | None = None,  # begins all names in C; the controller's name if not given
    single: Annotated[bool, typer.Option("--float")] = False,  # compute in single precision
    # also write an FMU for co-simulation, of this version of FMI
    fmu: Annotated[str | None, typer.Option(metavar="2.0|3.0")] = None,
    common: Common = Common(),  # noqa: B008 - the defaults of the options
) -> None:
    """Write a controller as C99 source, with a self-test, an example and a CMake file."""
    from adaptive_ff.comparison.registry import make_for_machine

    content = None if state is None else _read(state)
    name, loaded = controller or "adaptive", adaptive_ff.load_scenario(scenario)
    try:
        made = make_for_machine(loaded, name)
    except ValueError as error:
        raise InputError(f"{scenario or 'built-in scenario'}: {error}") from error
    if content is not None:
        try:
            made.state_from_json(json.dumps(content))
        except ValueError as error:
            raise InputError(f"{state}: {error}") from error
    files = adaptive_ff.export_controller(
        made, out, prefix=name if prefix is None else prefix, single=single, with_fmu=fmu or False
    )
    Printer().say(f"{', '.join(file.name for file in files)} are in {out}")


def _read(state: Path) -> dict[str, Any]:
    """Return the content of the state file of a controller, whichever it is of."""
    text = read_text(state, "is no saved state")
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise InputError(f"{state}: is no saved state: {error}") from error
    if not isinstance(content, dict):
        raise InputError(f"{state}: is no saved state: it must be a JSON object")
    if "replay" in content or "settings" in content:
        raise InputError(
            f"{state}: is the state of a replay, not of a controller; identify the log, and give its scenario.toml"
        )
    return content


def playground_command(
    out: Path = Path("playground.html"),  # file of the page
    common: Common = Common(),  # noqa: B008
) -> None:
    """Write a page on which PI and adaptive run in a browser, with sliders; it needs no network."""
    from adaptive_ff.playground.page import write_page

    write_page(out)
    Printer().print(f"{out}: open it in a browser", highlight=False, markup=False, soft_wrap=True)
