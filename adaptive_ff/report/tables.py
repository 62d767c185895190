"""Results as tables. Ratios have one direction: PI's error, or a limit, over the controller's; above 1 is better."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from adaptive_ff.comparison.comparison import BASELINE, Comparison
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.comparison.run import NOISE_FLOOR
from adaptive_ff.friction.model import PER_DIRECTION, unit_of
from adaptive_ff.report.table import DEVIATIONS, Cell, Columns, Table, table
from adaptive_ff.scenario.axis_units import axis_unit
from adaptive_ff.scenario.library import grouped
from adaptive_ff.scenario.loop import HUNTING, load_step
from adaptive_ff.scenario.truth import last_model, true_waves
from adaptive_ff.studies.matrix import OURS, Cells, collect, mean_gain
from adaptive_ff.studies.sweep import CLASSES

if TYPE_CHECKING:
    from adaptive_ff.studies.bandwidth_study import BandwidthStudy
    from adaptive_ff.studies.matrix import Results
    from adaptive_ff.studies.motion import Excitation

IMPROVEMENT = "over pi"  # heading of the error of PI over that of the controller

LEGEND = f"{IMPROVEMENT}: settled error of pi over its own, above 1 is better; settled: last half"
"""What the columns of the tables of errors mean."""

AT_AN_END = {True: "slowest", False: "fastest"}
"""What is said beside a best bandwidth that is the first or the last of those that were tried."""

LEVELS = {"0.0": "worst", "0.5": "median", "1.0": "best"}  # of quantiles

END_LEGEND = "fastest: no faster loop has sound margins; slowest: no slower one was tried"  # what that means

MOST_COLUMNS, MOST_ROWS = 9, 16
"""Most controllers and scenarios whose every pair stands in a table on a terminal; of more it shows means."""


def present(*tables: Table | None) -> list[Table]:
    """Return the tables that there are."""
    return [one for one in tables if one is not None]


def highlights(names: Any) -> dict[str, str]:
    """Return how the rows of controllers stand out: the adaptive one, and a user's own."""
    own = {name: "bold cyan" for name in names if name not in (*CONTROLLERS, NOISE_FLOOR)}
    return {**own, OURS: "bold"}


def tracking_table(comparison: Comparison) -> Table:
    """Return the errors of all controllers, one a row."""
    axis = comparison.scenario.joint.axis
    speed = (axis_unit(axis, "rad/s"), 3)
    columns: Columns = {
        **{"controller": None, "settled": speed, IMPROVEMENT: ("", 3), "settled max": speed},
        **{"first 5 s": speed, "whole run": speed, "sum |du|": (axis_unit(axis, "N m"), 3)},
    }
    rows: list[list[Cell]] = []
    for name, run in comparison.runs.items():
        one = run.metrics
        errors = (one.max_error_settled, one.rms_error_start, one.rms_error, one.torque_variation)
        rows.append([name, one.rms_error_settled, comparison.improvement.get(name), *errors])
    what = "force" if axis == "linear" else "torque"
    return table(f"Velocity error (rms) and {what} variation", rows, columns, styles=highlights(comparison.runs))


def position_table(comparison: Comparison) -> Table | None:
    """Return the position errors of all controllers, one a row, or None where there is no position loop."""
    found = {name: run.position_metrics for name, run in comparison.runs.items() if run.position_metrics is not None}
    if not found:
        return None
    length = (axis_unit(comparison.scenario.joint.axis, "rad"), 3)
    columns: Columns = {"controller": None, "settled": length, IMPROVEMENT: ("", 3)}
    columns = {**columns, **dict.fromkeys(("settled max", "whole run", "max"), length)}
    base = found[BASELINE].rms_position_error_settled if BASELINE in found else math.nan
    rows: list[list[Cell]] = []
    for name, one in found.items():
        settled = one.rms_position_error_settled
        others = (one.max_position_error_settled, one.rms_position_error, one.max_position_error)
        rows.append([name, settled, base / settled if settled > 0.0 else None, *others])
    return table("Position error (rms)", rows, columns, styles=highlights(found))


def estimates_table(comparison: Comparison) -> Table | None:
    """Return the final estimates beside the true parameters, or None where nothing is estimated."""
    runs = [run for run in comparison.runs.values() if run.estimates]
    if not runs:
        return None
    title = "Parameters at the end of the run"
    if any(run.uncertainties for run in runs):
        title += f", ± {DEVIATIONS:g} standard deviations"
    waves = true_waves(comparison.scenario)
    truth = last_model(comparison.scenario)._asdict() | waves
    there = dict.fromkeys(name for run in runs for name in run.estimates)
    known = [name for name in (*PER_DIRECTION, *waves, "stribeck_velocity") if name in there]
    rows: list[list[Cell]] = []
    for name in known + [name for name in there if name not in known]:  # own controllers may estimate anything
        unit = unit_of(name) and axis_unit(comparison.scenario.joint.axis, unit_of(name))
        estimates: list[Cell] = []
        for run in runs:
            value = run.final_estimates.get(name)
            spread = run.uncertainties.get(name)
            estimates.append(value if value is None or spread is None else (value, DEVIATIONS * float(spread[-1])))
        rows.append([f"{name}, {unit}" if unit else name, float(truth[name]) if name in known else None, *estimates])
    return table(title, rows, {"parameter": None, **{name: ("", 4) for name in ("true", *(run.name for run in runs))}})


