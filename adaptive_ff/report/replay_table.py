"""The torque that a replay leaves to the feedback, as a table for a terminal."""

import math

from rich.box import SIMPLE
from rich.table import Table

from adaptive_ff.replay.replay import COLD, FIXED, NONE, RECORDED, SAVED, Replay

WORDS = {
    NONE: "none",
    RECORDED: "the machine's own, as recorded",
    FIXED: "fixed model of the first half",
    COLD: "adaptive, cold start",
    SAVED: "adaptive, from the saved state",
}


def left_table(replay: Replay) -> Table:
    """Return the torque left by each feedforward, one a row."""
    band = f"in a band of {replay.band:.3g} Hz"
    table = Table(title=f"Torque left to the feedback, rms in {replay.unit}, {band}", box=SIMPLE, title_style="bold")
    table.add_column("feedforward", no_wrap=True)
    for heading in ("whole log", "second half", "joint moves"):
        table.add_column(heading, justify="right")
    for name, words in WORDS.items():
        if name in replay.left:
            table.add_row(words, *("" if math.isnan(value) else f"{value:.3g}" for value in replay.left[name]))
    return table
