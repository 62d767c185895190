"""Never worse than PI: ``python -m benchmarks.never_worse [--every] [--joints N] [--machines N] [--cascades N] ...``.

A controller against its own PI loop, as ``adaptive_ff.comparison.windows`` defines it, beside what is asked of it: in
situations outside the controller's model (by default), in scenarios of the matrix (``--scenario``, ``--every``) and on
joints drawn at random around the built-in one (``--joints``), by how steeply their friction falls against the
proportional gain. Where it falls by more than the gain, PI itself hunts. Machines (``--machines``) are drawn over
decades of size, speed and sampling rate, see ``benchmarks.drawn_machines``; with a weight and behind a position loop
(``--cascades``), and with rests of seconds between moves there (``--resting``), the error is that of the position, in
mrad. With ``--saturating`` joints and machines have drives that saturate, of whose torque the controllers are told
nothing; with ``--elastic`` machines have gears that are elastic, or have play, of which nothing is told. ``--controller
pi`` compares PI with itself under other noise: what chance alone does to the figures. Reported are references of seeds
from 1 on and the draws of seed 1; whoever tunes takes ``--first-seed 101``.
"""

import os
import tomllib
from collections.abc import Callable, Iterable
from concurrent.futures import Executor, ProcessPoolExecutor
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer
from rich.box import SIMPLE
from rich.console import Console
from rich.progress import track
from rich.table import Table

from adaptive_ff import Scenario, load_scenario, parse_scenario
from adaptive_ff.comparison.comparison import BASELINE
from adaptive_ff.comparison.drawn_joints import CLASSES, class_of, draw_scenario, fall_over_gain
from adaptive_ff.comparison.matrix.cells import SCENARIOS, scenario_names
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.comparison.windows import DRAWS, Judgement, judge, judge_chance
from adaptive_ff.files import write_json
from adaptive_ff.scenario.new import new_scenario_text
from benchmarks.drawn_machines import draw_cascade, draw_elastic, draw_machine, draw_resting, draw_saturating
from benchmarks.position_map import rows as map_rows
from benchmarks.position_map import told
from benchmarks.wide import wide_console

WINDOW_LIMIT = 1.2
"""Largest error in a window over what counts for PI there."""

WORST_SETTLED = 0.95
"""Least settled error of PI over the controller's for any reference."""

STEEPEST_WITH_WINDOWS = 10.0
"""Largest fall of friction over the proportional gain up to which windows are asked for."""


class Asked(NamedTuple):
    """What is asked of a situation.

    Attributes
    ----------
    settled : float
        Least settled error of PI over the controller's, median over references.
    window : float
        Largest ratio in any window, infinite where none is asked for.
    start : float
        Largest ratio in the first 5 s, median over references, infinite where none is asked for.
    after : float
        Largest ratio in the first 5 s after a change, median over references.
    """

    settled: float = 1.0
    window: float = WINDOW_LIMIT
    start: float = np.inf
    after: float = np.inf


MAPS = {row.key: row for row in map_rows()}
MAPS |= {
    "no_map_short": MAPS["map_short_period"]._replace(periods=()),
    "no_map_long": MAPS["map_long_period"]._replace(periods=()),
}
"""Joints on which ``adaptive`` has a map of friction over position or load, by name, and two of them without."""

LIGHTNESS = 0.1
"""Inertia of light joints over that of the built-in one."""

LIGHT_PEAKS = {"light_slow": 0.0125, "light_medium": 0.05, "light": 0.35}
"""Largest speeds of the plan of joints with a tenth of the built-in inertia, and of the gain, rad/s, by name."""

TOLD_NOTHING = {"torque_untold": "paper_100hz", "limit_untold": "saturation"}
"""Scenarios of which the controllers are told nothing of the torque that the drive gives, by name."""

