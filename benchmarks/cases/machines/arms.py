"""Hinges and arms in MuJoCo, with its Coulomb or LuGre friction: in motion, and at rest behind a position loop.

Along multisines (velocity loop, noise of 2 mrad/s) or from point to point behind a position loop (encoder of 6 urad);
gravity is given to all controllers, or to none. ``model_based`` has the true friction and the inertia in the middle of
the motion, ``adaptive`` that inertia. Errors are of the velocity, behind a position loop of the position.
"""

import itertools

import numpy as np

from adaptive_ff.simulation.tracking_errors import TrackingErrors, figures_of, tracking_errors
from adaptive_ff.studies.study import Found
from benchmarks.cases.holding import HOLDING, SETTLING, at_rest, rest_figures
from benchmarks.cases.machines.robots import KINDS, Array, Setup, drive, make_machine, moves, multisines, then_rest
from benchmarks.suite import Rows, seeded

FRICTIONS = ("coulomb", "LuGre")
MOVING = 30.0  # length of the moves before a machine rests, s


def run_moving(machine: str, friction: str, setup: Setup, seconds: float, seed: int, controllers: list[str]) -> Found:
    """Drive a machine along the plan of a seed; each joint has its own figures."""
    made = make_machine(machine, friction)
    plan = (moves if setup.cascade else multisines)(made.axes, seed, seconds, 1.0 / setup.rate)
    runs = {name: drive(made, name, plan, setup, seed) for name in dict.fromkeys(["pi", *controllers])}
    errors = {name: run.position_error if setup.cascade else run.velocity_error for name, run in runs.items()}
    loop = "position loop" if setup.cascade else "velocity loop"
    gravity = "" if machine == "hinge" else f", gravity {'given' if setup.gravity_given else 'learnt'}"
    found = [figures_of(_errors(errors, setup.rate, joint)) for joint in range(len(made.axes))]
    return {"": {"row": f"{machine}, {friction}, {setup.rate} Hz, {loop}{gravity}"}, **_by_name(found)}


def _errors(errors: dict[str, Array], rate: int, joint: int) -> dict[str, TrackingErrors]:
    return {name: tracking_errors(np.square(one[:, joint]), 1.0 / rate) for name, one in errors.items()}


def _by_name(joints: list[dict[str, dict[str, float]]]) -> Found:
    """Return figures of joints by controller, each a list over the joints."""
    return {
        name: {figure: [joint[name][figure] for joint in joints] for figure in joints[0][name]} for name in joints[0]
    }


def moving_rows(rates: list[int], seconds: float) -> Rows:
    """Return machines in motion at some rates (Hz) for a time (s)."""
    return {
        f"{machine}, {friction}, {rate}, {cascade}, {given}": (machine, friction, Setup(rate, cascade, given), seconds)
        for machine, friction, rate in itertools.product(KINDS, FRICTIONS, rates)
        for cascade in (False, True)
        for given in ((False,) if machine == "hinge" else (False, True))
    }


def run_resting(machine: str, friction: str, rate: int, seed: int, controllers: list[str]) -> Found:
    """Let a machine come to rest; each joint has its own figures."""
    made, setup = make_machine(machine, friction), Setup(rate, cascade=True, gravity_given=False)
    plan = then_rest(moves(made.axes, seed, MOVING, 1.0 / rate), SETTLING + HOLDING, 1.0 / rate)
    runs = {name: drive(made, name, plan, setup, seed) for name in dict.fromkeys(["pi", *controllers])}
    moved = {name: run.position_error[: round(MOVING * rate)] for name, run in runs.items()}
    rest, found = slice(-round(HOLDING * rate), None), []
    for joint in range(len(made.axes)):
        calm = {name: at_rest(run.velocity_error[rest, joint], run.torque[rest, joint]) for name, run in runs.items()}
        found.append(rest_figures(_errors(moved, rate, joint), calm, rate))
    return {"": {"row": f"{machine}, {friction}, {rate} Hz"}, **_by_name(found)}


def resting_rows(rates: list[int]) -> Rows:
    """Return a hinge and an arm that move and then hold still, at some rates (Hz)."""
    machines = itertools.product(("hinge", "two-link arm"), FRICTIONS, rates)
    return {", ".join(map(str, machine)): machine for machine in machines}


moving, resting = seeded(run_moving, moving_rows), seeded(run_resting, resting_rows)
