"""Models identified once, before the run that they are used in: a calibration run of the PI loop, then ``identify``.

The calibration run is the scenario's own joint, sensor, drive and kind of reference with another seed, for 120 s,
before its friction changes. Only what can be measured takes part: the velocity and the torque of the drive. A joint
under PI sticks at the reversals, which are what shows the friction lag; so the lag is the one with which the same loop,
simulated without noise around the identified joint, moves as measured (closed-loop output error, A. Janot, M. Gautier,
P.-O. Vandanjon 2013, with the velocity in place of the torque).
"""

import math
from functools import lru_cache

import numpy as np
from scipy.optimize import minimize_scalar

from adaptive_ff.comparison.own_bandwidth import plain_pi
from adaptive_ff.comparison.running import drive_over
from adaptive_ff.friction.bounds import largest_lag
from adaptive_ff.friction.model import TorqueModel
from adaptive_ff.identify.identification import identify_log
from adaptive_ff.logs.log import Log
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.simulation.experiment import RunSetup, build_setup, without_noise
from plant import Gravity, JointModel, schedule

DURATION = 120.0
"""Length of the calibration run, s."""

OTHER_SEED = 1_000_000
"""Added to the seed of the scenario."""

LAG_STEP = 0.01
"""Resolution of the friction lag, in time constants ``J/Kp`` of the feedback."""


def identify_joint(scenario: Scenario) -> TorqueModel:
    """Identify a scenario's joint in a calibration run; ``InputError`` where that does not move enough."""
    other = scenario.modified(seed=(scenario.seed + OTHER_SEED) % 2**63, duration=DURATION, change=[])
    return _identified(other.model_dump_json())


@lru_cache(maxsize=32)
def _identified(text: str) -> TorqueModel:
    """Return the model of a scenario given as JSON text."""
    scenario = Scenario.model_validate_json(text)
    setup = build_setup(scenario)
    run, _ = drive_over(plain_pi(scenario), setup)
    time = setup.samples[:-1] * np.float64(setup.solver_period)
    log = Log("calibration run", time, run.torque, velocity=run.measured)
    found = identify_log(log, torque_delay=0.5 * scenario.sampling.period, model="symmetric").torque_model()
    response = scenario.feedback.inertia / scenario.feedback.gains[0]

    def error(lag: float) -> float:
        try:
            modelled = _modelled(scenario, setup, found._replace(friction_lag=float(lag)))
        except ValueError:  # the solver period does not suit it
            return math.inf
        return float(np.mean((drive_over(plain_pi(scenario), modelled)[0].measured - run.measured) ** 2))

    ends = (0.0, largest_lag(response))
    search = minimize_scalar(error, bounds=ends, method="bounded", options={"xatol": LAG_STEP * response})
    return found._replace(friction_lag=float(search.x) if search.fun < error(0.0) else 0.0)


def _modelled(scenario: Scenario, setup: RunSetup, model: TorqueModel) -> RunSetup:
    """Return the setup with a modelled joint, without noise and gravity."""
    joint = JointModel(
        **{name: getattr(model, name) for name in JointModel.model_fields if name in model._fields},
        solver_period=scenario.joint.solver_period,
    )
    return without_noise(setup)._replace(
        joint=joint.parameters,
        plan=schedule([], joint.solver_period),
        actuator=setup.actuator._replace(gain=1.0),  # the torque that the drive reports is all that is known of it
        gravity=Gravity(0.0, 0.0),
    )
