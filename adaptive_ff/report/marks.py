"""What is drawn across the panels of several pictures: the truth, and changes of the joint."""

from collections.abc import Sequence

from matplotlib.axes import Axes

from adaptive_ff.report.drawing import INK, Look
from adaptive_ff.scenario.scenario import Scenario

TRUTH: Look = {"color": "#000000", "linestyle": (0, (3, 2)), "zorder": 2.6, "label": "true"}
CHANGE: Look = {"color": INK, "linewidth": 0.9, "linestyle": (0, (1, 2)), "zorder": 1.5}


def mark_changes(panels: Sequence[Axes], scenario: Scenario) -> list[Look]:
    """Mark the changes of the joint; return what the legend shall explain."""
    for axes in panels:
        for change in scenario.change:
            axes.axvline(change.time, **CHANGE)
    if not scenario.change:
        return []
    kinds = {name for change in scenario.change for name in change.model_fields_set}
    several = "friction changes" if kinds <= {"time", "friction_scale"} else "the joint changes"
    return [{**CHANGE, "label": scenario.change[0].text if len(scenario.change) == 1 else several}]
