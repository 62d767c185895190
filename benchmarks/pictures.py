"""The pictures of README: ``python -m benchmarks.pictures`` draws them anew into ``benchmarks/pictures``."""

from pathlib import Path

from adaptive_ff import compare
from adaptive_ff.files import staged
from adaptive_ff.report.style import stamp, write_figures
from benchmarks.friction.laws import fit_all
from benchmarks.friction.picture import draw
from benchmarks.friction.record import DATA, read_record
from benchmarks.paper import closed_loop, offline
from benchmarks.paper.__main__ import SOURCE

FOLDER = Path(__file__).resolve().parent / "pictures"
FROM_COMPARISON = ("tracking", "estimates")
FROM_PAPER = ("figure_04", "figure_12")
COMMAND = "python -m benchmarks.pictures"


def main() -> None:
    """Draw the built-in comparison, two figures of the paper, and the friction laws where their record is there."""
    compared, papers = compare().plot(), {**offline.run().figures, **closed_loop.run().figures}
    with staged(FOLDER) as stage:
        write_figures({name: compared[name] for name in FROM_COMPARISON}, stage, ["png"])
        drawn = {name: papers[name] for name in FROM_PAPER}
        stamp(drawn.values(), SOURCE)
        if DATA.is_file():
            record = read_record(DATA)
            laws = draw(record, fit_all(record))
            stamp([laws], COMMAND)
            drawn["friction_laws"] = laws
        write_figures(drawn, stage, ["png"])
    print(f"Pictures are in {FOLDER}")


if __name__ == "__main__":
    main()
