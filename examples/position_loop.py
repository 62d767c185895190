"""A position loop outside: its output goes to ``correction``, the plan alone to ``reference``.

The joint is ideal; with noise and sticking much less is gained, which ``python -m benchmarks.holding`` measures.
"""

import math

from adaptive_ff import AdaptiveController
from controllers import PI, PositionLoop
from plant import Joint, JointModel

PERIOD, BANDWIDTH, RESOLUTION = 0.005, 10.0, 1e-5
MODEL = JointModel(inertia=20.0, coulomb=60.0, stiction=90.0, viscous=80.0, stribeck_velocity=0.05, friction_lag=0.02)
design = PI.design(inertia=20.0, period=PERIOD, bandwidth=BANDWIDTH)
outer = PositionLoop.design(period=PERIOD, bandwidth=BANDWIDTH)
print(f"position gain {outer.gain:.3g} 1/s")


def planned_position(time):
    """Planned position, rad."""
    return 0.2 * (1.0 - math.cos(2.0 * math.pi * 0.25 * time))


def planned_velocity(time):
    """Its derivative, rad/s."""
    return 0.2 * 2.0 * math.pi * 0.25 * math.sin(2.0 * math.pi * 0.25 * time)


def position_error(controller, duration=30.0):
    """Run a joint behind both loops; return the rms position error of the second half, rad."""
    joint, loop = Joint(MODEL), PositionLoop(outer.gain)
    position, velocity, errors = 0.0, 0.0, []
    for k in range(round(duration / PERIOD)):
        time = k * PERIOD
        measured = RESOLUTION * round(position / RESOLUTION)  # an encoder
        correction = loop.step(planned_position(time), measured)
        torque = controller.step(
            planned_velocity(time), velocity, next_reference=planned_velocity(time + PERIOD), correction=correction
        )
        errors.append(planned_position(time) - position)
        velocity = joint.step(torque, PERIOD)
        position = joint.state.position
    later = errors[len(errors) // 2 :]
    return math.sqrt(sum(error**2 for error in later) / len(later))


alone = position_error(PI(design.proportional, design.integral, PERIOD))
adaptive = position_error(
    AdaptiveController(
        design.proportional, design.integral, PERIOD, inertia=20.0, stribeck_velocity=0.05, torque_limit=math.inf
    )
)
print(f"rms position error: PI {1e3 * alone:.3f} mrad, adaptive {1e3 * adaptive:.3f} mrad")
