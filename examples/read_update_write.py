"""A group of joints in a cycle of read, update and write, as robot middleware such as ros2_control runs it.

The middleware owns the clock and the named interfaces; an activated controller takes over without a jump.
"""

import math
import random

from adaptive_ff import JointGroup
from controllers import PI
from plant import Joint, JointModel

PERIOD, NAMES, INERTIA = 0.01, ("left", "right"), 20.0
gains = PI.design(inertia=INERTIA, period=PERIOD, bandwidth=10.0)
settings = {"proportional": gains.proportional, "integral": gains.integral, "inertia": INERTIA}
settings |= {"stribeck_velocity": 0.05, "torque_limit": 400.0, "identify": "offset"}
group = JointGroup.from_table({"period": PERIOD, "joints": dict.fromkeys(NAMES, settings)})
group.warm_up()  # compiles before the first cycle

friction = {"coulomb": 60.0, "stiction": 90.0, "viscous": 80.0, "stribeck_velocity": 0.05}
drives = {name: Joint(JointModel(inertia=INERTIA, **friction)) for name in NAMES}  # stand for the machine
state = {f"{name}/velocity": 0.0 for name in NAMES}
command = {f"{name}/effort": 0.0 for name in NAMES}


def plan(time):
    """Planned velocities, rad/s."""
    return [0.3 * math.sin(1.5 * time), 0.4 * math.sin(1.1 * time)]


def read(elapsed):
    """Read the state interfaces; here, the joints have moved under the last command."""
    for name, drive in drives.items():
        state[f"{name}/velocity"] = drive.step(command[f"{name}/effort"], elapsed)


def update(time, elapsed):
    """Return the efforts for the coming period."""
    return group.step(plan(time), list(state.values()), next_reference=plan(time + PERIOD), dt=elapsed)


def write(efforts):
    """Write the command interfaces."""
    command.update({f"{name}/effort": float(effort) for name, effort in zip(NAMES, efforts, strict=True)})


read(PERIOD)
group.take_over(list(command.values()), plan(0.0), list(state.values()))
time, errors = 0.0, []
while time < 40.0:
    elapsed = random.choice((0.009, 0.01, 0.011))  # the clock of a real machine
    time += elapsed
    read(elapsed)
    errors.append([target - value for target, value in zip(plan(time), state.values(), strict=True)])
    write(update(time, elapsed))
for name, first, last in zip(NAMES, zip(*errors[:500], strict=True), zip(*errors[-500:], strict=True), strict=True):
    before, after = (1e3 * math.sqrt(sum(value**2 for value in part) / len(part)) for part in (first, last))
    print(f"{name}: rms error {before:.2f} mrad/s in the first cycles, {after:.2f} in the last")
