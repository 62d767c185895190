"""Cascades that move from point to point and then hold: how near to the path, how calm at rest.

``python -m benchmarks.holding [--seeds N] [--only TEXT] [--controllers pi,adaptive] [--json FILE]``

Every joint moves between drawn points for a minute, comes to rest after each move, and then holds its position. The
position loop has the default gain, a sixth of the bandwidth of the velocity loop, 10 Hz; an encoder of 6 urad measures
the position, and the velocity is made of it. Figures are root mean squares over all seeds:

- *position*: planned minus true position over the second half of the moves, rad; first that of PI over it;
- *velocity at rest*: true velocity over the last 10 s, rad/s; the plan has been at rest for 2 s then;
- *torque steps at rest*: differences of the drive's torque between samples over the same time, N m.

At rest 1.2 times the figure of PI is allowed or, where PI is quieter than that, one encoder count in a sampling period
(rad/s) and 0.1 N m.
"""

import json as json_module
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import typer

from adaptive_ff import Run, Scenario, load_scenario, simulate

RESOLUTION = 6e-6  # rad
MOVING, SETTLING, HOLDING = 60.0, 2.0, 10.0  # s
RATES = (100, 500, 1000)  # Hz
HEAVY = {"inertia": 20.0, "coulomb": 60.0, "stiction": 90.0, "viscous": 80.0}
LIGHT = {"inertia": 2.0, "coulomb": 10.0, "stiction": 12.0, "viscous": 5.0}
STIFFNESSES = (1e3, 1e4, 2e4, 1e5)  # N m/rad
QUIET_TORQUE = 0.1  # N m


class Case(NamedTuple):
    """A joint at a sampling rate.

    Attributes
    ----------
    name : str
        What the table calls it.
    joint : dict
        Table ``[joint]``.
    rate : int
        Sampling rate, Hz.
    required : float or None
        Ratio of the position errors that is aimed at; None where none is.
    """

    name: str
    joint: dict[str, Any]
    rate: int
    required: float | None


def cases() -> Iterable[Case]:
    """Return all joints at all rates."""
    for rate in RATES:
        for inertia, friction in (("20", HEAVY), ("2", LIGHT)):
            base = {**friction, "stribeck_velocity": 0.05, "solver_period": 5e-4}
            kinds: dict[str, tuple[dict[str, Any], dict[int, float]]] = {
                "coulomb": ({"stiction": friction["coulomb"], "friction_lag": 0.0}, {100: 6.0, 500: 12.0}),
                "lagged": ({"friction_lag": 0.02}, {100: 6.0, 500: 12.0}),
            }
            for stiffness in STIFFNESSES:
                own = {"kind": "lugre", "stiffness": stiffness}
                stiff = {100: 4.0, 500: 5.0} if stiffness >= 2e4 else {100: 2.0, 500: 2.0}
                kinds[f"LuGre {stiffness:.0e}"] = (own, stiff)
            for kind, (own, required) in kinds.items():
                yield Case(f"{kind}, {inertia} kg m^2, {rate} Hz", {**base, **own}, rate, required.get(rate))


def plan(seed: int) -> dict[str, Any]:
    """Draw the table ``[reference]`` of a minute of moves between drawn points."""
    generator = np.random.default_rng([seed, 77])
    speed, positions = float(generator.uniform(0.1, 0.4)), []
    elapsed, position = 0.0, 0.0
    while elapsed < MOVING - 5.0:
        following = round(float(generator.uniform(-0.5, 0.5)), 3)
        elapsed += abs(following - position) / speed + speed / 1.0 + 1.0 / 20.0 + 0.5
        positions.append(following)
        position = following
    return {
        "kind": "point_to_point",
        "positions": positions,
        "speed": speed,
        "acceleration": 1.0,
        "jerk": 20.0,
        "dwell": 0.5,
        "repeats": 1,
    }


