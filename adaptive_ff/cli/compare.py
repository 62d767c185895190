"""Command ``adaptive-ff compare``."""

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

import adaptive_ff
from adaptive_ff.cli.options import SETTINGS, OwnControllers, ScenarioFile, ViewerOutput
from adaptive_ff.cli.output import Printer, bars, error_console, staged_results, warn
from adaptive_ff.errors import InputError

if TYPE_CHECKING:
    from adaptive_ff.comparison.comparison import Comparison
    from adaptive_ff.comparison.gate import Gate
    from adaptive_ff.comparison.own import Own
    from adaptive_ff.scenario.scenario import Scenario

CONTROLLER_NAMES = (
    *("pi", "pi_inertia", "fixed", "oracle", "oracle_tuned", "disturbance_observer", "extended_state"),
    *("kalman_disturbance", "observed_nominal", "observed_batch", "adaptive_paper", "adaptive_unsupervised"),
    *("adaptive", "canudas", "canudas_measured", "feedback_error", "lugre_observer", "lugre_gradient"),
    *("friction_observer", "lee_tomizuka", "maxwell_adaptive", "radial_basis", "super_twisting", "repetitive"),
)
FORM_NAMES, SOURCE_NAMES = ("coulomb", "stribeck", "lagged"), ("nominal", "stale", "true", "batch")
METRIC_NAMES = (
    *("rms_error", "max_error", "rms_error_start", "rms_error_settled", "max_error_settled", "torque_variation"),
    *("rms_position_error", "max_position_error", "rms_position_error_settled", "max_position_error_settled"),
)
"""Names that help lists before anything heavy is loaded; a test compares them with those that there are."""

WORSE = 1  # exit status where a regression gate fails


@dataclass
class Guard:
    """What a regression gate guards, and how far figures may be off."""

    baseline: Path | None = None  # earlier result (JSON); status 1 where tracking got worse than it
    # how much worse figures may be: 5% (the default; with --seeds what they explain) or 0.05 for all; METRIC=10%,
    # CONTROLLER=2% or CONTROLLER.METRIC=20% for some. May be given several times
    tolerance: list[str] | None = None
    guard: list[str] | None = None  # controller to guard; by default all of the baseline but the yardsticks
    metric: Annotated[
        list[str] | None,
        typer.Option(help=f"Figure to guard, by default all that the baseline has: {', '.join(METRIC_NAMES)}."),
    ] = None
    across: list[str] | None = None  # what may differ from the scenario of the baseline: gains (its table feedback)

    def gate(self, scenario: "Scenario", seeds: int) -> "Gate | None":
        """Return the gate, checked; None without a baseline."""
        if self.baseline is None:
            if self.tolerance or self.guard or self.metric or self.across:
                raise InputError("--tolerance, --guard, --metric and --across need a --baseline to compare with")
            return None
        from adaptive_ff.comparison.gate import Gate, read_baseline

        parts = [text.rpartition("=") for text in self.tolerance or []]
        return Gate(
            read_baseline(self.baseline),
            scenario,
            seeds,
            tolerance={name.strip() if equals else "default": fraction for name, equals, fraction in parts},
            controllers=self.guard,
            metrics=self.metric,
            across=self.across or (),
            name=str(self.baseline),
        )


