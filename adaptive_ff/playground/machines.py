"""What the page shows: machines, motions, and what its sliders change in a scenario."""

import math
import tomllib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from adaptive_ff.scenario.axis_units import axis_unit
from adaptive_ff.scenario.new import new_scenario_text
from adaptive_ff.scenario.reference import Multisine
from adaptive_ff.scenario.scenario import Scenario, load_scenario, parse_scenario
from controllers import fastest_bandwidth

Tables = dict[str, Any]
"""Values by table and field, as :meth:`Scenario.modified` takes them."""

STOPS = 20
"""Steps of a slider."""

TEXTS = {
    "inertia": ("kg m²", "true inertia; both loops are designed for {:g}"),
    "mass": ("kg m²", "true mass; both loops are designed for {:g}"),
    "Coulomb friction": ("N m", "friction that sliding has at every speed"),
    "stiction": ("N m", "friction at which the joint breaks away from rest"),
    "friction lag": ("ms", "time by which friction follows velocity"),
    "bandwidth": ("Hz", "crossover that both loops are designed for"),
    "noise": ("rad/s", "of the measured velocity, standard deviation"),
    "encoder": ("counts/turn", "the velocity is made of its readings"),
    "load step": ("N m", "constant load from half-time on"),
    "gravity": ("N m", "weight of the arm, times the sine of its position"),
}
"""Unit and meaning of each slider; ``{:g}`` is the value that it begins with."""


@dataclass(frozen=True)
class Slider:
    """One value of a scenario that a reader may change."""

    name: str  # its name, its unit, and what it means in one line
    unit: str
    says: str
    stops: tuple[float, ...]  # values that it may have, as they are shown
    start: int  # stop at which it begins, where the scenario is as it was
    tables: Callable[[float], Tables]  # what a value changes in the scenario
    beside: Tables = field(default_factory=dict)  # what must hold in the scenario for all stops to be possible

    def changed(self, stop: int) -> Tables:
        """Return what a stop changes in the scenario; nothing where the slider begins."""
        return {} if stop == self.start else self.tables(self.stops[stop])


@dataclass(frozen=True)
class Machine:
    """A scenario with its sliders."""

    name: str
    scenario: Scenario
    sliders: tuple[Slider, ...]

    @property
    def peak(self) -> float:
        """Largest velocity of every motion, rad/s."""
        assert isinstance(self.scenario.reference, Multisine)
        assert self.scenario.reference.peak is not None
        return self.scenario.reference.peak

    @property
    def motions(self) -> dict[str, Tables]:
        """Reference of each motion by its name; the first is that of the scenario."""
        peak = self.peak
        return {
            "multisine": self.scenario.model_dump(mode="json", exclude_unset=True)["reference"],
            "sine": {"kind": "multisine", "frequencies": [0.25], "amplitudes": [1.0], "peak": peak},
            "point to point": {
                "kind": "point_to_point",
                "distance": 1.5 * peak,
                "speed": peak,
                "acceleration": 4.0 * peak,
                "dwell": 1.0,
            },
        }

    @property
    def tables(self) -> Tables:
        """Content of the scenario file, but for the reference."""
        content = self.scenario.model_dump(mode="json", exclude_unset=True, exclude={"reference"})
        return {**content, "controllers": ["pi", "adaptive"]}

    def modified(self, motion: str, *changes: Tables) -> Scenario:
        """Return the scenario with a motion and with other values."""
        content = {**self.tables, "reference": self.motions[motion]}
        for tables in changes:
            for table, value in tables.items():
                content[table] = {**content.get(table, {}), **value} if isinstance(value, dict) else value
        return parse_scenario(content, self.name)


def _field(table: str, name: str) -> Callable[[float], Tables]:
    return lambda value: {table: {name: value}}


def _around(value: float, least: float, most: float) -> tuple[float, ...]:
    """Return stops between two multiples of a value, half of them on each side of it."""
    factors = np.append(np.geomspace(least, 1.0, STOPS // 2 + 1), np.geomspace(1.0, most, STOPS // 2 + 1)[1:])
    return tuple(float(f"{value * factor:.3g}") for factor in factors.tolist())


def _up_to(most: float) -> tuple[float, ...]:
    """Return even stops from zero on."""
    return tuple(float(f"{most * k / STOPS:.3g}") for k in range(STOPS + 1))


def _with(value: float, stops: tuple[float, ...]) -> tuple[tuple[float, ...], int]:
    """Return stops with a value in the place of the next one to it, and that place."""
    place = min(range(len(stops)), key=lambda k: abs(stops[k] - value))
    return (*stops[:place], value, *stops[place + 1 :]), place


def sliders(scenario: Scenario) -> Iterator[Slider]:
    """Yield the sliders of a scenario: of a joint with lagged Stribeck friction, with a multisine, without changes."""
    joint, sensor, hertz = scenario.joint, scenario.sensor, scenario.feedback.hertz

    def slider(
        name: str, value: float, stops: tuple[float, ...], tables: Callable[[float], Tables], **beside: float
    ) -> Slider:
        unit, says = TEXTS[name]
        placed = _with(value, stops)
        says, given = says.format(value), {"joint": beside} if beside else {}
        return Slider(name, axis_unit(joint.axis, unit), says, *placed, tables, given)

    mass = "mass" if joint.axis == "linear" else "inertia"
    yield slider(mass, joint.inertia, _around(joint.inertia, 0.5, 2.0), _field("joint", "inertia"))
    friction, _ = _with(joint.stiction, _with(joint.coulomb, _up_to(2.0 * joint.stiction))[0])
    yield slider("Coulomb friction", joint.coulomb, friction, _field("joint", "coulomb"), stiction=friction[-1])
    yield slider("stiction", joint.stiction, friction, _field("joint", "stiction"), coulomb=friction[0])
    lag = 1e3 * getattr(joint, "friction_lag", 0.0)
    in_seconds = _field("joint", "friction_lag")
    yield slider("friction lag", lag, _up_to(max(3.0 * lag, 30.0)), lambda value: in_seconds(value / 1e3))
    most = 0.98 * fastest_bandwidth(scenario.sampling.period) / hertz
    yield slider("bandwidth", hertz, _around(hertz, 0.2, most), _field("feedback", "bandwidth"))
    if sensor.encoder_resolution is None:
        noise = sensor.velocity_noise
        yield slider("noise", noise, _up_to(4.0 * noise), _field("sensor", "velocity_noise"))
    else:
        resolution, counts = _field("sensor", "encoder_resolution"), round(2.0 * math.pi / sensor.encoder_resolution)
        powers = tuple(float(2**power) for power in range(9, 19))
        yield slider("encoder", counts, powers, lambda value: resolution(2.0 * math.pi / value))
    half = 0.5 * scenario.length
    loads = _up_to(joint.stiction)
    yield slider("load step", 0.0, loads, lambda value: {"change": [{"time": half, "load": value}]})
    if joint.axis == "rotary":
        yield slider("gravity", 0.0, loads, _field("joint", "gravity"))


def machines() -> list[Machine]:
    """Return the machines of the page: the built-in scenario, a servo of the package, and a belt axis."""
    robot, servo = load_scenario(), load_scenario("servo")
    belt = tomllib.loads(new_scenario_text(10.0, 200.0, 1.0, period=0.01, linear=True))
    axis = parse_scenario({**belt, "reference": {"peak": 0.5}}, "belt axis")
    named = {"robot joint": robot, "servo": servo, "belt axis": axis}
    return [Machine(name, found, tuple(sliders(found))) for name, found in named.items()]
