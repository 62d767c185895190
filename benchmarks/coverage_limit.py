"""What could be told from the logs of ``benchmarks.coverage`` at best: ``python -m benchmarks.coverage_limit``.

The same joints and motions, with intervals of an estimator that does not exist: it knows the spectrum and the level of
the noise and weighs all samples by it, sees the position without rounding, and is told which terms the joint has. Only
values are left to it, the lag, and where friction saturates the bend; the shape is told in one row of the table and is
one of those that ``identify`` knows in the other. Intervals are those of the likelihood ratio, along all bends and
shapes, of a noise drawn anew. It is an efficient estimator, no proven bound: what is vague to it is hard to tell.
"""

from typing import Annotated, NamedTuple

import numpy as np
import typer
from rich.box import SIMPLE
from rich.table import Table
from scipy import signal

from adaptive_ff.identify.reported import VAGUE
from adaptive_ff.identify.terms import SATURATIONS
from benchmarks.coverage import CORRELATED, FIRST_SEED, NAMES, Array, Joint, draw_joint, make_case, saturating
from benchmarks.wide import wide_console

QUANTILE = 1.96
"""Of the normal distribution, for 95 %."""

SLOWEST, BENDS = 0.05, 25
"""Slowest bend, over the largest speed, as ``identify`` has it, and number of bends up to that speed."""

LAG_STEP = 1e-4
"""Step of the difference quotient by the lag, s."""

FORGOTTEN = 50
"""Samples at the start that are left out, where the filter that makes the noise white starts."""

RIDGE = 1e-13
"""Added to the diagonal of the scaled normal equations."""


class Ideal(NamedTuple):
    """A joint as the estimator sees it, in units in which the noise of every sample is independent and of one size.

    Attributes
    ----------
    joint : Joint
        The joint.
    noise : float
        Deviation of the noise, N m.
    columns : ndarray, shape (n, terms)
        All terms but friction that saturates: inertia, Coulomb friction, viscous coefficient first.
    torque : ndarray, shape (n,)
        Torque, with noise.
    """

    joint: Joint
    noise: float
    columns: Array
    torque: Array

    def bent(self, shape: int, bend: float) -> Array:
        """Return the term of friction that saturates."""
        joint = self.joint
        return whitened(joint.lagged(saturating(shape, joint.velocity / bend), joint.lag), joint.rate, self.noise)


def whitened(series: Array, rate: float, noise: float) -> Array:
    """Filter a series so that the noise of the torque becomes white and of unit deviation.

    White noise and a first-order autoregression make ``(1 - p L) y = (1 - t L) e``; ``t`` and the variance of ``e``
    follow from the covariances of the right-hand side.
    """
    pole = np.exp(-1.0 / (CORRELATED * rate))
    at_zero, at_one = (1.0 - pole**2) + 1.0 + pole**2, -pole
    ratio = at_one / at_zero
    zero = (1.0 - np.sqrt(1.0 - 4.0 * ratio**2)) / (2.0 * ratio)
    deviation = noise * np.sqrt(0.5 * at_one / zero)
    filtered: Array = signal.lfilter([1.0, -pole], [1.0, zero], series)[FORGOTTEN:] / deviation
    return filtered


def ideal(seed: int) -> Ideal:
    """Return what the estimator sees of a log; the noise is not that of the log, but as loud."""
    joint, noise = draw_joint(np.random.default_rng(seed)), make_case(seed).noise
    kept, static = joint.kept, joint.static_friction()
    before = max(joint.lag - LAG_STEP, 0.0)
    slope = joint.lagged(static, joint.lag + LAG_STEP) - joint.lagged(static, before)
    columns = [
        joint.acceleration[kept],
        joint.lagged(np.sign(joint.velocity), joint.lag),
        joint.lagged(joint.velocity, joint.lag),
        np.ones_like(joint.time[kept]),
        slope / (joint.lag + LAG_STEP - before),
    ]
    if joint.gravity > 0.0:
        columns += [np.sin(joint.position[kept]), np.cos(joint.position[kept])]
    torque = whitened(joint.torque(), joint.rate, noise)
    torque = torque + np.random.default_rng([seed, 1]).standard_normal(torque.size)
    return Ideal(joint, noise, np.column_stack([whitened(one, joint.rate, noise) for one in columns]), torque)


