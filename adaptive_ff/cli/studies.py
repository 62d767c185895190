"""Commands ``scenarios``, ``matrix``, ``sweep`` and ``tune``: controllers over scenarios, joints and bandwidths."""

from pathlib import Path
from textwrap import fill
from typing import Annotated

import typer

import adaptive_ff
from adaptive_ff.cli.cluster import workers
from adaptive_ff.cli.options import Output, OwnControllers, ScenarioFile, Scheduler
from adaptive_ff.cli.output import bars, staged_results
from adaptive_ff.errors import InputError, check_among

SHOWN = ("oracle", "lagged_batch", "adaptive")
"""Controllers beside ``pi`` where none are chosen: the two yardsticks that matter, and ours."""

ALL = "all"
LEFT_OUT = frozenset({"fixed"})
"""Its parameters stand in a table that these scenarios do not have; the fixed feedforwards are there by other names."""

LOAD = 0.4  # default of ``--load``


def matrix_command(
    own: OwnControllers = None,
    only: list[str] | None = None,  # scenario to run; may be given several times
    controller: Annotated[
        list[str] | None,
        typer.Option(help=f"Controller to run beside pi, or {ALL!r}; by default {', '.join(SHOWN)}. May be repeated."),
    ] = None,
    seeds: Annotated[int, typer.Option(min=1)] = 5,  # number of seeds, from 1 on
    fastest: bool = False,  # also run everything with the fastest PI loop
    scheduler: Scheduler = None,
    output: Output = Output(out=Path("results/matrix")),  # noqa: B008 - the defaults of the options
) -> None:
    """Run controllers on all scenarios of the package over several seeds, and say who wins where."""
    from adaptive_ff.comparison.comparison import BASELINE
    from adaptive_ff.comparison.own import named_own
    from adaptive_ff.comparison.registry import CONTROLLERS
    from adaptive_ff.comparison.run import NOISE_FLOOR
    from adaptive_ff.report.matrix_files import by_loop, matrix_figures, matrix_rows, matrix_tables, write_matrix
    from adaptive_ff.report.verdicts import matrix_lines
    from adaptive_ff.scenario.library import scenario_names
    from adaptive_ff.studies.matrix import Job, collect, run_matrix, verdict

    mine = named_own(own or [])
    known = [*(name for name in CONTROLLERS if name not in LEFT_OUT), NOISE_FLOOR]
    chosen = known if ALL in (controller or ()) else _chosen("--controller", controller or list(SHOWN), known)
    scenarios = _chosen("--only", only, scenario_names())
    loops = [False, True] if fastest else [False]
    jobs = [Job(scenario, seed, fast) for fast in loops for scenario in scenarios for seed in range(1, seeds + 1)]
    with workers(scheduler) as executor, bars("runs") as done:
        names = list(dict.fromkeys([BASELINE, *chosen]))
        found = run_matrix(jobs, names, output.out, own=mine, executor=executor, progress=done["runs"])
    write_matrix(found, output.out)
    with staged_results(output) as results:
        title = f"{len(scenarios)} scenarios, seeds 1 to {seeds}"
        said = verdict(collect(by_loop(found)[False]))
        shown = [*matrix_tables(found), *matrix_lines(said)]
        results.write("", {"runs": matrix_rows(found), "verdict": said}, shown, matrix_figures(found), title=title)
        results.shown.append(f"All tables, pictures and the runs behind them are in {output.out}")


def _chosen(option: str, given: list[str] | None, known: list[str]) -> list[str]:
    for name in given or []:
        check_among(f"{option}: ", name, known)
    return [name for name in known if not given or name in given]


def sweep_command(
    scenario: ScenarioFile = None,
    own: OwnControllers = None,
    # further controller of the package to run beside them. May be given several times
    controller: list[str] | None = None,
    runs: Annotated[int, typer.Option(min=1)] = 1000,  # number of joints to draw
    seed: Annotated[int, typer.Option(min=0)] = 1,  # seed of the draws
    scheduler: Scheduler = None,
    output: Output = Output(),  # noqa: B008
) -> None:
    """Draw joints at random, and show how pi, oracle, adaptive and further controllers fare on them."""
    from adaptive_ff.comparison.own import named_own
    from adaptive_ff.report.study_pictures import plot_sweep
    from adaptive_ff.report.tables import sweep_tables
    from adaptive_ff.scenario.file import to_toml
    from adaptive_ff.studies.sweep import draw_scenario, refusals, summary, sweep

    mine, loaded = named_own(own or []), adaptive_ff.load_scenario(scenario)
    with staged_results(output) as results, workers(scheduler) as executor:
        with bars("joints") as done:
            outcomes = sweep(
                loaded,
                runs,
                seed,
                own=mine,
                further=controller or [],
                folder=output.out,
                executor=executor,
                progress=done["joints"],
            )
        refused = [f"{count} joints refused: {reason}" for reason, count in refusals(outcomes).items()]
        if all(outcome.refused for outcome in outcomes):
            raise InputError(f"{loaded.name}: none of {runs} joints can be run; {'; '.join(refused)}")
        result = summary(outcomes, seed)
        for rank, case in enumerate(result["worst"], start=1):
            text = to_toml(draw_scenario(loaded, seed, case["draw"]))
            (results.stage / f"worst-{rank}.toml").write_text(text, encoding="utf-8")
        figure = plot_sweep(outcomes, f"around {loaded.name}, seed {seed}", len(result["worst"]))
        worse = f"{100 * result['worse_than_pi']:.2g} % of the joints that ran"
        shown = [*sweep_tables(result), f"Whole run more than 5 % worse than pi: {worse}", *refused]
        title = f"{runs} joints drawn around {loaded.name}, seed {seed}"
        figures, details = {"sweep": figure}, {"Scenario that they are drawn around": to_toml(loaded)}
        results.write("sweep.json", result, shown, figures, title=title, details=details)
        results.shown.append(f"sweep.json, its picture and the worst cases are in {output.out}")


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
    output: Output = Output(),  # noqa: B008
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


def scenarios_command(
    text: Annotated[str, typer.Argument(help="Say what those are whose name or line has this text in it.")] = "",
) -> None:
    """Print the scenarios of the package; every command takes their names as its SCENARIO."""
    from adaptive_ff.scenario.library import grouped, scenario_names, scenario_title

    titles = {name: scenario_title(name) for name in scenario_names()}
    if not text:
        for group, names in grouped(titles).items():
            typer.echo(f"{group}:\n{fill(', '.join(names), 78, initial_indent='  ', subsequent_indent='  ')}")
        typer.echo("adaptive-ff scenarios TEXT describes those with the text in name or description.")
        return
    found = {name: title for name, title in titles.items() if text.lower() in f"{name} {title}".lower()}
    if not found:
        raise InputError(f"TEXT = {text!r} is in no scenario; adaptive-ff scenarios lists all")
    for name, title in found.items():
        typer.echo(f"{name:{max(map(len, found))}}  {title}")
