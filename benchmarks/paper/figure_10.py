"""Fig. 10: the sampling time and its periodic outliers."""

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from adaptive_ff.report.style import INK, QUIET, STYLE, WIDTH
from benchmarks.paper.drawing import GUIDE, label
from benchmarks.paper.robot import CYCLE, Drive

SHOWN = 6.0  # s
LATE = "#d55e00"


def draw(record: Drive) -> Figure:
    """Draw the sampling times of the first seconds, and how often each occurs in the whole record."""
    durations = 1e3 * np.diff(record.time)
    ends = record.time[1:]
    mean = float(np.mean(durations))
    part = ends <= SHOWN
    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 2.9), layout="constrained")
        figure.get_layout_engine().set(h_pad=0.08)
        course, counts = figure.subplots(1, 2, sharey=True, width_ratios=(3.2, 1.0))
        late = durations > 1.2 * mean
        for chosen, colour in ((part & ~late, QUIET), (part & late, LATE)):
            course.vlines(ends[chosen], 0.0, durations[chosen], color=colour, linewidth=0.9)
            course.plot(ends[chosen], durations[chosen], ".", color=colour, markersize=4.0)
        course.axhline(mean, **{**GUIDE, "color": INK, "zorder": 3.0})
        course.set(xlim=(0.0, SHOWN), ylim=(0.0, 1.12 * float(durations.max())))
        label(course, f"sampling time (ms), mean {mean:.2f} dashed; repeats every {CYCLE} samples", "time (s)")
        lengths, numbers = np.unique(np.round(durations), return_counts=True)
        shares = 100.0 * numbers / durations.size
        counts.barh(lengths, shares, height=1.6, color=[LATE if length > 1.2 * mean else QUIET for length in lengths])
        for length, share in zip(lengths, shares, strict=True):
            counts.annotate(
                f"{length:.0f} ms: {share:.1f} %",
                (0.0, length + 1.2),
                xytext=(4.0, 0.0),
                textcoords="offset points",
                fontsize=8.0,
            )
        counts.set(xlim=(0.0, 100.0))
        counts.grid(axis="y", visible=False)
        label(counts, "how often", "share of samples (%)")
    return figure
