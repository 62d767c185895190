"""Figures of pictures and tables: every word in them, and the size of every line and band."""

import numpy as np
from drawn_arguments import digest, plain

from adaptive_ff import compare, load_scenario
from adaptive_ff.report.comparison_pictures import plot_comparison, plot_run
from adaptive_ff.report.tables import comparison_tables

SHORT = load_scenario().modified(duration=12.0)
MAP = {"position_hats": 3, "position_range": [-0.5, 0.5]}
CHANGES = [{"time": 3.0, "friction_scale": 0.6}, {"time": 4.0, "friction_scale": 1.5}]
DRAWN = {
    "changes": {"change": CHANGES, "controllers": ["pi", "fixed", "oracle", "adaptive_paper", "adaptive"]},
    "linear": {"joint": {"axis": "linear"}, "duration": 3.0, "controllers": ["pi", "adaptive"], "adaptation": MAP},
    "cascade": {"position": {}, "change": CHANGES[:1], "controllers": ["pi", "fixed"]},
    "limit": {"actuator": {"torque_limit": 100.0}, "duration": 4.0, "controllers": ["adaptive"]},
}
"""Comparisons that are drawn."""


class Proportional:
    """A user's own controller: no estimates, no feedforward."""

    def step(self, reference, velocity, **others):
        return 1500.0 * (reference - velocity)


def size(values):
    finite = np.asarray(values, dtype=float)
    return float(np.sqrt(np.mean(np.square(finite[np.isfinite(finite)])))) if np.any(np.isfinite(finite)) else 0.0


def axes_figures(axes):
    """Return words, scales and sizes of the lines of a panel."""
    words = [axes.get_title(), axes.get_xlabel(), axes.get_ylabel(), axes.get_yscale()]
    words += [text.get_text() for text in axes.texts]
    found = {"words": " | ".join(words)}
    for place, line in enumerate(axes.lines):
        look = f"{place} {line.get_label()} {line.get_color()} {line.get_linestyle()} {line.get_drawstyle()}"
        found[f"{look} x"], found[f"{look} y"] = size(line.get_xdata()), size(line.get_ydata())
    for place, band in enumerate(axes.collections):
        found[f"band {place}"] = sum(size(path.vertices[:, 1]) for path in band.get_paths())
    for name, limits in (("from", axes.get_xlim()), ("between", axes.get_ylim())):
        found[f"{name} {len(limits)}"] = float(limits[1] - limits[0])
    return found


def picture_figures(name):
    """Return what is in the pictures and tables of a comparison and in that of its last run."""
    own = {"mine": Proportional()} if name == "cascade" else None
    comparison = compare(SHORT.modified(**DRAWN[name]), own=own)
    run = list(comparison.runs.values())[-1]
    found = {
        f"table {table.title}": digest(plain([table.heads, table.rows])) for table in comparison_tables(comparison)
    }
    for title, figure in {**plot_comparison(comparison), "run": plot_run(run)}.items():
        found[f"{title} legend"] = " | ".join(text.get_text() for one in figure.legends for text in one.get_texts())
        for place, axes in enumerate(figure.axes):
            found |= {f"{title} {place} {key}": value for key, value in axes_figures(axes).items()}
    return found


PICTURES = {f"pictures of {name}": (picture_figures, (name,)) for name in DRAWN}
