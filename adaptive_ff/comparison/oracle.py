"""Feedforward from the true parameters of the moment: as they are, and with the lag that suits the sampled loop.

The true friction lag is not the best one for a torque that is held over a sampling period: on the built-in joint at
100 Hz some 23 ms do better than the true 20 ms. An oracle with the true lag is therefore no bound on what can be
reached. ``oracle_tuned`` adds to the lag what is best for the scenario on other references and other noise, one number
for all seeds. What knows the truth and is tuned to the loop as well is as good as a bound; what remains of its
error is mostly that of the loop without friction, see :mod:`adaptive_ff.comparison.reference_lines`.
"""

from functools import lru_cache, partial

from scipy.optimize import minimize_scalar

from adaptive_ff.baselines.model_based import ModelBased
from adaptive_ff.comparison.own_bandwidth import TUNING_SEEDS, settled_error
from adaptive_ff.friction.model import TorqueModel
from adaptive_ff.scenario.scenario import Scenario
from adaptive_ff.scenario.truth import model_changes, true_model
from adaptive_ff.simulation.experiment import build_setup

LARGEST_ADDED = 2.0
"""Largest lag that may be added, sampling periods; 20 ms beside it, for joints whose lag is no parameter."""

RESOLUTION = 2e-4
"""Resolution of the lag that is found, s; the error hardly changes within it."""


def make_oracle(scenario: Scenario, added: float = 0.0) -> ModelBased:
    """Make the feedforward from the true parameters of every moment, with a lag (s) added to the friction lag.

    It knows the true delay of the drive, too, whatever the feedback assumes.
    """

    def tuned(model: TorqueModel) -> TorqueModel:
        return model._replace(friction_lag=max(0.0, model.friction_lag + added))

    return ModelBased(
        *scenario.feedback.gains,
        scenario.sampling.period,
        tuned(true_model(scenario)),
        [(time, tuned(model)) for time, model in model_changes(scenario)],
        gravity=scenario.joint.weight,
        ripple=(scenario.actuator.ripple_amplitude, scenario.actuator.ripple_period),
        delay=scenario.delay,
        velocity_lag=scenario.velocity_lag,
    )


def suitable_lag(scenario: Scenario) -> float:
    """Return what added to the true friction lag (s) leaves the least settled error on ``TUNING_SEEDS``."""
    return _suitable_lag(scenario.modified(seed=0).model_dump_json(exclude_unset=True))


@lru_cache(maxsize=64)
def _suitable_lag(text: str) -> float:
    scenario = Scenario.model_validate_json(text)
    setups = [build_setup(scenario.modified(seed=seed)) for seed in TUNING_SEEDS]

    def error(added: float) -> float:
        maker = partial(make_oracle, added=float(added))
        return min(1e300, sum(settled_error(scenario, maker, setup) ** 2 for setup in setups))

    lag = true_model(scenario).friction_lag
    bounds = (-lag, LARGEST_ADDED * scenario.sampling.period + 0.02)
    found = minimize_scalar(error, bounds=bounds, method="bounded", options={"xatol": RESOLUTION})
    return float(found.x) if found.fun < error(0.0) else 0.0
