"""An arm in MuJoCo, each joint identified while it works; gravity is learnt. Needs ``pip install mujoco``."""

import math

import mujoco
import numpy as np

from adaptive_ff import JointGroup
from controllers import PI

PERIOD, SUBSTEPS = 0.002, 4
model = mujoco.MjModel.from_xml_string("""
<mujoco><option timestep="0.0005"/><worldbody><body pos="0 0 1" euler="0 40 0">
  <joint name="shoulder" axis="0 1 0" armature="4" damping="20" frictionloss="25"/>
  <geom type="capsule" fromto="0 0 0 0 0 -0.6" size="0.06" mass="12"/>
  <body pos="0 0 -0.6" euler="0 40 0">
    <joint name="elbow" axis="0 1 0" armature="1.5" damping="8" frictionloss="12"/>
    <geom type="capsule" fromto="0 0 0 0 0 -0.5" size="0.05" mass="6"/>
  </body></body></worldbody></mujoco>
""")
INERTIA = {"shoulder": 10.0, "elbow": 2.0}  # kg m^2, roughly


def joint(name):
    """Settings of a joint: gains by design, and which joints stand between it and the base."""
    gains = PI.design(inertia=INERTIA[name], period=PERIOD, bandwidth=8.0)
    settings = {"proportional": gains.proportional, "integral": gains.integral, "inertia": INERTIA[name]}
    settings |= {"stribeck_velocity": 0.05, "torque_limit": math.inf}  # the drives give all they are asked for
    return settings | {"preceding": ["shoulder"] if name == "elbow" else []}


def plan(time):
    """Planned velocities, rad/s."""
    wave = np.array([0.5 * math.sin(2.0 * time), 0.8 * math.sin(3.1 * time)])
    return min(time, 1.0) * wave


def run(feeds):
    """Drive the arm for 30 s; return the rms error of the last 10 s for each joint, rad/s."""
    group = JointGroup.from_table({"period": PERIOD, "joints": {name: joint(name) for name in INERTIA}})
    for controller in group.joints.values():
        controller.enabled = controller.feedforward_enabled = feeds
    data, errors = mujoco.MjData(model), []
    for k in range(round(30.0 / PERIOD)):
        reference, following = plan(k * PERIOD), plan((k + 1) * PERIOD)
        errors.append(reference - data.qvel)
        data.qfrc_applied[:] = group.step(reference, data.qvel, next_reference=following, position=data.qpos)
        mujoco.mj_step(model, data, SUBSTEPS)
    return np.sqrt(np.mean(np.array(errors[-round(10.0 / PERIOD) :]) ** 2, axis=0)), group


alone, _ = run(False)
adaptive, group = run(True)
for name, before, after in zip(INERTIA, alone, adaptive, strict=True):
    print(
        f"{name}: rms error {1e3 * before:.2f} mrad/s with PI alone, {1e3 * after:.2f} with friction and gravity learnt"
    )
print({name: round(values["coulomb"], 1) for name, values in group.estimates.items()})