DRIVES_UNTOLD: dict[str, dict[str, float]] = {
    "lag_untold_10": {"lag": 0.010},
    "lag_untold_13": {"lag": 0.013},
    "lag_untold_20": {"lag": 0.020},
    "lag_untold_30": {"lag": 0.030},
    "rate_untold_1500": {"rate_limit": 1500.0},
    "rate_untold_2000": {"rate_limit": 2000.0},
}
"""Lags of the drive's current loop, s, and limits to how fast its torque rises, N m/s, by name.

The controllers are told nothing of them, nor what the drive gives.
"""

SENSOR_FAULTS: dict[str, dict[str, Any]] = {
    "sensor_leaps": {"leap": 3.0, "leap_share": 0.001},
    "sensor_leaps_often": {"leap": 1.0, "leap_share": 0.01},
    "sensor_held_10": {"held": 10, "held_share": 0.002},
    "sensor_held_50": {"held": 50, "held_share": 0.001},
    "sensor_held_often": {"held": 2, "held_share": 0.1},
}
"""Faults of the sensor of the built-in joint, by name: single velocities that leap, and messages that are lost."""


class Rippled(NamedTuple):
    """A velocity that is off by a share of itself, so many times in a turn, on the built-in joint at 500 Hz.

    Attributes
    ----------
    share : float
        Amplitude, over the velocity.
    times : int
        Periods in a turn.
    reverses : bool
        Whether the plan is the built-in multisine, up to 2 rad/s, or a staircase of speeds of one sign.
    """

    share: float
    times: int
    reverses: bool = False


RIPPLED = {
    "sensor_ripple_4": Rippled(0.01, 4),
    "sensor_ripple_20": Rippled(0.01, 20),
    "sensor_ripple_60": Rippled(0.01, 60),
    "sensor_ripple_120": Rippled(0.005, 120),
    "sensor_ripple_reverses": Rippled(0.005, 120, reverses=True),
}
"""Velocities out of resolvers, tachometers and discs that are not round, by name."""

STAIRS, STAIR_SPEEDS = 20, (1.0, 3.0)
"""Number and range (rad/s) of the speeds of their plans, drawn for each reference."""

TOLD_INERTIAS = {"inertia_told_double": 2.0, "inertia_told_half": 0.5}
"""Inertia that is told, and the feedback is designed for, over that of the built-in joint, by name."""

DATA_SHEETS = {"data_sheet": (0.5, 20.0, 6.0), "data_sheet_heavy": (20.0, 400.0, 2.5)}
"""Inertia, kg m^2, rated torque, N m, and speed, rad/s, of joints that ``adaptive-ff new`` makes, at 1 kHz, by name."""

DATA_SHEET_TIME = 240.0
"""For how long they move, s: what noise does to a fast loop shows after minutes."""


class Encoder(NamedTuple):
    """An encoder instead of a measured velocity on the built-in joint.

    Attributes
    ----------
    counts : int
        Counts in a turn.
    velocity : dict
        What makes a velocity of it.
    period : float
        Sampling period, s.
    bandwidth : float
        Bandwidth of the loop, Hz.
    scenario : str
        Scenario of the matrix that the joint and its motion are from.
    """

    counts: int
    velocity: dict[str, Any]
    period: float = 0.01
    bandwidth: float = 10.0
    scenario: str = "paper_100hz"


KALMAN: dict[str, Any] = {"method": "kalman"}
"""A velocity made by the default Kalman filter."""

ENCODERS = {
    "coarse_encoder": Encoder(4096, {"method": "low_pass", "cutoff": 30.0}, bandwidth=6.0),
    "coarse_encoder_kalman": Encoder(4096, KALMAN, bandwidth=6.0),
    **{f"kalman_1khz_{counts}": Encoder(counts, KALMAN, period=1e-3) for counts in (4096, 8192, 16384, 65536)},
    "kalman_1khz_load_step": Encoder(65536, KALMAN, period=1e-3, scenario="load_step_80"),
    "kalman_1khz_triples": Encoder(65536, KALMAN, period=1e-3, scenario="friction_triples"),
}
"""Encoders of few counts by name; at 100 Hz the loop has 6 Hz, since PI itself hunts with 10."""

