"""Joints whose friction varies over position or load, and the map of it that the controller is to learn."""

import math
from typing import Any, NamedTuple

import numpy as np

from adaptive_ff import Scenario, load_scenario
from adaptive_ff.scenario.library import SCENARIOS


class Row(NamedTuple):
    """One joint, and the map that is tried on it."""

    key: str  # key, name: short name, and what varies
    name: str
    scenario: Scenario  # what is run
    periods: tuple[float, ...] = ()  # known periods, rad
    # hats, spacing: number of hats over the planned range, or the distance between them, rad, where the number is
    # zero
    hats: int = 0
    spacing: float = 0.0
    load: bool = False  # whether friction may depend on the known torque


def rows(seconds: float = 60.0) -> list[Row]:
    """Return the rows of the table, for runs of a duration (s); friction that drops has its own."""
    plain = load_scenario().modified(duration=seconds)

    def over(period: float) -> Scenario:
        return plain.modified(variation={"position_amplitude": 0.3, "position_period": period})

    short, long = over(0.3), over(2.0)
    gravity, drop = plain.modified(joint={"gravity": 40.0}), load_scenario(SCENARIOS / "friction_drops.toml")
    loaded = plain.modified(joint={"gravity": 100.0}, adaptation={"identify": "gravity"})
    shared = loaded.modified(variation={"load_share": 0.005})
    return [
        Row("map_short_period", "30 % over 0.3 rad, period known", short, (0.3,)),
        Row("map_short_hats", "30 % over 0.3 rad, hats of 0.06 rad", short, spacing=0.06),
        Row("map_long_period", "30 % over 2 rad, period known", long, (2.0,)),
        Row("map_long_hats_13", "30 % over 2 rad, 13 hats", long, hats=13),
        Row("map_long_hats_25", "30 % over 2 rad, 25 hats", long, hats=25),
        Row("map_no_need_period", "no variation, period of 0.3 rad", plain, (0.3,)),
        Row("map_no_need_hats_25", "no variation, 25 hats", plain, hats=25),
        Row("map_no_need_hats", "no variation, hats of 0.06 rad", plain, spacing=0.06),
        Row("map_gravity_40_hats_25", "gravity 40 sin q not modelled, 25 hats", gravity, hats=25),
        Row("map_friction_drops_hats_25", "friction drops by 40 %, 25 hats", drop, hats=25),
        Row("map_load", "0.5 % per N m of gravity 100 sin q", shared, load=True),
        Row("map_no_need_load", "gravity 100 sin q, no share", loaded, load=True),
    ]


def told(row: Row, seed: int) -> Scenario:
    """Return the scenario of a row and a seed in which ``adaptive`` has the map; its range is that of the plan."""
    scenario = row.scenario.modified(seed=seed)
    assumed: dict[str, Any] = {"position_periods": list(row.periods), "load_friction": row.load}
    if row.hats or row.spacing:
        position = np.cumsum(scenario.reference_velocity()) * scenario.joint.solver_period
        lowest, highest = float(np.min(position)), float(np.max(position))
        hats = row.hats or math.ceil((highest - lowest) / row.spacing) + 1
        assumed |= {"position_hats": hats, "position_range": [lowest, highest]}
    return scenario.modified(adaptation=assumed)


MAPS = {row.key: row for row in rows()}
MAPS |= {
    "no_map_short": MAPS["map_short_period"]._replace(periods=()),
    "no_map_long": MAPS["map_long_period"]._replace(periods=()),
}
"""Joints on which ``adaptive`` has a map of friction over position or load, by name, and two of them without."""