def fit(columns: Array, torque: Array) -> tuple[float, Array, Array]:
    """Return the squares that are left, values and standard errors of a fit."""
    scale = np.linalg.norm(columns, axis=0)
    scaled = columns / scale
    inverse = np.linalg.inv(scaled.T @ scaled + RIDGE * np.eye(scale.size))
    values = inverse @ (scaled.T @ torque)
    residual = torque - scaled @ values
    return float(residual @ residual), values / scale, np.sqrt(np.diag(inverse)) / scale


def intervals(seen: Ideal, shapes: tuple[int, ...]) -> dict[str, tuple[float, float, float]]:
    """Return value and ends of the interval of each parameter, where friction may have some shapes."""
    fits = [fit(seen.columns, seen.torque)]
    if seen.joint.saturation > 0.0:
        bends = np.geomspace(SLOWEST, 1.0, BENDS) * float(np.max(np.abs(seen.joint.velocity)))
        tried = [
            fit(np.column_stack([seen.columns, seen.bent(shape, bend)]), seen.torque)
            for shape in shapes
            for bend in bends.tolist()
        ]
        fits = [one for one in tried if one[1][-1] > 0.0] or fits
    least = min(squares for squares, _, _ in fits)
    best = next(values for squares, values, _ in fits if squares == least)
    found = {}
    for place, name in enumerate(NAMES):
        halves = [
            (values[place], errors[place] * np.sqrt(QUANTILE**2 - (squares - least)))
            for squares, values, errors in fits
            if squares - least <= QUANTILE**2
        ]
        ends = (min(value - half for value, half in halves), max(value + half for value, half in halves))
        found[name] = (float(best[place]), float(ends[0]), float(ends[1]))
    return found


def judge(seen: Ideal, *, told: bool) -> dict[str, dict[str, bool]]:
    """Tell of each parameter of a joint whether its interval is vague, and whether it holds the truth."""
    joint = seen.joint
    shapes = (joint.shape,) if told else tuple(range(len(SATURATIONS)))
    true = {"inertia": joint.inertia, "coulomb": joint.coulomb, "viscous": joint.viscous}
    return {
        name: {"vague": 0.5 * (upper - lower) >= VAGUE * abs(value), "covers": lower <= true[name] <= upper}
        for name, (value, lower, upper) in intervals(seen, shapes).items()
    }


def main(
    logs: Annotated[int, typer.Option(min=1, help="Number of logs.")] = 500,
    first: Annotated[int, typer.Option(min=0, help="Seed of the first log.")] = FIRST_SEED,
) -> None:
    """Print what is vague for an estimator that knows the noise."""
    table = Table(title=f"Intervals of an estimator that knows the noise and the terms, {logs} logs", box=SIMPLE)
    for heading in ("shape of saturation", "vague", "of these joints that saturate", "viscous holds the truth"):
        table.add_column(heading, justify="left" if heading.startswith("shape") else "right")
    seeds = range(first, first + logs)
    bent: list[bool] = []
    cases: dict[bool, list[dict[str, dict[str, bool]]]] = {True: [], False: []}
    for seen in map(ideal, seeds):  # one at a time: the series of all would fill the memory
        bent.append(seen.joint.saturation > 0.0)
        for told, judged in cases.items():
            judged.append(judge(seen, told=told))
    for told, judged in cases.items():
        vague = np.array([any(one[name]["vague"] for name in NAMES) for one in judged])
        shares = (
            np.mean(vague),
            np.mean(vague & np.array(bent)),
            np.mean([one["viscous"]["covers"] for one in judged]),
        )
        table.add_row("told" if told else "one of three", *(f"{100.0 * share:.1f} %" for share in shares))
    wide_console().print(table)


if __name__ == "__main__":
    typer.run(main)
