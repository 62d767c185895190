"""Command ``adaptive-ff playground``."""

from pathlib import Path

from adaptive_ff.cli.output import Printer


def playground_command(
    out: Path = Path("playground.html"),  # file of the page
) -> None:
    """Write a page on which PI and adaptive run in a browser, with sliders; it needs no network."""
    from adaptive_ff.playground.page import write_page

    write_page(out)
    Printer().print(f"{out}: open it in a browser", highlight=False, markup=False, soft_wrap=True)
