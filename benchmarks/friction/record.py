"""The measured record: a reciprocating contact of 0.24 mm stroke under a constant normal load of 5 N."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parent.parent.parent
DATA = ROOT.parent / "shared" / "data" / "tribometer_presliding" / "reciprocating_presliding.npz"

LOADED = 4.9  # normal load from which on the contact counts as loaded, N
RUN_IN = 15.0  # time that is left out: the load is put on and the first stroke begins elsewhere, s
PLAY = 2e-7  # half width of the play operator that takes the flicker of the last digit (1e-7 m) out of the position, m


class PreslidingRecord(NamedTuple):
    """A record of friction over an imposed motion."""

    period: NDArray[np.float64]  # shape (n,): time since the sample before, s
    position: NDArray[np.float64]  # shape (n,): position, m, without its flicker
    velocity: NDArray[np.float64]  # shape (n,): mean velocity since the sample before, m/s
    force: NDArray[np.float64]  # shape (n,): friction force against motion in the direction of the position, N

    def part(self, which: slice) -> "PreslidingRecord":
        """Return some of the samples."""
        return PreslidingRecord(*(series[which] for series in self))


def without_flicker(position: NDArray[np.float64], play: float = PLAY) -> NDArray[np.float64]:
    """Return the output of a play operator: it follows a position only where that has moved by more than the play."""
    kept, held = np.empty_like(position), float(position[0])
    for index, value in enumerate(position.tolist()):
        held = min(max(held, value - play), value + play)
        kept[index] = held
    return kept


def read_record(path: Path = DATA) -> PreslidingRecord:
    """Read the loaded part of the record; the source's friction has the other sign."""
    with np.load(path) as arrays:
        time, load = arrays["t_s"], 1e-6 * arrays["normal_uN"]
        used = (load > LOADED) & (time > RUN_IN)
        time, position, force = time[used], 1e-3 * arrays["position_mm"][used], -1e-6 * arrays["friction_uN"][used]
    position = without_flicker(position - np.mean(position))
    period = np.diff(time)
    return PreslidingRecord(period, position[1:], np.diff(position) / period, force[1:])
