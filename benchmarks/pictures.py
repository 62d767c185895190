"""The pictures of README: ``python -m benchmarks.pictures`` draws them anew into ``benchmarks/pictures``."""

from pathlib import Path

from adaptive_ff import compare
from adaptive_ff.files import staged
from benchmarks.paper import closed_loop, offline

FOLDER = Path(__file__).resolve().parent / "pictures"
FROM_COMPARISON = ("tracking", "estimates")
FROM_PAPER = ("figure_04", "figure_12")
DOTS_PER_INCH = 150


def main() -> None:
    """Draw the pictures of the built-in scenario and two of the paper's reproduction."""
    drawn = {**compare().plot(), **offline.run().figures, **closed_loop.run().figures}
    with staged(FOLDER) as stage:
        for name in (*FROM_COMPARISON, *FROM_PAPER):
            drawn[name].savefig(stage / f"{name}.png", dpi=DOTS_PER_INCH)
    print(f"Pictures are in {FOLDER}")


if __name__ == "__main__":
    main()
