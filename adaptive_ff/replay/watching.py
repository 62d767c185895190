"""A controller that watches a record: it sees what it would have seen on the machine, and its torque goes nowhere.

The step is the controller's own, compiled; so what it learns and feeds forward is what it would have learnt and fed
forward at that moment of the record.
"""

from typing import Any, NamedTuple

from adaptive_ff.logs.derivatives import Array
from controllers import compiled_in_place, estimate_velocity, planned_inputs, step, write_estimates


class Seen(NamedTuple):
    """What a controller sees, sample by sample.

    Attributes
    ----------
    reference : ndarray, shape (n,)
        Reference velocity, rad/s.
    coming : ndarray, shape (n,)
        Reference velocity at the next sample, rad/s; not a number where it is not known.
    measurement : ndarray, shape (n,)
        Measured position (rad) or velocity (rad/s).
    realised : ndarray, shape (n,)
        Mean torque over the period that ends at the sample, N m; not a number where it is not known.
    elapsed : ndarray, shape (n,)
        Length of that period, s.
    position : ndarray, shape (n,)
        Measured position (rad), for gravity; not a number where there is none.
    """

    reference: Array
    coming: Array
    measurement: Array
    realised: Array
    elapsed: Array
    position: Array


def _watch(
    block: Any, state: Any, observer: Any, observed: Any, seen: Seen, feedforward: Array, estimates: Array
) -> tuple[Any, Any]:
    for k in range(seen.reference.size):
        velocity, observed = estimate_velocity(observer, observed, seen.measurement[k], seen.elapsed[k])
        realised = seen.realised[k]
        inputs = planned_inputs(
            seen.reference[k], velocity, seen.coming[k], realised, seen.elapsed[k], seen.position[k]
        )
        output, state = step(block, state, inputs)
        feedforward[k] = output.feedforward
        write_estimates(block, state, estimates[k])
    return state, observed


watch = compiled_in_place(_watch)
"""Step a controller along a record.

Parameters
----------
block, state : NamedTuple
    Parameters and state of the controller.
observer, observed : NamedTuple
    Parameters and state of what makes a velocity of the measurement.
seen : Seen
    What it sees.
feedforward : ndarray, shape (n,)
    Filled in: its feedforward for the period that begins at the sample, N m.
estimates : ndarray, shape (n, parameters)
    Filled in: its physical estimates after the sample.

Returns
-------
state, observed : NamedTuple
    New states.
"""
