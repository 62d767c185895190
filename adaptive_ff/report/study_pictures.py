"""Pictures of studies: error over bandwidth, an exciting motion, a sweep, the matrix of scenarios."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, TwoSlopeNorm
from matplotlib.figure import Figure

from adaptive_ff.comparison.comparison import KNOW_THE_TRUTH
from adaptive_ff.comparison.fixed_models import FORMS, SOURCES
from adaptive_ff.comparison.registry import CONTROLLERS
from adaptive_ff.report.comparison_pictures import looks_of
from adaptive_ff.report.style import (
    INK,
    LIMIT,
    QUIET,
    STYLE,
    Look,
    Panel,
    explain_looks,
    label_above,
    label_decades,
    picture,
    stamp,
)
from adaptive_ff.report.table import scale_for
from adaptive_ff.scenario.axis_units import axis_unit
from adaptive_ff.scenario.library import grouped
from adaptive_ff.scenario.loop import HUNTING
from adaptive_ff.studies.bandwidth_study import BandwidthStudy
from adaptive_ff.studies.matrix import OURS, Cells
from adaptive_ff.studies.motion import Excitation
from adaptive_ff.studies.sweep import CONTROLLERS as DRAWN
from adaptive_ff.studies.sweep import Outcome

LOADED: Look = {"color": INK, "linewidth": 0.9, "linestyle": (0, (4, 2)), "label": "after a step of the load"}
NOISE: Look = {"color": INK, "linewidth": 0.9, "linestyle": (0, (1, 2)), "label": "noise alone"}
GIVEN: Look = {**LIMIT, "label": "bandwidth of the scenario"}
MARGIN: Look = {"color": INK, "linewidth": 1.2}
MOTION: Look = {"color": "#d55e00", "linewidth": 1.2, "label": "motion"}
SAME: Look = {"color": INK, "linewidth": 1.0, "linestyle": (0, (3, 2)), "label": "the same as pi"}

POINTS = 2000  # points of the curve of a motion

WEAKEST, STRONGEST = -2.0, 6.0
"""Range of improvement over PI that the colours show, powers of two; PI itself is in the middle of the colours."""

COLOURS = LinearSegmentedColormap.from_list(
    "worse_better",
    ("#590007", "#8b2706", "#be6533", "#d39774", "#eacebd", "#c9dde7", "#71a7c4", "#1e6f9d", "#033d7c", "#001260"),
)
"""Red is worse than PI, blue better: perceptually uniform and the same to colour-blind eyes.

