"""A joint that sticks at its reversals without any stiction, under a loop whose torque is held for a period."""

import numpy as np

from adaptive_ff.logs.log import Log


def dry_joint_log(seed, rate=500.0, duration=30.0, fine=40, inertia=2.0, noise=0.02):
    """A log under PI of a joint that sticks whenever the torque is below Coulomb friction, and what it is made of.

    Inertia in kg m^2, noise of the torque over Coulomb friction.

    Steps of Euler, 20 kHz, each of which ends a motion that would turn within it; nothing of the package's plant.
    """
    random = np.random.default_rng(seed)
    joint = {"inertia": inertia, "coulomb": random.uniform(1.0, 8.0), "viscous": random.uniform(1.0, 4.0)}
    omegas = 2.0 * np.pi * random.uniform(0.1, 1.5, 4)
    phases, sizes = random.uniform(0.0, 2.0 * np.pi, 4), 0.4 * (omegas / (2.0 * np.pi)) ** -0.5
    time = np.arange(round(duration * rate)) / rate
    angles = np.outer(time, omegas) + phases
    planned, aim = np.sin(angles) @ sizes, -np.cos(angles) @ (sizes / omegas)
    loop, step = 2.0 * np.pi * 5.0, 1.0 / (rate * fine)
    velocity, place = 0.0, float(aim[0])
    torque, position = np.empty(time.size), np.empty(time.size)
    for k, (wanted, goal) in enumerate(zip(planned.tolist(), aim.tolist(), strict=True)):
        position[k] = place
        torque[k] = drive = joint["inertia"] * loop * (wanted - velocity + 0.3 * loop * (goal - place))
        for _ in range(fine):
            if velocity == 0.0 and abs(drive) <= joint["coulomb"]:
                break
            way = velocity if velocity != 0.0 else drive
            dry = joint["coulomb"] if way > 0.0 else -joint["coulomb"]
            after = velocity + step * (drive - dry - joint["viscous"] * velocity) / joint["inertia"]
            velocity = 0.0 if after * velocity < 0.0 else after
            place += step * velocity
    torque += noise * joint["coulomb"] * random.standard_normal(time.size)
    position += 2e-6 * random.standard_normal(time.size)
    return Log("dry", time, torque, position), joint
