"""The tip of the two-link arm on a circle: where a joint turns round, friction leaves a glitch in each quadrant."""

import math
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from adaptive_ff.report.drawing import INK, QUIET, STYLE, stamp
from benchmarks.robot.loops import MAKERS, Setup, drive
from benchmarks.robot.machines import make_machine
from benchmarks.robot.plans import Plan

Array = NDArray[np.float64]

UPPER, FORE = 0.6, 0.5
"""Lengths of the links, m."""

HEIGHT, BENDS = 1.5, (0.9, 1.6)
"""Height of the base, m, and angles of the links from the vertical in the first pose, rad."""

RADIUS, ROUND = 0.1, 3.0  # m, s
LEARNT = 24.0  # s, after which the path is drawn, for two rounds
SETUP = Setup(rate=500, cascade=True, gravity_given=False)
MAGNIFIED = 50.0
LOOKS = {"pi": ("PI with a position loop", "#0072b2"), "adaptive": ("the same with adaptive feedforward", "#d55e00")}


def tip_of(position: Array) -> Array:
    """Return the tip (m, across and up) for joint positions, shape (n, 2)."""
    upper, fore = BENDS[0] + position[:, 0], BENDS[1] + position[:, 0] + position[:, 1]
    across = -(UPPER * np.sin(upper) + FORE * np.sin(fore))
    return np.column_stack([across, HEIGHT - UPPER * np.cos(upper) - FORE * np.cos(fore)])


def joints_of(tip: Array) -> Array:
    """Return the joint positions for tips, the elbow bent as in the first pose; inverse of ``tip_of``."""
    across, down = -tip[:, 0], HEIGHT - tip[:, 1]
    reach = across**2 + down**2
    bend = np.arccos((reach - UPPER**2 - FORE**2) / (2.0 * UPPER * FORE))
    upper = np.arctan2(across, down) - np.arctan2(FORE * np.sin(bend), UPPER + FORE * np.cos(bend))
    return np.column_stack([upper - BENDS[0], bend - (BENDS[1] - BENDS[0])])


def circle(duration: float, period: float) -> Plan:
    """Plan rounds of the tip, which sets off slowly from the first pose."""
    time = period * np.arange(round(duration / period) + 1)
    set_off = ROUND * np.minimum(time / ROUND, 1.0) ** 2 / 2.0  # half a round in the time of one
    angle = 2.0 * math.pi * (set_off + np.maximum(time - ROUND, 0.0)) / ROUND
    start = tip_of(np.zeros((1, 2)))[0]
    tip = start + RADIUS * np.column_stack([1.0 - np.cos(angle), np.sin(angle)])
    position = joints_of(tip)
    return Plan(np.gradient(position, period, axis=0), position)


def picture(seed: int) -> Figure:
    """Draw the last two rounds with PI alone and with adaptive feedforward, deviations magnified."""
    machine = make_machine("two-link arm", "coulomb")
    plan = circle(LEARNT + 2.0 * ROUND, 1.0 / SETUP.rate)
    last = slice(round(LEARNT * SETUP.rate), None)
    centre = tip_of(np.zeros((1, 2)))[0] + [RADIUS, 0.0]
    with rc_context(STYLE):
        figure = Figure(figsize=(8.0, 4.4), layout="constrained")
        panels: Any = figure.subplots(1, 2, sharex=True, sharey=True)
        for axes, (name, (label, colour)) in zip(panels, LOOKS.items(), strict=True):
            driven = drive(machine, MAKERS[name](machine, SETUP), plan, SETUP, seed)
            offset = driven.tip[last][:, [0, 2]] - centre
            draw_path(axes, offset, colour)
            deviation = np.hypot(*offset.T) - RADIUS
            rms, worst = 1e3 * math.sqrt(float(np.mean(deviation**2))), 1e3 * float(np.max(np.abs(deviation)))
            axes.set_title(f"{label}\n{rms:.2f} mm rms, {worst:.2f} mm at worst", loc="left", size=9.0)
            axes.set_xlabel("across (m)")
        panels[0].set_ylabel("up (m)")
        figure.suptitle(f"Tip of the arm on a circle, deviations {MAGNIFIED:g} times as large", x=0.01, ha="left")
        stamp([figure], f"two-link arm in MuJoCo, Coulomb friction, {SETUP.rate} Hz, gravity not given, seed {seed}")
    return figure


def draw_path(axes: Axes, offset: Array, colour: str) -> None:
    """Draw a path around the centre (m), its deviations from the circle magnified, beside the circle."""
    radius, angle = np.hypot(*offset.T), np.arctan2(offset[:, 1], offset[:, 0])
    drawn = RADIUS + MAGNIFIED * (radius - RADIUS)
    whole = np.linspace(0.0, 2.0 * math.pi, 400)
    axes.plot(RADIUS * np.cos(whole), RADIUS * np.sin(whole), color=QUIET, linewidth=0.8)
    axes.plot(drawn * np.cos(angle), drawn * np.sin(angle), color=colour, linewidth=1.2)
    axes.plot([0.0], [0.0], "+", color=INK, markersize=5.0)
    axes.set_aspect("equal")
