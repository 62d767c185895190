"""The pictures of README and the pages: ``python -m benchmarks.pictures`` draws them anew."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from PIL import Image

from adaptive_ff.files import staged
from adaptive_ff.report.comparison_pictures import LOOKS
from adaptive_ff.report.style import INK, QUIET, STYLE, WIDTH, explain_looks, label_above, stamp, write_figures
from benchmarks.cases.machines import circle
from benchmarks.friction.laws import DATA, fit_all, read_record
from benchmarks.friction.picture import draw
from benchmarks.paper import closed_loop, offline
from benchmarks.paper.__main__ import SOURCE

FOLDER = Path(__file__).resolve().parent / "pictures"
FROM_PAPER = ("figure_04", "figure_12")
COMMAND = "python -m benchmarks.pictures"
COLOURS = 64  # colours of a picture: enough for curves, and a third of the bytes
MAGNIFIED = 10  # errors of the tip over those of the path that is drawn


def draw_circle(friction: str = "coulomb", seed: int = 1) -> Figure:
    """Draw the last lap with its errors magnified, and the distance from the circle over the first laps."""
    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 3.9), layout="constrained")
        path, radial = figure.subplots(1, 2, width_ratios=(1.0, 1.15))
        looks: list[Any] = [{"color": INK, "linewidth": 0.8, "label": "circle of the plan"}]
        for name in ("pi", "adaptive"):
            look = {**LOOKS[name], "label": name}
            looks.append(look)
            tip, target = circle.laps_of(name, friction, seed)
            shown = (target + MAGNIFIED * (tip - target) - circle.CENTRE)[-round(circle.LAP * circle.RATE) :]
            path.plot(1e3 * shown.real, 1e3 * shown.imag, **look)
            beyond = 1e3 * (np.abs(tip - circle.CENTRE) - circle.RADIUS)[: round(6.0 * circle.LAP * circle.RATE)]
            radial.plot(np.arange(beyond.size) / circle.RATE, beyond, **look)
        ideal = (target - circle.CENTRE)[-round(circle.LAP * circle.RATE) :]
        path.plot(1e3 * ideal.real, 1e3 * ideal.imag, **looks[0])
        path.set(aspect="equal", xlabel="forward (mm)")
        radial.set_xlabel("time (s)")
        label_above(path, f"path of the tip (mm), errors drawn {MAGNIFIED} times")
        label_above(radial, "distance from the circle (mm), first six laps")
        radial.axhline(0.0, color=QUIET, linewidth=0.6)
        explain_looks(figure, looks)
    return figure


def main() -> None:
    """Draw the arm on a circle, two figures of the paper, and the friction laws where their record is."""
    papers = {**offline.run().figures, **closed_loop.run().figures}
    drawn = {name: papers[name] for name in FROM_PAPER}
    stamp(drawn.values(), SOURCE)
    ours = {"circle": draw_circle()}
    if DATA.is_file():
        record = read_record(DATA)
        ours["friction_laws"] = draw(record, fit_all(record))
    stamp(ours.values(), COMMAND)
    with staged(FOLDER) as stage:
        write_figures({**drawn, **ours}, stage, ["png"])
        for path in stage.glob("*.png"):
            Image.open(path).convert("RGB").quantize(COLOURS).save(path, optimize=True)
    print(f"Pictures are in {FOLDER}")


if __name__ == "__main__":
    main()
