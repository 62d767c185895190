"""Means of structures with the same map of friction, and which of them is used."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from adaptive_ff.identify.open_loop.mean import Validated, held_out_squares, mean_of_all
from adaptive_ff.identify.open_loop.simulation import OpenLoopModel, Record
from adaptive_ff.identify.open_loop.structures import BLOCKS, SETTLING


class Choice(NamedTuple):
    """The mean of the structures that have the same map of friction over position.

    Attributes
    ----------
    error, squares : float, tuple of float
        Its error on blocks that were held out, rad, and its square on each, rad^2.
    mapped : int
        Coefficients of the map; zero without one.
    parameters : float
        Effective number of parameters, the mean of that of the structures.
    by_direction : float
        Share of the structures whose viscous friction differs by direction.
    structures : tuple of dict
        The structures: ``share``, ``knots``, ``by_direction``, ``weight`` of the shrinkage (zero where nothing depends
        on the position), ``error`` on blocks that were held out (rad), effective ``parameters``; largest share first.
    """

    error: float
    squares: tuple[float, ...]
    mapped: int = 0
    parameters: float = 0.0
    by_direction: float = 0.0
    structures: tuple[dict[str, Any], ...] = ()


def choose_mean(choices: Sequence[Choice]) -> Choice:
    """Return the mean of fewest parameters that is no more than one standard error behind the best one."""
    best = min(choices, key=lambda choice: choice.error)
    near = []
    for choice in choices:
        behind = np.array(choice.squares) - np.array(best.squares)
        if float(np.sum(behind)) <= math.sqrt(behind.size * float(np.var(behind, ddof=1))):
            near.append(choice)
    return min(near, key=lambda choice: (choice.parameters, choice.error))


def mean_of_map(members: list[Validated], record: Record) -> tuple[Choice, OpenLoopModel]:
    """Return the mean of structures with the same map, as it is compared, and its model."""
    model, shares = mean_of_all(members)
    squares = held_out_squares(members, record, record.position.size // BLOCKS, SETTLING)
    plain = ("knots", "by_direction", "weight", "error", "parameters")
    listed = [
        {"share": share, **{name: getattr(one, name) for name in plain}}
        for share, one in zip(shares.tolist(), members, strict=True)
    ]
    choice = Choice(
        math.sqrt(float(np.mean(squares))),
        tuple(squares.tolist()),
        members[0].models[0].coefficients.size,
        float(shares @ [one.parameters for one in members]),
        float(shares @ [one.by_direction for one in members]),
        tuple(sorted(listed, key=lambda one: -one["share"])),
    )
    return choice, model
