"""A console for tables that are wider than a terminal of 80 columns."""

import sys

from rich.console import Console

WIDTH = 190  # width where the output is no terminal, characters


def wide_console() -> Console:
    """Return the console of a benchmark: as wide as the terminal, or wide enough for every table in a file."""
    return Console(width=None if sys.stdout.isatty() else WIDTH)
