"""Command ``adaptive-ff tune``."""

from typing import Annotated

import typer

import adaptive_ff
from adaptive_ff.cli.options import Output, ScenarioFile
from adaptive_ff.cli.output import bars, staged_results

LOAD = 0.4


def tune_command(
    scenario: ScenarioFile = None,
    # controller to study beside pi; by default the observers and adaptive. May be repeated
    controller: list[str] | None = None,
    seeds: Annotated[int, typer.Option(min=1, max=100)] = 5,  # number of seeds to report on, from 1 on
    tuning_seeds: Annotated[int, typer.Option(min=1)] = 3,  # number of seeds to choose on, from 101 on
    # step of the load to stand, over the torque limit; 0 if the joint sees none
    load: Annotated[float, typer.Option(min=0.0, max=1.0)] = LOAD,
    # least stiffness of a recommended loop, N m/rad (linear: N/m): load over angle lost
    stiffness: Annotated[float, typer.Option(min=0.0)] = 0.0,
    # also print margins, noise and errors at each bandwidth
    details: Annotated[bool, typer.Option("--details")] = False,
    output: Output = Output(),  # noqa: B008 - the defaults of the options
) -> None:
    """Find the bandwidth that suits each controller: margins, noise, stiffness and error over that of the PI loop.

    Two errors are weighed: the settled one, and the one in the 5 s after a step of the load (--load).
    Recommended is where the larger of their ratios to what pi leaves at its best bandwidth is least; a smaller --load
    recommends a slower, quieter loop.
    """
    from adaptive_ff.comparison.own_bandwidth import FIRST_TUNING_SEED
    from adaptive_ff.files import write_csv
    from adaptive_ff.report.tables import END_LEGEND, best_table, errors_table, loops_table
    from adaptive_ff.report.verdicts import bandwidth_lines
    from adaptive_ff.scenario.file import to_toml
    from adaptive_ff.studies.bandwidth_study import STUDIED, study_bandwidths

    loaded = adaptive_ff.load_scenario(scenario)
    with staged_results(output) as results:
        with bars("bandwidths") as done:
            study = study_bandwidths(
                loaded,
                controller or STUDIED,
                load=load,
                stiffness=stiffness,
                tuning_seeds=range(FIRST_TUNING_SEED, FIRST_TUNING_SEED + tuning_seeds),
                reported_seeds=range(1, seeds + 1),
                workers=None,
                progress=done["bandwidths"],
            )
        write_csv(results.stage / "tune.csv", study.columns())
        legend = [END_LEGEND] if any(one.at_an_end for one in study.own.values()) else []
        further = [loops_table(study), errors_table(study)]
        shown = [best_table(study), *legend, *bandwidth_lines(study.verdict), *(further if details else [])]
        results.write(
            "tune.json",
            study.to_dict(),
            shown,
            {"tune": study.plot()},
            further=[] if details else further,
            title=f"Bandwidths for {loaded.name}",
            details={"Scenario": to_toml(loaded)},
            source=loaded.name,
        )
        weighed = f"Weighed for a load of {load:g} of the torque limit (--load; 0 if the joint sees none)."
        auto = ' bandwidth = "auto" in a scenario uses the best ones.' if (load, stiffness) == (LOAD, 0.0) else ""
        results.shown.append(f"{weighed}{auto} Picture, tune.csv and tune.json are in {output.out}")
