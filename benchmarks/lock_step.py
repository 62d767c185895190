"""Joints in lock step: ``python -m benchmarks.lock_step``.

A step of a joint waits for its own last one, so a processor has little to do at a time; steps of several joints in one
loop overlap. Printed are the times of a step of drawn joints under proportional feedback, alone and two and four at
once, and what share of a sweep of drawn joints all their steps are. Series are the same to the bit.
"""

import time
from collections.abc import Callable, Sequence
from typing import Annotated, Any, NamedTuple

import numba
import numpy as np
import typer
from numpy.typing import NDArray

from adaptive_ff import load_scenario
from adaptive_ff.comparison.drawn_joints import CONTROLLERS, draw_scenario, run_draw
from benchmarks.wide import wide_console
from plant.step import initial_joint, ready_joint, step_ready_joint


class Lane(NamedTuple):
    """One joint under proportional feedback.

    Attributes
    ----------
    joint : ReadyJoint
        The joint.
    gain : float
        Gain, N m s/rad.
    """

    joint: Any
    gain: float


@numba.njit
def one(a: Lane, start: Any, plan: NDArray[np.float64], period: float) -> Any:
    """Return where a joint comes to along a plan (rad/s)."""
    p = start
    for w in plan:
        p = step_ready_joint(a.joint, p, a.gain * (w - p.velocity), period)
    return p


@numba.njit
def two(a: Lane, b: Lane, start: Any, plan: NDArray[np.float64], period: float) -> Any:
    """Return where two joints come to."""
    p, q = start, start
    for w in plan:
        p = step_ready_joint(a.joint, p, a.gain * (w - p.velocity), period)
        q = step_ready_joint(b.joint, q, b.gain * (w - q.velocity), period)
    return p, q


@numba.njit
def four(a: Lane, b: Lane, c: Lane, d: Lane, start: Any, plan: NDArray[np.float64], period: float) -> Any:
    """Return where four joints come to."""
    p, q, r, s = start, start, start, start
    for w in plan:
        p = step_ready_joint(a.joint, p, a.gain * (w - p.velocity), period)
        q = step_ready_joint(b.joint, q, b.gain * (w - q.velocity), period)
        r = step_ready_joint(c.joint, r, c.gain * (w - r.velocity), period)
        s = step_ready_joint(d.joint, s, d.gain * (w - s.velocity), period)
    return p, q, r, s


def processor_time(work: Callable[[], object]) -> float:
    """Return the processor time that something takes, s."""
    start = time.process_time()
    work()
    return time.process_time() - start


def alike(lanes: Sequence[Lane], start: Any, plan: NDArray[np.float64], period: float) -> bool:
    """Tell whether joints come to the same places in lock step as alone."""
    alone = [one(lane, start, plan, period) for lane in lanes]
    pairs = [end for i in range(0, len(lanes), 2) for end in two(*lanes[i : i + 2], start, plan, period)]
    fours = [end for i in range(0, len(lanes), 4) for end in four(*lanes[i : i + 4], start, plan, period)]
    return alone == pairs == fours


def main(
    joints: Annotated[int, typer.Option(min=4, help="Number of joints; a multiple of four.")] = 8,
    repeats: Annotated[int, typer.Option(min=1, help="Turns, of which the quickest counts.")] = 9,
) -> None:
    """Print the times."""
    if joints % 4:
        raise typer.BadParameter(f"{joints} is not allowed: it must be a multiple of four", param_hint="--joints")
    base, drawn, draw = load_scenario(), [], 0
    while len(drawn) < joints:  # those that are stepped with the same period
        scenario = draw_scenario(base, 101, draw)
        drawn += [scenario] if scenario.joint.solver_period == base.joint.solver_period else []
        draw += 1
    period, plan = base.joint.solver_period, base.reference_velocity()
    parameters = [scenario.joint.parameters for scenario in drawn]
    gains = [scenario.feedback.gains[0] for scenario in drawn]
    lanes = [Lane(ready_joint(p, period), gain) for p, gain in zip(parameters, gains, strict=True)]
    start = initial_joint(parameters[0], 0.0)
    if not alike(lanes, start, plan, period):
        raise SystemExit("the joints come to other places in lock step")
    kinds: list[tuple[str, Callable[[], object]]] = [
        ("alone", lambda: [one(lane, start, plan, period) for lane in lanes]),
        ("two", lambda: [two(*lanes[i : i + 2], start, plan, period) for i in range(0, joints, 2)]),
        ("four", lambda: [four(*lanes[i : i + 4], start, plan, period) for i in range(0, joints, 4)]),
    ]
    run_draw(base, 101, 0)
    turns = [[processor_time(work) for _, work in kinds] for _ in range(repeats)]
    sweep = [processor_time(lambda: [run_draw(base, 101, draw) for draw in range(joints)]) for _ in range(3)]
    console, steps = wide_console(), joints * plan.size
    quickest = np.min(turns, axis=0) / steps
    for (name, _), each in zip(kinds, quickest, strict=True):
        console.print(f"{name}: {1e9 * each:.1f} ns a step, {each / quickest[0]:.2f} of that alone")
    share = 100.0 * len(CONTROLLERS) * quickest[0] * steps / min(sweep)
    console.print(
        f"a sweep takes {1e3 * min(sweep) / joints:.1f} ms a joint; all steps of its joints are {share:.0f} % of it, "
        f"of which four in lock step would save {share * (1.0 - quickest[-1] / quickest[0]):.0f} %"
    )


if __name__ == "__main__":
    typer.run(main)