MADE = (LIGHT_PEAKS, TOLD_INERTIAS, TOLD_NOTHING, DRIVES_UNTOLD, SENSOR_FAULTS, RIPPLED, DATA_SHEETS, ENCODERS, MAPS)
"""All tables of situations that are not in the matrix."""

SITUATIONS: dict[str, Asked] = {
    "paper_100hz": Asked(start=0.36),
    "noisy_1khz": Asked(start=0.15),
    "load_step_30": Asked(settled=6.0, after=0.35),
    "load_step_80": Asked(settled=6.0, after=0.5),
    "friction_drops": Asked(after=0.28),
    "friction_triples": Asked(after=0.25),
    "payload_double": Asked(),
    "payload_half": Asked(),
    "gravity_40": Asked(),
    "gravity_100": Asked(settled=3.5, window=1.5),
    "lugre_1e3": Asked(settled=1.3),
    "lugre_3e3": Asked(settled=1.9),
    "lugre_1e4": Asked(settled=2.8),
    "slow_010": Asked(),
    "slow_025": Asked(),
    "slow_050": Asked(),
    **dict.fromkeys(LIGHT_PEAKS, Asked()),
    **dict.fromkeys(TOLD_INERTIAS, Asked()),
    **dict.fromkeys(TOLD_NOTHING, Asked()),
    **dict.fromkeys(DRIVES_UNTOLD, Asked()),
    **dict.fromkeys(SENSOR_FAULTS, Asked()),
    **dict.fromkeys(RIPPLED, Asked()),
    **dict.fromkeys(DATA_SHEETS, Asked()),
    "steep_2": Asked(),
    "steep_5": Asked(),
    "steep_10": Asked(),
    "steep_20": Asked(window=np.inf),
    "high_stiction": Asked(settled=3.5),
    "high_stiction_vs_quarter": Asked(settled=3.5),
    "high_stiction_vs_fourfold": Asked(settled=3.5),
    "delay": Asked(start=0.25),
    "elastic": Asked(start=0.25),
    "fast_loop_1khz": Asked(),
    "fast_loop_encoder": Asked(),
    **dict.fromkeys(ENCODERS, Asked()),
    **dict.fromkeys(MAPS, Asked()),
    "map_friction_drops_hats_25": Asked(after=0.28),
}
"""Situations by name of their scenario, or of one of the tables above; others: never worse."""


class Case(NamedTuple):
    """One reference on which a controller is judged.

    Attributes
    ----------
    name : str
        Situation or class of joints.
    seed : int
        Seed of the reference, or number of the draw of the joint.
    scenario : Scenario
        What is run.
    """

    name: str
    seed: int
    scenario: Scenario


def named_cases(names: Iterable[str], first: int, references: int) -> list[Case]:
    """Return the references of named scenarios, and of ``MAPS``."""
    seeds = range(first, first + references)
    return [Case(name, seed, named_scenario(name, seed)) for name in names for seed in seeds]


def named_scenario(name: str, seed: int) -> Scenario:
    """Return a scenario of the matrix, or of one of the tables above, with a seed."""
    if name in MAPS:
        return told(MAPS[name], seed)
    if name in LIGHT_PEAKS:
        light, peak = {"inertia": LIGHTNESS * load_scenario().joint.inertia}, LIGHT_PEAKS[name]
        return load_scenario().modified(seed=seed, joint=light, feedback=light, reference={"peak": peak})
    if name in TOLD_NOTHING:
        told_nothing = load_scenario(SCENARIOS / f"{TOLD_NOTHING[name]}.toml")
        return told_nothing.modified(seed=seed, actuator={"reports_torque": False})
    if name in DRIVES_UNTOLD:
        return load_scenario().modified(seed=seed, actuator={**DRIVES_UNTOLD[name], "reports_torque": False})
    if name in SENSOR_FAULTS:
        return load_scenario().modified(seed=seed, sensor=SENSOR_FAULTS[name])
    if name in RIPPLED:
        return rippled(RIPPLED[name], seed)
    if name in TOLD_INERTIAS:
        told_inertia = TOLD_INERTIAS[name] * load_scenario().joint.inertia
        return load_scenario().modified(seed=seed, feedback={"inertia": told_inertia})
    if name in DATA_SHEETS:
        made = parse_scenario(tomllib.loads(new_scenario_text(*DATA_SHEETS[name])), name)
        return made.modified(seed=seed, duration=DATA_SHEET_TIME)
    if name in ENCODERS:
        encoder = ENCODERS[name]
        return load_scenario(SCENARIOS / f"{encoder.scenario}.toml").modified(
            seed=seed,
            sampling={"period": encoder.period},
            sensor={"velocity_noise": 0.0, "encoder_resolution": 2.0 * np.pi / encoder.counts},
            velocity=encoder.velocity,
            feedback={"bandwidth": encoder.bandwidth},
        )
    return load_scenario(SCENARIOS / f"{name}.toml").modified(seed=seed)


