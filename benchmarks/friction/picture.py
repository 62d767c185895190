"""Force over displacement: each law along the same motion, and the measured loop beside each fit."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

import plant
from benchmarks.friction.laws import Fit, PreslidingRecord, force_along

FRICTION = {"inertia": 1e12, "coulomb": 60.0, "stiction": 60.0, "viscous": 0.0, "stribeck_velocity": 0.05}

LAWS = {
    "Coulomb, lag 20 ms": plant.JointModel(**FRICTION, friction_lag=0.02),
    "LuGre": plant.LuGreJoint(**FRICTION, stiffness=1e5, damping=0.0),
    "Maxwell slip": plant.MaxwellJoint(**FRICTION, displacements=[3e-4, 1e-3, 2e-3, 4e-3]),
    "rolling": plant.RollingJoint(**FRICTION, rolling_range=4e-3),
    "elasto-plastic": plant.ElastoPlasticJoint(**FRICTION, presliding=4e-3),
}

PERIOD = 1e-3

SIMULATED, FITTED = "0.15", "C0"
"""Colours of what is simulated along a made-up motion, and of what is fitted to the record."""

DRAWN = 2000  # samples of the record that are drawn, from the begin of the half that was not fitted: some two cycles


def motion() -> NDArray[np.float64]:
    """Return positions, rad: a wide cycle with a small one inside, at 0.1 Hz so that a lag of 20 ms shows as well."""
    corners = np.array([0.0, 6e-3, -6e-3, 1e-3, -1e-3, 6e-3, -6e-3])
    lengths = np.abs(np.diff(corners))
    times = np.append(0.0, np.cumsum(lengths / 0.1))
    return np.interp(np.arange(0.0, times[-1], PERIOD / 10.0), times, corners)


def draw(record: PreslidingRecord, fits: list[Fit]) -> Figure:
    """Draw the laws above and the fits below, in two rows each."""
    figure = Figure(figsize=(8.5, 11.0), layout="constrained")
    above, below = figure.subfigures(2, 1)
    upper, lower = above.subplots(2, 3).ravel(), below.subplots(2, 3).ravel()
    above.suptitle("Simulated along one motion, a small cycle in a wide one")
    below.suptitle("Measured, and fitted to the other half of the record")
    path, period = motion(), PERIOD / 10.0
    velocity = np.diff(path) / period
    for axes, (name, joint) in zip(upper, LAWS.items(), strict=False):
        fine = type(joint)(**{**joint.model_dump(), "solver_period": period})
        force = force_along(fine, velocity, np.full(velocity.size, period))
        axes.plot(1e3 * path[1:], force, color=SIMULATED, linewidth=1.0)
        axes.set(title=name, xlabel="displacement, mrad", ylabel="friction torque, N m")
    _draw_gear(upper[5])
    part = slice(record.force.size // 2, record.force.size // 2 + DRAWN)
    position = 1e3 * record.position[part]
    for axes, fit in zip(lower, fits, strict=False):
        axes.plot(position, record.force[part], color="0.6", linewidth=3.0, label="measured")
        axes.plot(position, fit.force[part], color=FITTED, linewidth=1.0, label="fitted")
        axes.set_title(f"{fit.law}: {fit.tested:.2g} N rms", fontsize="medium")
        axes.set(xlabel="displacement, mm", ylabel="friction force, N")
    below.legend(*lower[0].get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize="small")
    return figure


def _draw_gear(axes: Axes) -> None:
    """Draw the torque of a gear with backlash and hysteresis over its twist."""
    fields = {**FRICTION, "link_share": 0.5, "link_stiffness": 2e4, "hysteresis": 15.0, "gap": 0.003}
    joint = plant.BacklashJoint(**fields, hysteresis_reach=5e-4).parameters
    state, twists, torques = plant.BacklashState(*7 * [0.0]), [], []
    for twist in motion()[::20].tolist():
        speed = (twist - state.twist) / PERIOD
        state = plant.step_backlash(joint, state._replace(motor_velocity=speed, velocity=0.0), 0.0, PERIOD)
        twists.append(1e3 * state.twist)
        torques.append(joint.link_stiffness * state.wind + state.hysteresis_torque)
    axes.plot(twists, torques, color=SIMULATED, linewidth=1.0)
    axes.set(title="gear with backlash", xlabel="twist, mrad", ylabel="torque of the gear, N m")
