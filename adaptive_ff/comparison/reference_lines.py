"""Where the limits are: the noise floor, which is the error that the same loop has on a joint without friction.

The joint keeps its inertia, payloads and spring, the loop its gains, sensor, drive and reference; friction, loads,
gravity and ripple of the drive are taken away, and the true inertia is fed forward. What remains of the error is due to
noise, sampling, delay and spring. No controller of friction can be expected to do better with the same loop, but for
what friction damps.
"""

from collections.abc import Mapping
from typing import Any

from adaptive_ff.comparison.own import Own
from adaptive_ff.comparison.registry import make_controller, make_oracle
from adaptive_ff.comparison.run import Run, simulate
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.simulation.experiment import RunSetup, build_setup, without_noise

NOISE_FLOOR = "noise_floor"
"""Name of the line in tables."""

SPRING = ("link_share", "link_stiffness", "link_damping")


def frictionless(scenario: Scenario) -> Scenario:
    """Return the scenario of the same loop on a joint without friction, loads, gravity and ripple; payloads stay."""
    joint = scenario.joint
    kept = {name: getattr(joint, name) for name in ("stribeck_velocity", "stribeck_shape", "solver_period", "axis")}
    table: dict[str, Any] = {"kind": "stribeck", "inertia": joint.inertia, **kept}
    table |= {"coulomb": 0.0, "stiction": 0.0, "viscous": 0.0}
    if hasattr(joint, "link_share"):
        table |= {"kind": "elastic", **{name: getattr(joint, name) for name in SPRING}}
    content = scenario.model_dump(exclude_unset=True)
    changes = [{"time": change.time, "inertia_scale": change.inertia_scale} for change in scenario.change]
    content.get("actuator", {}).pop("ripple_amplitude", None)
    return Scenario.model_validate(
        {**{name: part for name, part in content.items() if name != "variation"}, "joint": table, "change": changes}
    )


def noise_floor(scenario: Scenario, setup: RunSetup | None = None, *, noisy: bool = True) -> Run:
    """Run the loop of a scenario on a joint without friction, with the noise and the reference of its set-up.

    Without noise the sensor has neither noise nor the steps of its encoder.
    """
    plain = frictionless(scenario)
    built = build_setup(plain)
    if setup is not None:
        built = built._replace(noise=setup.noise, reference=setup.reference)
    built = built if noisy else without_noise(built)
    return simulate(plain, make_oracle(plain), name=NOISE_FLOOR, setup=built)


def run_by_name(
    scenario: Scenario, name: str, setup: RunSetup, own: Mapping[str, Own] | None = None, thin: int | None = None
) -> Run:
    """Run a controller, own ones and the noise floor included, over a set-up of the scenario."""
    if name == NOISE_FLOOR:
        return noise_floor(scenario, setup)
    made = make_controller(scenario, name, own)
    return simulate(scenario, made, name=name, setup=setup, uncertain=False, thin=thin)
