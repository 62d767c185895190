"""Picture of an exciting motion: position, velocity, and acceleration over one period."""

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from adaptive_ff.report.drawing import INK, STYLE, Look, draw_series, explain_looks, label_above, make_panels
from adaptive_ff.studies.motion import Excitation

MOTION: Look = {"color": "#d55e00", "linewidth": 1.2, "label": "motion"}
LIMIT: Look = {"color": INK, "linewidth": 0.8, "linestyle": (0, (6, 2, 1, 2)), "label": "limit"}

POINTS = 2000
"""Points of a curve."""


def plot_excitation(motion: Excitation, *, linear: bool = False) -> Figure:
    """Draw one period of an exciting motion with its limits, where those are near."""
    unit = "m" if linear else "rad"
    columns = motion.columns(motion.reference.period / POINTS)
    limits = vars(motion.limits)
    with rc_context(STYLE):
        figure, panels = make_panels(3, 6.0)
        for axes, name, per in zip(panels, ("position", "velocity", "acceleration"), ("", "/s", "/s²"), strict=True):
            draw_series(axes, columns["time"], columns[name], MOTION)
            if limits[name] is not None and limits[name] < 2.0 * motion.largest[name]:
                for side in (-1.0, 1.0):
                    axes.axhline(side * limits[name], **{key: value for key, value in LIMIT.items() if key != "label"})
            label_above(axes, f"{name} ({unit}{per})")
        panels[-1].set_xlabel("time (s)")
        panels[-1].set_xlim(0.0, float(np.max(columns["time"])))
        explain_looks(figure, [MOTION, LIMIT])
    return figure
