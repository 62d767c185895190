"""Command ``adaptive-ff export``."""

import json
from pathlib import Path
from typing import Annotated, Any

import typer

import adaptive_ff
from adaptive_ff.cli.options import ScenarioFile
from adaptive_ff.cli.output import Printer
from adaptive_ff.errors import InputError, read_text


def export_command(
    scenario: ScenarioFile = None,
    state: Path | None = None,  # state of the scenario's controller to start in, as controller.state_to_json() wrote it
    out: Path = Path("exported"),  # folder for the source
    controller: str | None = None,  # which controller; adaptive if not given
    prefix: str | None = None,  # begins all names in C; the controller's name if not given
    single: Annotated[bool, typer.Option("--float")] = False,  # compute in single precision
    # also write an FMU for co-simulation, of this version of FMI
    fmu: Annotated[str | None, typer.Option(metavar="2.0|3.0")] = None,
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
