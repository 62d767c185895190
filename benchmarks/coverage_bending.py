"""How honest intervals of ``identify`` are where bristles bend over a path: ``python -m benchmarks.coverage_bending``.

Joints whose friction follows the path since a reversal, not the time: Dahl's bristles, those of LuGre with a stiction,
and four Maxwell elements side by side, along a sum of sines that is prescribed, with gravity in half of them. Recorded
are an encoder's position and the torque with noise. Log N over a path is the same in every run.
"""

import math
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer
from numpy.typing import NDArray
from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff.files import write_json
from adaptive_ff.logs.log import Log
from benchmarks.coverage import NAMES, Case, examine
from benchmarks.wide import wide_console
from controllers import compiled

Array = NDArray[np.float64]

FINE = 5000.0
"""Rate at which bristles are integrated, Hz, at least."""

FIRST_SEED = 20_001
"""Seed of the first log; no constant was chosen on it, which was done on seeds 1 to 200."""

PATHS = (0.0005, 0.002, 0.004, 0.008, 0.02)
"""Paths over which bristles bend, rad: of Maxwell elements the mean of those over which they slip."""

SLIPS = (0.3, 1.0, 2.0, 4.0)
"""Paths over which the four elements slip, one to another."""

KINDS = ("Dahl", "LuGre", "Maxwell")


class Bristles(NamedTuple):
    """Coulomb friction and stiction, N m, Stribeck velocity, rad/s, the path, rad, and whether it is of elements."""

    coulomb: float
    stiction: float
    slow: float
    path: float
    elements: bool


def _write_bent(velocity: Array, step: float, bristles: Bristles, made: Array) -> None:
    """Write the friction of bristles, ``dz/dt = w - |w| z Fc/(path g(w))``, with exact steps at a given velocity."""
    bent, coulomb = 0.0, bristles.coulomb
    for k in range(velocity.size):
        speed = abs(velocity[k])
        level = coulomb + (bristles.stiction - coulomb) * math.exp(-speed / bristles.slow)
        end = math.copysign(level, velocity[k])
        bent = end + (bent - end) * math.exp(-speed * step * coulomb / (bristles.path * level))
        made[k] = bent


def _write_slipping(velocity: Array, step: float, coulomb: float, paths: Array, loads: Array, made: Array) -> None:
    """Write the friction of elements that stick and slip, each over its own path, with equal shares."""
    for k in range(velocity.size):
        total = 0.0
        for i in range(paths.size):
            loads[i] = min(max(loads[i] + velocity[k] * step / paths[i], -1.0), 1.0)
            total += loads[i]
        made[k] = coulomb * total / paths.size


write_bent, write_slipping = compiled(_write_bent), compiled(_write_slipping)


def friction_of(bristles: Bristles, velocity: Array, step: float) -> Array:
    """Return the friction without its viscous part along a velocity (rad/s), N m."""
    made = np.empty_like(velocity)
    if bristles.elements:
        paths = bristles.path * np.array(SLIPS) / np.mean(SLIPS)
        write_slipping(velocity, step, bristles.coulomb, paths, np.zeros(paths.size), made)
    else:
        write_bent(velocity, step, bristles, made)
    return made


def make_case(seed: int, path: float) -> Case:
    """Draw a joint of a path (rad), its motion and its sensors; joints of all paths are alike but for it."""
    random = np.random.default_rng([seed, 81])

    def between(low: float, high: float) -> float:
        return float(low * (high / low) ** random.random())

    rate, duration = float(random.choice([100.0, 250.0, 500.0, 1000.0])), float(random.uniform(20.0, 60.0))
    fine = rate * math.ceil(FINE / rate)
    time = np.arange(round(duration * fine)) / fine
    omegas = 2.0 * np.pi * np.array([between(0.1, 1.5) for _ in range(random.integers(3, 6))])
    angle = np.outer(omegas, time) + random.uniform(0.0, 2.0 * np.pi, omegas.size)[:, np.newaxis]
    sizes = random.uniform(0.3, 1.0, omegas.size) / omegas
    sizes *= between(0.2, 1.5) / float(np.ptp(sizes @ np.sin(angle)))
    position, velocity = sizes @ np.sin(angle), (sizes * omegas) @ np.cos(angle)
    acceleration = -(sizes * omegas**2) @ np.sin(angle)
    inertia = between(0.1, 10.0)
    coulomb = inertia * float(np.std(acceleration)) * between(0.3, 3.0)
    peak = float(np.max(np.abs(velocity)))
    viscous = coulomb / peak * between(0.2, 1.5)
    kind = KINDS[seed % 3]
    stiction = coulomb * random.uniform(1.1, 1.5) if kind == "LuGre" else coulomb
    bristles = Bristles(coulomb, stiction, between(0.02, 0.1) * peak, path, kind == "Maxwell")
    gravity = coulomb * between(0.2, 2.0) if random.random() < 0.5 else 0.0
    torque = inertia * acceleration + friction_of(bristles, velocity, 1.0 / fine) + viscous * velocity
    torque += coulomb * random.uniform(-0.2, 0.2) + gravity * np.sin(position + random.uniform(0.0, 2.0 * np.pi))
    kept = slice(round(fine), None, round(fine / rate))
    counts, noise = 2.0 ** random.integers(13, 21), float(np.std(torque)) * between(0.005, 0.03)
    position = np.round(position[kept] * counts / (2.0 * np.pi)) * (2.0 * np.pi / counts)
    measured = torque[kept] + noise * random.standard_normal(position.size)
    log = Log(f"{kind} {seed}, {1e3 * path:g} mrad", time[kept], measured, position=position)
    truth = {"inertia": inertia, "coulomb": coulomb, "viscous": viscous, "friction_lag": 0.0}
    return Case(log, truth, duration, True, (), noise)


def main(
    logs: Annotated[int, typer.Option(min=1, help="Number of logs of each path.")] = 60,
    first: Annotated[int, typer.Option(min=0, help="Seed of the first log.")] = FIRST_SEED,
    json: Annotated[Path | None, typer.Option(help="Write all results there.")] = None,
) -> None:
    """Print by the path how often intervals hold the truth, how wide they are, and how far off values are."""
    table = Table(title=f"Stated 95 % intervals, {logs} logs of each path", box=SIMPLE)
    headings = ("path, mrad", "refused", *(f"{name}: held, half width, error" for name in NAMES), "path found")
    for heading in headings:
        table.add_column(heading, justify="right")
    whole: list[dict[str, Any]] = []
    for path in PATHS:
        results = [{**examine(make_case(seed, path)), "path": path} for seed in range(first, first + logs)]
        table.add_row(*cells_of(path, results))
        whole += results
    wide_console().print(table)
    if json is not None:
        write_json(json, {"logs": whole})


def cells_of(path: float, results: list[dict[str, Any]]) -> list[str]:
    """Return the cells of a row."""
    found = [result for result in results if result["refused"] is None]
    cells = [f"{1e3 * path:g}", f"{len(results) - len(found)}"]
    for name in NAMES:
        each = [result[name] for result in found]
        held = 100.0 * np.mean([one["covers"] for one in each])
        width, error = (
            100.0 * float(np.median(series))
            for series in ([one["half_width"] for one in each], [abs(one["error"]) for one in each])
        )
        cells.append(f"{held:.0f} %, {width:.1f} %, {error:.1f} %")
    return [*cells, f"{sum('presliding' in result['terms'] for result in found)}"]


if __name__ == "__main__":
    typer.run(main)
