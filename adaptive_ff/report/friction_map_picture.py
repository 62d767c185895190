"""Picture of the friction that was learnt over position, beside the true one."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from adaptive_ff.adaptive.extensions.over_position import LearntMap
from adaptive_ff.report.drawing import Look, explain_looks, label_above, make_panels
from adaptive_ff.report.marks import TRUTH
from adaptive_ff.scenario.axis_units import axis_label
from adaptive_ff.scenario.scenario import Scenario


def draw_friction_map(maps: Mapping[str, LearntMap], looks: Mapping[str, Look], scenario: Scenario) -> Figure:
    """Draw friction over its mean along the position, a curve a controller, and the truth.

    The caller sets the style.

    Parameters
    ----------
    maps : mapping of LearntMap
        Maps by name of the controller; those without positions are left out.
    looks : mapping of Look
        Looks by name of the controller.
    scenario : Scenario
        The scenario, which says how the true friction varies.
    """
    variation = scenario.variation
    figure, (axes,) = make_panels(1, 3.8)
    for name, learnt in maps.items():
        axes.plot(learnt.position, learnt.factor, **looks[name])
    ends = [end for learnt in maps.values() for end in (learnt.position[0], learnt.position[-1])]
    position = np.linspace(min(ends), max(ends), 1000)
    truth = 1.0 + variation.position_amplitude * np.sin(2.0 * np.pi * position / variation.position_period)
    axes.plot(position, truth, **TRUTH)
    label_above(axes, "friction over its mean, as learnt at the end of the run")
    axes.set(xlabel=axis_label(scenario.joint.axis, "position (rad)"), xlim=(position[0], position[-1]))
    explain_looks(figure, [TRUTH, *(looks[name] for name in maps)])
    return figure
