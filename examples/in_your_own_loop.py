"""The adaptive controller in one's own loop: preview in, torque out, what the drive really gave back in."""

import math

from adaptive_ff import AdaptiveController
from controllers import PI
from plant import Joint, JointModel

PERIOD, LIMIT = 0.01, 400.0
joint = Joint(  # stands for the machine
    JointModel(inertia=20.0, coulomb=60.0, stiction=90.0, viscous=80.0, stribeck_velocity=0.05, friction_lag=0.02)
)
design = PI.design(inertia=20.0, period=PERIOD, bandwidth=10.0)
controller = AdaptiveController(
    design.proportional, design.integral, period=PERIOD, inertia=20.0, stribeck_velocity=0.05
)
controller.warm_up()  # compile or load before real time begins


def plan(time):
    """Planned velocity, rad/s."""
    return 0.3 * math.sin(2.0 * math.pi * 0.25 * time)


velocity, given, errors = 0.0, None, []
for k in range(4000):
    reference, following = plan(k * PERIOD), plan((k + 1) * PERIOD)
    errors.append(reference - velocity)
    torque = controller.step(reference, velocity, next_reference=following, realised_torque=given)
    given = max(-LIMIT, min(LIMIT, torque))
    velocity = joint.step(given, PERIOD)

for begin, end in ((0, 400), (3600, 4000)):  # one period of the motion each
    rms = math.sqrt(sum(error**2 for error in errors[begin:end]) / (end - begin))
    print(f"{begin * PERIOD:g} to {end * PERIOD:g} s: rms error {1e3 * rms:.2f} mrad/s")
print({name: round(value, 3) for name, value in controller.estimates.items()})