def rippled(sensor: Rippled, seed: int) -> Scenario:
    """Return the built-in joint with a velocity that ripples."""
    period = 2.0 * np.pi / sensor.times
    speeds = np.random.default_rng([seed, STAIRS]).uniform(*STAIR_SPEEDS, STAIRS).round(3)
    stairs = {"kind": "staircase", "velocities": speeds.tolist(), "hold": 3.0, "acceleration": 2.0}
    return load_scenario().modified(
        seed=seed,
        sampling={"period": 0.002},
        sensor={"ripple_amplitude": sensor.share * period / (2.0 * np.pi), "ripple_period": period},
        reference={"peak": 2.0} if sensor.reverses else stairs,
    )


def drawn_cases(joints: int, seed: int) -> list[Case]:
    """Return joints drawn around the built-in one, named by how steeply their friction falls."""
    drawn = ((draw, draw_scenario(load_scenario(), seed, draw)) for draw in range(joints))
    return [Case(class_of(fall_over_gain(scenario)), draw, scenario) for draw, scenario in drawn]


def machine_cases(machines: int, seed: int) -> list[Case]:
    """Return machines drawn over decades, named by their kind of friction."""
    return _by_friction("machine", draw_machine, machines, seed)


def cascade_cases(machines: int, seed: int) -> list[Case]:
    """Return the same machines with a weight and behind a position loop."""
    return _by_friction("cascade", draw_cascade, machines, seed)


def resting_cases(machines: int, seed: int) -> list[Case]:
    """Return these with rests of seconds between moves."""
    return _by_friction("rests", draw_resting, machines, seed)


def _by_friction(label: str, draw_one: Callable[[int, int], Scenario], machines: int, seed: int) -> list[Case]:
    drawn = ((draw, draw_one(seed, draw)) for draw in range(machines))
    return [Case(f"{label}, {scenario.joint.kind}", draw, scenario) for draw, scenario in drawn]


def saturating_cases(drives: int, seed: int) -> list[Case]:
    """Return joints and machines whose drives saturate untold."""
    drawn = ((draw, draw_saturating(seed, draw)) for draw in range(drives))
    return [Case(f"{('joint', 'machine')[draw % 2]}, saturates untold", draw, scenario) for draw, scenario in drawn]


def elastic_cases(machines: int, seed: int) -> list[Case]:
    """Return machines with elastic gears, and with such that have play as well."""
    drawn = ((draw, draw_elastic(seed, draw)) for draw in range(machines))
    return [Case(f"machine, {('elastic gear', 'play')[draw % 2]}", draw, scenario) for draw, scenario in drawn]


def judge_case(case: Case, controller: str, draws: int) -> Judgement:
    """Judge a controller on one reference; PI under other noise than that which it is compared with."""
    if controller == BASELINE:
        return judge_chance(case.scenario, draws=draws)
    return judge(case.scenario, controller, draws=draws)


def asked_of(name: str) -> Asked:
    """Return what is asked of a situation, of a class of drawn joints or of drawn machines."""
    if name in CLASSES and CLASSES[name] >= STEEPEST_WITH_WINDOWS:
        return Asked(window=np.inf)
    return SITUATIONS.get(name, Asked())


