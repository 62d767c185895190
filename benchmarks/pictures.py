"""The pictures of README: ``python -m benchmarks.pictures`` draws them anew into ``benchmarks/pictures``."""

from pathlib import Path

from adaptive_ff import compare
from adaptive_ff.output import staged

FOLDER = Path(__file__).resolve().parent / "pictures"


def main() -> None:
    """Draw the pictures of the built-in scenario."""
    FOLDER.mkdir(exist_ok=True)
    with staged(FOLDER) as stage:
        compare().plot(stage)
    print(f"Pictures are in {FOLDER}")


if __name__ == "__main__":
    main()
