"""What the adaptive controller has learnt of friction over position and load, a sentence each."""

from collections.abc import Iterator

import numpy as np

from adaptive_ff.adaptive.learning.map_reading import LearntMap, load_sentence, position_sentence

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
        yield position_sentence(learnt.position, learnt.factor, learnt.periods)
    if learnt.load_share != 0.0:
        yield load_sentence(learnt.load_share)
    if learnt.share < 1.0:
        yield f"Of that map {100.0 * learnt.share:.0f} % is fed: it is not sure yet."