def scenario_of(case: Case, seed: int) -> Scenario:
    """Return the cascade of a case."""
    inertia = case.joint["inertia"]
    return load_scenario().modified(
        seed=seed,
        duration=MOVING + SETTLING + HOLDING,
        joint={**case.joint, "kind": case.joint.get("kind", "stribeck")},
        sampling={"period": 1.0 / case.rate},
        sensor={"velocity_noise": 0.0, "encoder_resolution": RESOLUTION},
        actuator={"torque_limit": 20.0 * inertia},
        reference=plan(seed),
        position={},
        feedback={"inertia": inertia, "bandwidth": 10.0},
        controllers=["pi", "adaptive"],
    )


def squares(run: Run) -> dict[str, float]:
    """Return the mean squares of a run: position error, velocity at rest, torque steps at rest."""
    assert run.position_error is not None
    last_motion = float(run.solver_time[np.flatnonzero(run.reference)[-1]])
    moving = (run.solver_time >= 0.5 * last_motion) & (run.solver_time <= last_motion)
    rest = run.solver_time[-1] - HOLDING
    return {
        "position": float(np.mean(run.position_error[moving] ** 2)),
        "velocity": float(np.mean(run.velocity[run.solver_time >= rest] ** 2)),
        "steps": float(np.mean(np.diff(run.torque[run.time >= rest]) ** 2)),
    }


def measure(case: Case, seeds: Iterable[int], controllers: Iterable[str]) -> dict[str, dict[str, float]]:
    """Return the root mean squares over the seeds, by controller and name."""
    found: dict[str, dict[str, float]] = {}
    scenarios = [scenario_of(case, seed) for seed in seeds]
    for name in controllers:
        each = [squares(simulate(scenario, name)) for scenario in scenarios]
        found[name] = {key: math.sqrt(float(np.mean([one[key] for one in each]))) for key in each[0]}
    return found


def allowed(pi: dict[str, float], rate: int) -> dict[str, float]:
    """Return what is allowed at rest: velocity (rad/s) and torque steps (N m)."""
    return {
        "velocity": max(1.2 * pi["velocity"], RESOLUTION * rate),
        "steps": max(1.2 * pi["steps"], QUIET_TORQUE),
    }


def verdict(case: Case, pi: dict[str, float], own: dict[str, float]) -> str:
    """Return what is missed, in a few words; "ok" where nothing is."""
    limits = allowed(pi, case.rate)
    missed = [f"{name} at rest" for name, limit in limits.items() if own[name] > limit]
    if case.required is not None and pi["position"] < case.required * own["position"]:
        missed.append(f"position x{case.required:g}")
    return ", ".join(missed) or "ok"


def main(
    seeds: Annotated[int, typer.Option(min=1, help="Number of seeds, from the first on.")] = 5,
    first: Annotated[int, typer.Option(min=0, help="First seed.")] = 1,
    only: Annotated[str, typer.Option(help="Cases whose name holds this text.")] = "",
    controllers: Annotated[str, typer.Option(help="Controllers, beside pi.")] = "adaptive",
    json: Annotated[Path | None, typer.Option(help="Write the figures to a JSON file.")] = None,
) -> None:
    """Print one line a case and controller."""
    result, others = {}, [name for name in controllers.split(",") if name != "pi"]
    heads = ("x PI", "position", "velocity at rest", "allowed", "steps at rest", "allowed")
    print(f"{'case':32s} {'controller':22s} " + " ".join(f"{head:>16s}" for head in heads))
    print(f"{'':55s} " + " ".join(f"{unit:>16s}" for unit in ("", "mrad", "mrad/s", "mrad/s", "N m", "N m")))
    for case in cases():
        if only not in case.name:
            continue
        found = measure(case, range(first, first + seeds), ["pi", *others])
        result[case.name] = found
        limits = allowed(found["pi"], case.rate)
        for name, own in found.items():
            values = (
                found["pi"]["position"] / own["position"],
                1e3 * own["position"],
                1e3 * own["velocity"],
                1e3 * limits["velocity"],
                own["steps"],
                limits["steps"],
            )
            text = "" if name == "pi" else verdict(case, found["pi"], own)
            print(f"{case.name:32s} {name:22s} " + " ".join(f"{value:16.4g}" for value in values) + f"  {text}")
    if json is not None:
        json.write_text(json_module.dumps({"seeds": [first, seeds], "cases": result}, indent=1) + "\n")


if __name__ == "__main__":
    typer.run(main)
