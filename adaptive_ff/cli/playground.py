"""Command ``adaptive-ff playground``."""

from pathlib import Path
from typing import Annotated

import typer

from adaptive_ff.cli.output import Printer


def playground_command(
    out: Annotated[Path, typer.Option(help="File of the page.")] = Path("playground.html"),
) -> None:
    """Write a page on which PI and adaptive run in a browser, with sliders; it needs no network."""
    from adaptive_ff.playground.page import write_page

    write_page(out)
    Printer().print(f"{out}: open it in a browser", highlight=False, markup=False, soft_wrap=True)