def row_of(name: str, found: list[Judgement]) -> dict[str, Any]:
    """Return the figures of a situation over its references, and which of what is asked is missed."""
    asked = asked_of(name)
    settled = np.array([judgement.settled for judgement in found])
    windows = np.array([judgement.worst_window for judgement in found])
    start = np.array([judgement.start for judgement in found])
    after = np.array([ratio for judgement in found for ratio in judgement.after])
    row = {
        "situation": name,
        "references": len(found),
        "pi": float(np.median([judgement.base.settled for judgement in found])),
        "settled": float(np.median(settled)),
        "settled_worst": float(np.min(settled)),
        "settled_under": int(np.sum(settled < WORST_SETTLED)),
        "worst_window": float(np.max(windows)),
        "windows_over": int(np.sum(windows > asked.window)),
        "start": float(np.median(start)),
        "start_worst": float(np.max(start)),
        "after": float(np.median(after)) if after.size else None,
        "asked": asked._asdict(),
    }
    # of drawn joints the median is one of different joints; each is asked to be never worse all the same
    checks = {
        "settled": row["settled"] >= asked.settled and row["settled_worst"] >= WORST_SETTLED,
        "window": row["worst_window"] <= asked.window,
        "start": row["start"] <= asked.start and (asked.start == np.inf or row["start_worst"] <= 1.0),
        "after": row["after"] is None or row["after"] <= asked.after,
    }
    return {**row, "missed": [check for check, met in checks.items() if not met]}


HEADINGS = (
    "situation",
    "n",
    "pi, mrad/s or mrad",
    "pi / own (least)",
    "worse",
    "worst window",
    "over",
    "start (worst)",
    "after change",
    "missed",
)


def table_of(rows: list[dict[str, Any]], title: str) -> Table:
    """Return the rows as a table for a terminal.

    *worse* counts references whose settled error of PI over the controller's is below what is asked of each, *over*
    those with a window above its limit.
    """
    table = Table(title=title, box=SIMPLE, title_style="bold")
    for heading in HEADINGS:
        table.add_column(heading, justify="left" if heading in ("situation", "missed") else "right", no_wrap=True)
    for row in rows:
        asked = row["asked"]
        table.add_row(
            row["situation"],
            str(row["references"]),
            f"{1e3 * row['pi']:.3g}",
            f"{row['settled']:.2f} ({row['settled_worst']:.2f}) >= {asked['settled']:g}",
            str(row["settled_under"]),
            f"{row['worst_window']:.2f}" + _limit(asked["window"]),
            str(row["windows_over"]),
            f"{row['start']:.2f} ({row['start_worst']:.2f})" + _limit(asked["start"]),
            "-" if row["after"] is None else f"{row['after']:.2f}" + _limit(asked["after"]),
            ", ".join(row["missed"]),
            style="red" if row["missed"] else None,
        )
    return table


def _limit(value: float) -> str:
    return "" if np.isinf(value) else f" <= {value:g}"


def _written(value: Any) -> Any:
    """Return a row as JSON can hold it: what is infinite, such as a limit that is not asked for, is null."""
    if isinstance(value, dict):
        return {name: _written(part) for name, part in value.items()}
    return None if isinstance(value, float) and not np.isfinite(value) else value


def rows_of(
    cases: list[Case],
    controller: str,
    draws: int,
    pool: Executor,
    watch: Callable[[Iterable[Judgement], int], Iterable[Judgement]],
) -> list[dict[str, Any]]:
    """Judge all cases and return a row for each name, in their order."""
    count = len(cases)
    found = list(watch(pool.map(judge_case, cases, [controller] * count, [draws] * count), count))
    names = dict.fromkeys(case.name for case in cases)
    return [row_of(name, [f for case, f in zip(cases, found, strict=True) if case.name == name]) for name in names]


