"""Command ``adaptive-ff new``."""

from typing import Annotated

import typer


def new_command(
    inertia: Annotated[float, typer.Option(help="Inertia of motor and load at the joint, kg m^2 (linear: kg).")] = 20.0,
    torque: Annotated[float, typer.Option(help="Rated torque at the joint, N m (linear: N).")] = 400.0,
    speed: Annotated[float, typer.Option(help="Rated speed of the joint, rad/s (linear: m/s).")] = 2.5,
    rate: Annotated[float, typer.Option(help="Sampling frequency of the velocity controller, Hz.")] = 1000.0,
    linear: Annotated[bool, typer.Option("--linear", help="A linear axis: mass, force, m/s.")] = False,
) -> None:
    """Print a smallest complete scenario file, from the numbers of a data sheet: adaptive-ff new > joint.toml."""
    from adaptive_ff.errors import InputError
    from adaptive_ff.scenario.new import LONGEST_PERIOD, SHORTEST_PERIOD, new_scenario_text

    least, most = 1.0 / LONGEST_PERIOD, 1.0 / SHORTEST_PERIOD
    if not least < rate <= most:
        raise InputError(f"--rate = {rate:g} is not allowed: it must be above {least:g} Hz and at most {most:.3g} Hz")
    typer.echo(new_scenario_text(inertia, torque, speed, period=1.0 / rate, linear=linear), nl=False)