def comparison_tables(comparison: Comparison) -> list[Table]:
    """Return all tables of a comparison."""
    return present(tracking_table(comparison), position_table(comparison), estimates_table(comparison))


def sweep_tables(result: Mapping[str, Any]) -> list[Table]:
    """Return the distributions that a sweep found, by how steeply friction falls, and of further controllers."""
    title = f"{result['draws']} draws, {result['refused']} of them refused; settled error, whole run, first 5 s"
    quantiles = result["quantiles"]
    heads = {
        "improvement": "settled: pi / adaptive",
        "share_of_oracle": "settled: oracle / adaptive",
        "whole_run": "whole run: pi / adaptive",
        "start": "first 5 s: pi / adaptive",
        "torque_variation": "sum |du|: oracle / adaptive",
    }
    rows = [
        [LEVELS.get(level, f"{100.0 * float(level):g} %"), *(_gain(quantiles, name, level) for name in heads)]
        for level in quantiles.get("improvement", {})
    ]
    tables = [table(title, rows, {"quantile": None, **dict.fromkeys(heads.values(), ("", 3))})]
    heads = {
        "joints": "joints",
        "improvement": "settled: pi / adaptive",
        "least_improvement": "worst",
        "start": "first 5 s: pi / adaptive",
        "worse_settled": "settled worse than pi",
        "worse_whole_run": "whole run 5 % worse",
    }
    classes: list[list[Cell]] = []
    for name, found in result["classes"].items():
        figures = {**found, "start": 1.0 / found["start"]}
        classes.append([name + (" (pi hunts)" if CLASSES[name] >= HUNTING else ""), *(figures[key] for key in heads)])
    columns: Columns = {"fall": None, **dict.fromkeys(heads.values(), ("", 3))}
    tables.append(table("By the steepest fall of friction", classes, columns))
    if result["own"]:
        tables.append(_further_table(result["own"]))
    return tables


def _gain(quantiles: Mapping[str, Any], name: str, level: str) -> float | None:
    """Return a quantile of what is better above one; of errors over those of pi, the other end's inverse."""
    if name not in quantiles:
        return None
    if name in ("improvement", "share_of_oracle"):
        return float(quantiles[name][level])
    return 1.0 / float(quantiles[name][f"{round(1.0 - float(level), 6)}"])


def _further_table(own: Mapping[str, Any]) -> Table:
    """Return how further controllers fared in a sweep, pi over each."""
    parts = {"settled": "improvement", "whole run": "whole_run"}
    rows = [
        [name, *(_gain(found, part, level) for part in parts.values() for level in LEVELS), found["failed"]]
        for name, found in own.items()
    ]
    heads = [f"{part} {level}" for part in parts for level in LEVELS.values()]
    columns: Columns = {"controller": None, **dict.fromkeys((*heads, "failed"), ("", 3))}
    return table("Further controllers: error of pi over theirs", rows, columns, styles=highlights(own))


def gains_table(cells: Cells, title: str) -> Table:
    """Return the improvement of every controller over PI, medians over the seeds, under the heading of each group."""
    names = [name for name in dict.fromkeys(key for row in cells.values() for key in row) if name != BASELINE]
    rows: list[Sequence[Cell]] = []
    for group, members in grouped(cells).items():
        rows.append([group])
        for scenario in members:
            row = cells[scenario]
            gains = [row[name].gain if name in row else "failed" for name in names]
            rows.append([f"  {scenario}", row[BASELINE].error, *gains])
    columns: Columns = {"scenario": None, "pi": ("rad/s", 3), **dict.fromkeys(names, ("", 3))}
    return table(title, rows, columns)


def ranking_table(cells: Cells, title: str) -> Table:
    """Return the geometric mean of the improvement over PI, of all scenarios and of each group, the best first."""
    names = [name for name in dict.fromkeys(key for row in cells.values() for key in row) if name != BASELINE]
    parts = {"all": cells, **{group: {one: cells[one] for one in part} for group, part in grouped(cells).items()}}
    means = {name: [mean_gain(part, name) for part in parts.values()] for name in names}
    ranked = sorted(names, key=lambda name: -means[name][0] if math.isfinite(means[name][0]) else math.inf)
    rows = [[name, *(gain if math.isfinite(gain) else "failed" for gain in means[name])] for name in ranked]
    heads = [f"{part} ({len(members)})" for part, members in parts.items()]
    return table(title, rows, {"controller": None, **dict.fromkeys(heads, ("", 3))}, styles=highlights(names))


