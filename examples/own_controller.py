"""Compare an own controller: any class with a method step, beside PI, the oracle and the adaptive controller."""

import math

from adaptive_ff import compare, load_scenario


class CoulombFeedforward:
    """PI plus a guess of Coulomb friction along the reference; its feedforward is recorded and drawn."""

    estimates = {"coulomb": 60.0}  # noqa: RUF012 - constant, but a learner would change it

    def __init__(self, proportional, integral, period):
        self.proportional, self.integral, self.period = proportional, integral, period
        self.sum = self.feedforward = 0.0

    def step(self, reference, velocity, *, next_reference, **_):
        """Return the torque, N m."""
        error = reference - velocity
        self.sum += self.integral * self.period * error
        self.feedforward = self.estimates["coulomb"] * math.tanh(next_reference / 0.01)
        return self.proportional * error + self.sum + self.feedforward


if __name__ == "__main__":
    scenario = load_scenario().modified(duration=20.0, controllers=["pi", "oracle", "adaptive"])
    comparison = compare(scenario, own={"mine": CoulombFeedforward})
    print(comparison)
    print({name: round(gain, 2) for name, gain in comparison.improvement.items()})
    comparison.plot("results/own_controller")
    # on all scenarios of the package: adaptive-ff matrix --own examples/own_controller.py:CoulombFeedforward