Colours of the map vik, F. Crameri, "Scientific colour maps" (2018), doi 10.5281/zenodo.1243862.
"""

DARK, DARK_RED = 3.0, -1.2  # powers of two beyond which the colour is too dark for dark letters

FIXED = tuple(f"{form}_{source}" for form in FORMS for source in SOURCES)
GROUPS = {
    "ours": (OURS,),
    "learners": (
        *("adaptive_paper", "canudas", "canudas_measured", "feedback_error", "lugre_gradient"),
        *("maxwell_adaptive", "radial_basis", "repetitive"),
    ),
    "observers": ("disturbance_observer", "extended_state", "kalman_disturbance", "super_twisting"),
    "friction model and observer": ("lugre_observer", "friction_observer", "lee_tomizuka"),
    "with a fixed model": (
        *(name for name in ("pi_inertia", *FIXED) if name not in KNOW_THE_TRUTH),
        *("observed_nominal", "observed_batch"),
    ),
    "knows the truth": ("oracle", "oracle_tuned", "noise_floor"),
}
"""Groups of columns in their order; what is in none stands under ``own`` or ``others``. PI itself is one everywhere."""


def plot_bandwidths(study: BandwidthStudy) -> Figure:
    """Draw the error of each controller over the bandwidth of its loop, with and without the load, and the margin."""
    unit = axis_unit(study.scenario.joint.axis, "rad/s")
    factor, speed = scale_for([error for one in study.own.values() for error in one.errors], unit)
    bandwidths = np.array([loop.bandwidth for loop in study.loops])
    curves = []
    for name, look in looks_of(study.own).items():
        one = study.own[name]
        settled, after = (np.where(np.isfinite(each), each, np.nan) for each in (one.errors, one.loaded))
        dot = {"color": look["color"], "marker": "o", "markersize": 6.0, "zorder": 3.0}
        curves.append((np.array(one.bandwidths), factor * settled, look))
        curves.append((np.array(one.bandwidths), factor * after, {**LOADED, "color": look["color"], "label": None}))
        curves.append((np.array([one.best]), np.array([factor * one.errors[one.place]]), dot))
    noise = np.array([loop.noise_velocity for loop in study.loops])
    if np.any(noise > 0.0):
        curves.append((bandwidths, factor * noise, NOISE))
    margin = [(bandwidths, np.array([loop.maximum_sensitivity for loop in study.loops]), MARGIN)]
    panels = [Panel(f"settled rms error ({speed}); dots: recommended", curves), Panel("maximum sensitivity", margin)]
    feedback = study.scenario.feedback
    given: list[tuple[float, Look]] = (
        [] if feedback.is_auto or not np.isfinite(feedback.hertz) else [(feedback.hertz, GIVEN)]
    )
    keys = [*(look for *_, look in curves), LOADED, *(look for _, look in given)]
    with rc_context(STYLE):
        figure, (above, below) = picture(panels, 6.0, "bandwidth of the PI loop (Hz)", keys=keys, marks=given)
        above.set_yscale("log")
        below.set_xscale("log")
        for axis in (above.yaxis, below.xaxis):
            label_decades(axis, 1.0)
    return figure


def plot_excitation(motion: Excitation, *, linear: bool = False) -> Figure:
    """Draw one period of an exciting motion with its limits, where those are near."""
    columns = motion.columns(motion.reference.period / POINTS)
    time, panels = columns["time"], []
    for name, per in (("position", ""), ("velocity", "/s"), ("acceleration", "/s²")):
        limit = getattr(motion.limits, name)
        near = limit is not None and limit < 2.0 * motion.largest[name]
        lines = [(limit, LIMIT), (-limit, LIMIT)] if near else []
        label = f"{name} ({'m' if linear else 'rad'}{per})"
        panels.append(Panel(label, [(time, columns[name], MOTION)], lines, span=(0.0, float(np.max(time)))))
    return picture(panels, 6.0)[0]


def plot_sweep(outcomes: Sequence[Outcome], source: str, worst: int = 3) -> Figure:
    """Draw the distributions of a sweep, of which some joint ran, and some of its worst cases.

    Error of ``pi`` over that of each controller, settled and over the whole run, each as the percentage of joints that
    are at most so good; that of the whole run over the fall of the friction.
    """
    run = [outcome for outcome in outcomes if not outcome.refused]
    own = dict.fromkeys(name for outcome in run for name in outcome.metrics if name not in DRAWN)
    looks = looks_of([OURS, *own])
    with rc_context({**STYLE, "figure.constrained_layout.h_pad": 0.12}):
        figure = Figure(figsize=(8.0, 6.4), layout="constrained")
        grid = figure.add_gridspec(2, 2)
        settled, whole = figure.add_subplot(grid[0, 0]), figure.add_subplot(grid[0, 1])
        cases = figure.add_subplot(grid[1, :])
        for name, look in looks.items():
            ran = [outcome for outcome in run if name in outcome.metrics]
            gains = [outcome.ratio("rms_error", "pi", name) for outcome in ran]
            _draw_distribution(settled, [outcome.ratio("rms_error_settled", "pi", name) for outcome in ran], look)
            _draw_distribution(whole, gains, look)
            cases.plot([one.fall for one in ran], gains, ".", color=look["color"], alpha=0.6, zorder=2.2)
        marked = sorted(run, key=lambda outcome: outcome.ratio("rms_error", "pi", OURS))[:worst]
        for rank, one in enumerate(marked, start=1):
            place = (one.fall, one.ratio("rms_error", "pi", OURS))
            cases.annotate(str(rank), place, (4.0, 3.0), textcoords="offset points", size=8.0, weight="bold")
        for axes, line in ((settled, settled.axvline), (whole, whole.axvline), (cases, cases.axhline)):
            line(1.0, **SAME)
            axes.set(**{f"{'y' if axes is cases else 'x'}scale": "log"})
            low, high = axes.get_ylim() if axes is cases else axes.get_xlim()
            low, high = min(low, 0.5), max(high, 2.0)
            axes.set(**{f"{'y' if axes is cases else 'x'}lim": (low, high)})
            label_decades(axes.yaxis if axes is cases else axes.xaxis, high / low)
        cases.axvline(HUNTING, color=QUIET, linewidth=1.0, linestyle=":")
        cases.set_xscale("symlog", linthresh=HUNTING)
        cases.set_xlim(-0.1, 2.0 * max(HUNTING, *(outcome.fall for outcome in run)))
        cases.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
        label_above(settled, f"percentage of {len(run)} joints")
        label_above(whole, "percentage of the joints")
        label_above(cases, "whole run: error of pi over the controller's; numbers: worst cases of adaptive")
        settled.set_xlabel("settled: error of pi over theirs (more is better)")
        whole.set_xlabel("whole run: error of pi over theirs (more is better)")
        cases.set_xlabel("steepest fall of friction over Kp; right of the dotted line pi itself hunts")
        key: Look = {"marker": "$1$", "linestyle": "", "color": INK, "label": "worst-1.toml and on"}
        explain_looks(figure, [*looks.values(), SAME, key])
        stamp([figure], source)
    return figure


def _draw_distribution(axes: Axes, values: Sequence[float], look: Look) -> None:
    """Draw the percentage of joints whose value is at most so large."""
    ordered = np.sort(np.asarray(values, dtype=float))
    if ordered.size:
        percent = 100.0 * np.arange(ordered.size + 1) / ordered.size
        axes.plot([ordered[0], *ordered], percent, drawstyle="steps-post", linewidth=1.5, color=look["color"])
        axes.set_ylim(0.0, 102.0)


def column_groups(controllers: list[str]) -> dict[str, list[str]]:
    """Return the columns by group, own ones first; PI and the models that are true but for the lag are left out."""
    found = {"own": [name for name in controllers if name not in CONTROLLERS and name not in KNOW_THE_TRUTH]}
    found |= {group: [name for name in names if name in controllers] for group, names in GROUPS.items()}
    placed = {name for names in found.values() for name in names} | KNOW_THE_TRUTH | {"pi"}
    truth = found.pop("knows the truth")
    found["others"] = [name for name in controllers if name not in placed]
    found["knows the truth"] = truth
    return {group: names for group, names in found.items() if names}


def plot_matrix(cells: Cells, controllers: list[str], title: str, source: str) -> Figure | None:
    """Draw the improvement over PI of every controller on every scenario; None where there is none but PI."""
    rows, columns = grouped(cells), column_groups(controllers)
    scenarios = [name for names in rows.values() for name in names]
    ordered = [name for names in columns.values() for name in names]
    if not ordered:
        return None
    gains = np.array(
        [[cells[row][name].gain if name in cells[row] else np.nan for name in ordered] for row in scenarios]
    )
    with rc_context(STYLE):
        figure = Figure(figsize=(5.6 + 0.46 * len(ordered), 3.4 + 0.3 * len(scenarios)), layout="constrained")
        axes = figure.add_subplot()
        levels = np.clip(np.log2(gains), WEAKEST, STRONGEST)
        image = axes.imshow(levels, cmap=COLOURS, norm=TwoSlopeNorm(0.0, WEAKEST, STRONGEST), aspect="auto")
        places = [place for place, name in enumerate(ordered) if name not in KNOW_THE_TRUTH]
        for i, row in enumerate(gains):
            best = places[int(np.argmax(np.nan_to_num(row[places])))] if places else -1
            for j, gain in enumerate(row):
                dark = levels[i, j] > DARK or levels[i, j] < DARK_RED
                text = "x" if not math.isfinite(gain) else f"{gain:.0f}" if gain >= 10.0 else f"{gain:.2g}"
                look: dict[str, Any] = {"ha": "center", "va": "center", "size": 7.0, "color": "white" if dark else INK}
                axes.text(j, i, text, weight="bold" if j == best else "normal", **look)
        _divide(axes, {name: len(names) for name, names in columns.items()}, vertical=True)
        _divide(axes, {name: len(names) for name, names in rows.items()}, vertical=False)
        axes.set_xticks(range(len(ordered)), ordered, rotation=60.0, ha="right", rotation_mode="anchor")
        axes.set_yticks(range(len(scenarios)), scenarios)
        axes.tick_params(length=0.0)
        axes.grid(False)
        figure.suptitle(f"{title}\nbold: best of those that do not know the truth; x: failed", size=9.0)
        ticks, short = range(-2, 7, 2), len(scenarios) <= 12
        bar = figure.colorbar(image, ax=axes, shrink=1.0 if short else 0.5, pad=0.02, ticks=ticks)
        bar.ax.set_yticklabels([f"{2.0**power:g}" for power in ticks])
        bar.set_label("error of pi over the controller's")
        stamp([figure], source)
    return figure


def _divide(axes: Axes, sizes: dict[str, int], *, vertical: bool) -> None:
    """Draw lines between groups, and name them above, or at the right."""
    end = 0
    for name, size in sizes.items():
        if end:
            (axes.axvline if vertical else axes.axhline)(end - 0.5, color=INK, linewidth=1.0)
        end += size
        middle = end - 0.5 * size - 0.5
        if vertical:
            place: Any = {"xytext": (0.0, 6.0), "textcoords": "offset points", "annotation_clip": False}
            axes.annotate(name, (middle, -0.5), **place, rotation=30.0, ha="left", va="bottom", size=8.0)
        else:
            axes.text(1.01, middle, name, transform=axes.get_yaxis_transform(), ha="left", va="center", size=8.0)