def main(
    scenario: Annotated[
        list[str] | None, typer.Option(help="Scenario of the matrix, or another row; may be repeated.")
    ] = None,
    every: Annotated[bool, typer.Option("--every", help="All scenarios of the matrix, and all other rows.")] = False,
    joints: Annotated[int, typer.Option(min=0, help="Number of joints to draw as well.")] = 0,
    machines: Annotated[int, typer.Option(min=0, help="Number of machines to draw over decades as well.")] = 0,
    cascades: Annotated[int, typer.Option(min=0, help="Number of them behind a position loop, with a weight.")] = 0,
    resting: Annotated[int, typer.Option(min=0, help="Number of these with rests of seconds between moves.")] = 0,
    saturating: Annotated[int, typer.Option(min=0, help="Number of joints and machines that saturate untold.")] = 0,
    elastic: Annotated[int, typer.Option(min=0, help="Number of machines with elastic gears, or with play.")] = 0,
    controller: Annotated[str, typer.Option(help="Controller that is judged.")] = "adaptive",
    references: Annotated[int, typer.Option(min=1, help="Number of references of each scenario.")] = 30,
    first_seed: Annotated[int, typer.Option(min=0, help="Seed of the first reference, and of the draws.")] = 1,
    draws: Annotated[int, typer.Option(min=1, help="Draws of the noise for each reference.")] = DRAWS,
    workers: Annotated[int, typer.Option(min=1, help="Processes.")] = os.cpu_count() or 1,
    json: Annotated[Path | None, typer.Option(help="Write the rows there.")] = None,
) -> None:
    """Print how a controller fares against PI, and where what is asked is missed."""
    made = (
        LIGHT_PEAKS,
        TOLD_INERTIAS,
        TOLD_NOTHING,
        DRIVES_UNTOLD,
        SENSOR_FAULTS,
        RIPPLED,
        DATA_SHEETS,
        ENCODERS,
        MAPS,
    )
    known = [*scenario_names(), *(name for table in made for name in table)]
    for option, given, allowed in (("--scenario", scenario or [], known), ("--controller", [controller], CONTROLLERS)):
        for name in given:
            if name not in allowed:
                raise typer.BadParameter(f"{name!r} is not known; there are {', '.join(allowed)}", param_hint=option)
    drawn = joints or machines or cascades or resting or saturating or elastic
    names = known if every else scenario or ([] if drawn else list(SITUATIONS))
    console = wide_console()
    rows: list[dict[str, Any]] = []
    pair = "pi under other noise against pi" if controller == BASELINE else f"{controller} against pi"
    parts = {
        f"{pair}, {references} references of {draws} draws of the noise": named_cases(names, first_seed, references),
        f"{pair} on drawn joints, by fall of friction over Kp": drawn_cases(joints, first_seed),
        f"{pair} on machines drawn over decades, by their friction": machine_cases(machines, first_seed),
        f"position error of {pair} on machines with a weight, behind a position loop": cascade_cases(
            cascades, first_seed
        ),
        f"position error of {pair} on these with rests of 1 to 20 s between moves": resting_cases(resting, first_seed),
        f"{pair} where the drive saturates and tells nothing of it": saturating_cases(saturating, first_seed),
        f"{pair} on machines whose gear is elastic and not told of": elastic_cases(elastic, first_seed),
    }
    with ProcessPoolExecutor(workers) as pool:
        for title, cases in parts.items():
            if not cases:
                continue
            if not rows:
                judge_case(cases[0], controller, 1)  # here, so that workers find the controllers compiled

            def watch(results: Iterable[Judgement], total: int) -> Iterable[Judgement]:
                return track(results, "references", total=total, transient=True, console=Console(stderr=True))

            part = rows_of(cases, controller, draws, pool, watch)
            order = list(CLASSES)
            part.sort(key=lambda row: order.index(row["situation"]) if row["situation"] in CLASSES else -1)
            rows += part
            console.print(table_of(part, title))
    if json is not None:
        write_json(json, {"controller": controller, "rows": [_written(row) for row in rows]})


if __name__ == "__main__":
    typer.run(main)
