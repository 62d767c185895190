"""Command ``adaptive-ff new``."""

from enum import StrEnum
from typing import Annotated

import typer


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
    from adaptive_ff.errors import InputError
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