def compare_command(
    scenario: ScenarioFile = None,
    reference: Path | None = None,  # recorded reference (CSV: time and velocity or position), instead of the file's
    controller: Annotated[
        list[str] | None,
        typer.Option(
            help=f"Controller to run, instead of the file's: {', '.join(CONTROLLER_NAMES)}, or FORM_SOURCE of "
            f"{', '.join(FORM_NAMES)} and {', '.join(SOURCE_NAMES)}. May be given several times."
        ),
    ] = None,
    own: OwnControllers = None,
    # keep one of so many samples in series and plots; figures are of the whole run. By default all are kept up to two
    # million solver steps; 1 for all of a longer run
    thin: Annotated[int | None, typer.Option(min=1)] = None,
    # number of seeds, from the scenario's on: a gate then compares means, and by default tolerates what their scatter
    # explains. Tables and pictures are of the first
    seeds: Annotated[int, typer.Option(min=1, max=100)] = 1,
    guard: Guard = Guard(),  # noqa: B008 - the defaults of the options
    output: ViewerOutput = ViewerOutput(),  # noqa: B008
) -> int:
    """Run a joint with each controller and show by how much friction feedforward improves tracking."""
    from adaptive_ff.comparison.comparison import compare, verdict
    from adaptive_ff.comparison.own import named_own
    from adaptive_ff.comparison.registry import CONTROLLERS
    from adaptive_ff.files import write_csv
    from adaptive_ff.scenario.file import to_toml

    mine = named_own(own or [])
    loaded = adaptive_ff.load_scenario(scenario, reference=reference)
    source = loaded.name
    if controller:
        loaded = loaded.modified(controllers=controller)
    gate = guard.gate(loaded, seeds)
    if loaded.feedback.is_auto and not SETTINGS.quiet:
        error_console().print("Looking for the bandwidth that suits each controller.")
    _check_controllers(loaded, mine, source)
    warn(loaded.cautions())
    with staged_results(output) as results:
        try:
            with ThreadPoolExecutor(1) as beside, bars(*loaded.controllers, *mine) as done:
                beside.submit(import_module, "adaptive_ff.report.page")  # loops and compilers leave it a processor
                comparison = compare(
                    loaded, own=mine, progress=lambda name, part: done[name](part), thin=thin, seeds=seeds
                )
        except ArithmeticError as error:
            raise InputError(f"{source}: the simulation fails: {error}") from error
        from adaptive_ff.report.comparison_pictures import PICTURES
        from adaptive_ff.report.tables import LEGEND, comparison_tables
        from adaptive_ff.report.verdicts import comparison_lines

        for name, run in comparison.runs.items():
            write_csv(results.stage / f"{name}.csv", run.columns())
        found = verdict(comparison)
        shown = [*comparison_tables(comparison), LEGEND, *comparison_lines(found)]
        if comparison.bandwidths:
            best = ", ".join(f"{name} {hertz:.3g} Hz" for name, hertz in comparison.bandwidths.items())
            shown.append(f"Each controller in the loop that suits it, chosen on other seeds: {best}")
        warn(comparison.cautions())
        title, details = f"Controllers on {source}, seed {loaded.seed}", {"Scenario": to_toml(loaded)}
        result = {**comparison.to_dict(), "verdict": vars(found)}
        pictures = comparison.plot(None)
        results.write("result.json", result, shown, pictures, title=title, details=details, series=comparison)
        results.shown.append(f"Plots, time series and result.json are in {output.out}")
        results.left_behind(PICTURES, [f"{name}.csv" for name in CONTROLLERS])
    return 0 if gate is None else _judge(gate, comparison, guard.baseline)


def _judge(gate: "Gate", comparison: "Comparison", baseline: Path | None) -> int:
    """Print what got worse, or that nothing did, and what is guarded; return the exit status."""
    worse, printer = gate.worse(comparison), Printer()
    for sentence in worse:
        error_console().print(f"worse than {baseline}: {sentence}", markup=False)
    if not worse:
        printer.say(f"Nothing is worse than in {baseline}, within the tolerances.")
    free = [name for name in comparison.runs if name not in gate.controllers]
    others = f"; not guarded: {', '.join(free)} (--guard NAME)" if free else ""
    allowed = sorted(gate.tolerance_of(name, one) for name in gate.controllers for one in gate.metrics)
    within = " to ".join(dict.fromkeys(f"{100.0 * one:.2g}" for one in (allowed[0], allowed[-1])))
    printer.say(f"Guarded: {len(gate.metrics)} figures of {', '.join(gate.controllers)}, within {within} %{others}")
    return WORSE if worse else 0


def _check_controllers(scenario: "Scenario", own: "Mapping[str, Own]", source: str) -> None:
    """Raise ``InputError``, before anything runs, where a controller cannot be made."""
    from adaptive_ff.comparison.registry import make_controller

    try:
        for name in (*scenario.controllers, *own):
            make_controller(scenario, name, own)
    except ValueError as error:
        raise InputError(f"{source}: {error}") from error
