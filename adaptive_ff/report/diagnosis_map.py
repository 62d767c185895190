"""What the adaptive controller has learnt of friction over position and load, a sentence each."""

from collections.abc import Iterator

import numpy as np

from adaptive_ff.adaptive.map_reading import LearntMap

TOLD = 0.01
"""Least rise and fall of friction that is told."""


def map_sentences(learnt: LearntMap | None) -> Iterator[str]:
    """Yield where friction rises and falls, and by how much; nothing of a controller without a map."""
    if learnt is None:
        return
    if learnt.share == 0.0:
        yield (
            "The map of friction over position and load is not fed: what it says does not explain the torque that the "
            "model leaves, so friction does not depend on them, or the joint has not come back to where it was."
        )
        return
    if learnt.factor.size and float(np.ptp(learnt.factor)) > TOLD:
        high, low = int(np.argmax(learnt.factor)), int(np.argmin(learnt.factor))
        repeats = f", and repeats every {learnt.periods[0]:.3g} rad" if len(learnt.periods) == 1 else ""
        yield (
            f"Friction depends on position: it rises by {_percent(learnt.factor[high] - 1.0)} at "
            f"{learnt.position[high]:.3g} rad and falls by {_percent(1.0 - learnt.factor[low])} at "
            f"{learnt.position[low]:.3g} rad{repeats}."
        )
    if learnt.load_share != 0.0:
        change = "rises" if learnt.load_share > 0.0 else "falls"
        yield f"Friction {change} by {100.0 * abs(learnt.load_share):.2g} % for each N m of known torque."
    if learnt.share < 1.0:
        yield f"Of that map {_percent(learnt.share)} is fed: it is not sure yet."


def _percent(value: float) -> str:
    return f"{100.0 * value:.0f} %"
