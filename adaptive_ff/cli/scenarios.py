"""Command ``adaptive-ff scenarios``."""

import typer


def scenarios_command() -> None:
    """Print the scenarios of the package, each with a line; every command takes their names as its SCENARIO."""
    from adaptive_ff.scenario.library import scenario_names, scenario_title

    names = scenario_names()
    width = max(map(len, names))
    for name in names:
        typer.echo(f"{name:{width}}  {scenario_title(name)}")