def standstill_table(results: "Results") -> Table | None:
    """Return what moved at standstill; None where the reference of no scenario stands still."""
    still = {job: found for job, found in results.items() if found[BASELINE].get("standstill") is not None}
    if not still:
        return None
    found = collect(still, "standstill")
    names = list(next(iter(found.values())))
    rows = [[name, *(row[name].error if name in row else "failed" for row in found.values())] for name in names]
    columns: Columns = {"controller": None, **dict.fromkeys(found, ("rad/s", 3))}
    return table("Peak-to-peak true velocity at standstill, median over seeds", rows, columns)


def loops_table(study: "BandwidthStudy") -> Table:
    """Return what the PI loop is like at each bandwidth: margins, noise, stiffness, and whether it hunts."""
    axis, step = study.scenario.joint.axis, load_step(study.scenario, study.load)
    columns: Columns = {
        **{"bandwidth": ("Hz", 3), "Ms": ("", 3), "phase": ("°", 2)},
        **{"noise torque": (axis_unit(axis, "N m"), 3), "noise speed": (axis_unit(axis, "rad/s"), 3)},
        **{"lost": (axis_unit(axis, "rad/(N m)"), 3), "peak": (axis_unit(axis, "rad/s"), 3), "falling friction": None},
    }
    names = ("bandwidth", "maximum_sensitivity", "phase_margin", "noise_torque", "noise_velocity", "angle_lost")
    rows: list[list[Cell]] = [
        [*(getattr(loop, name) for name in (*names, "peak_speed")), "hunts" if loop.hunts else "held"]
        for loop in study.loops
    ]
    load = f"{step:.3g} {axis_unit(axis, 'N m')}"
    way = "position" if axis == "linear" else "angle"
    return table(f"PI loop: margins, sensor noise (rms), {way} lost to a load, peak after {load}", rows, columns)


def errors_table(study: "BandwidthStudy") -> Table:
    """Return the errors that each controller leaves at each bandwidth, what is recommended, and the Pareto front."""
    speed, front = (axis_unit(study.scenario.joint.axis, "rad/s"), 3), study.front()
    rows: list[list[Cell]] = []
    for name, one in study.own.items():
        rows.append([name])
        for place, pair in enumerate(one.pairs):
            cells = [error if math.isfinite(error) else "fails" for error in pair]
            marks = ["best"] * (place == one.place) + ["front"] * ((name, place) in front)
            rows.append([one.bandwidths[place], *cells, ", ".join(marks)])
    columns: Columns = {"bandwidth": ("Hz", 3), "settled": speed, "loaded": speed, "": None}
    return table("Errors (rms), tuning seeds; loaded: after a load step; front: Pareto front", rows, columns)


def best_table(study: "BandwidthStudy") -> Table:
    """Return what each controller reaches at its own best bandwidth, and in the loop of the scenario."""
    feedback = study.scenario.feedback
    speed = (axis_unit(study.scenario.joint.axis, "rad/s"), 3)
    given = "" if feedback.is_auto else ("as given" if math.isnan(feedback.hertz) else f"at {feedback.hertz:.3g} Hz")
    columns: Columns = {"controller": None, "best": ("Hz", 3), "": None, "error": speed, IMPROVEMENT: ("", 3)}
    columns = {**columns, "loaded": speed, f"loaded {IMPROVEMENT}": ("", 3)}
    if given:
        columns = {**columns, f"error {given}": speed}
    rows: list[list[Cell]] = []
    for name, one in study.own.items():
        cells: list[Cell] = [name, one.best, AT_AN_END[one.place == 0] if one.at_an_end else ""]
        for error, base in zip(study.own_errors[name], study.own_errors[BASELINE], strict=True):
            cells += [error, base / error if error > 0.0 else None]
        rows.append([*cells, *([study.common_errors[name].settled] if given else [])])
    title = "Errors (rms), each at its best bandwidth; loaded: after an assumed load step"
    return table(title, rows, columns, styles=highlights(study.own))


def motion_tables(motion: "Excitation", *, linear: bool = False) -> list[Table]:
    """Return what a motion needs beside its limits, and its intervals over those of a minute of multisine."""
    axis = "linear" if linear else "rotary"
    units = {"position": "rad", "velocity": "rad/s", "acceleration": "rad/s^2", "torque": "N m"}
    rows: list[list[Cell]] = [
        [f"{name}, {axis_unit(axis, units[name])}", largest, getattr(motion.limits, name)]
        for name, largest in motion.largest.items()
    ]
    columns: Columns = {"": None, "largest": ("", 3), "limit": ("", 3)}
    sizes: Columns = {name.replace("_", " "): ("", 3) for name in motion.sizes}
    return [
        table(f"Motion of {motion.reference.period:g} s", rows, columns),
        table("95 % intervals over those of 60 s of multisine", [list(motion.sizes.values())], sizes),
    ]
