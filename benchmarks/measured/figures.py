"""One figure a machine: each joint's last log, the torque that was needed beside the feedforwards."""

from pathlib import Path

from matplotlib import rc_context

from adaptive_ff.replay.replay import COLD, SAVED
from adaptive_ff.report.log_pictures import LOOKS, NEEDED
from adaptive_ff.report.style import STYLE, draw_series, explain_looks, label_above, make_panels, write_figure
from benchmarks.measured.results import Result


def draw_machine(results: list[Result], path: Path) -> None:
    """Draw the joints of a machine: torque, and below it what is left of it."""
    with rc_context(STYLE):
        figure, panels = make_panels(2 * len(results), 0.8 + 3.1 * len(results), shared=False)
        used = []
        for place, result in enumerate(results):
            replay = result.replays[-1]
            names = [name for name in LOOKS if name in replay.left and not (name == COLD and SAVED in replay.left)]
            used += [name for name in names if name not in used]
            whole, left = panels[2 * place : 2 * place + 2]
            time = replay.series.time
            draw_series(whole, time, replay.series.needed, NEEDED)
            for name in names:
                draw_series(whole, time, replay.series.feedforward[name], LOOKS[name])
                draw_series(left, time, replay.series.needed - replay.series.feedforward[name], LOOKS[name])
            label_above(whole, f"{result.job.name}, {result.job.records[-1]}: torque and feedforward ({replay.unit})")
            label_above(left, f"torque left to the feedback ({replay.unit})")
            for axes in (whole, left):
                axes.set_xlim(float(time[0]), float(time[-1]))
        panels[-1].set_xlabel("time (s)")
        explain_looks(figure, [NEEDED, *(LOOKS[name] for name in used)])
        write_figure(figure, path)
