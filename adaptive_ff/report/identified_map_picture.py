"""Picture of friction and force over position as they were identified from a log."""

from pathlib import Path

from matplotlib.figure import Figure

from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.report.drawing import Look, explain_looks, label_above, make_panels

IDENTIFIED: Look = {"color": "#d55e00", "linewidth": 1.3, "label": "identified"}
BAND: Look = {"color": "#f6ddcc", "linewidth": 6.0, "label": "interval"}
MEAN: Look = {"color": "#a6a6a6", "linewidth": 1.0, "linestyle": (0, (3, 2)), "label": "without a map"}


def draw_identified_map(found: LogIdentification) -> Figure | None:
    """Draw friction over its mean, and force, along the position, each with its band; None where there is neither.

    The caller sets the style.
    """
    learnt = found.position_map
    if learnt is None:
        return None
    name, unit = Path(found.name).name, found.units["velocity"].removesuffix("/s")
    labelled = {
        f"{name}: friction over its mean": (learnt.friction, 1.0),
        f"{name}: force over position, beside friction ({found.units['torque']})": (learnt.force, 0.0),
    }
    shown = [(label, curve, mean) for label, (curve, mean) in labelled.items() if curve is not None]
    if not shown:
        return None
    figure, panels = make_panels(len(shown), 1.0 + 2.6 * len(shown))
    for axes, (label, curve, mean) in zip(panels, shown, strict=True):
        axes.fill_between(learnt.position, curve.lower, curve.upper, color=BAND["color"], linewidth=0.0)
        axes.plot(learnt.position, curve.value, **IDENTIFIED)
        axes.axhline(mean, **MEAN)
        label_above(axes, label)
    panels[-1].set(xlabel=f"position ({unit})", xlim=(learnt.position[0], learnt.position[-1]))
    explain_looks(figure, [IDENTIFIED, {**BAND, "label": f"{100.0 * found.confidence:g} % interval"}, MEAN])
    return figure
