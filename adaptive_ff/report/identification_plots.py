"""Pictures of an identified log."""

from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.report.drawing import (
    INK,
    STYLE,
    Look,
    draw_series,
    explain_looks,
    label_above,
    make_panels,
    stamp,
    write_into,
)

MEASURED: Look = {"color": "#a6a6a6", "linewidth": 2.0, "label": "measured"}
MODEL: Look = {"color": "#d55e00", "linewidth": 1.0, "label": "inertia and friction as identified"}
LEFT: Look = {"color": "#0072b2", "linewidth": 0.8, "label": "measured − identified"}
ROWS: Look = {"color": "#9ec5e0", "marker": ".", "markersize": 2.5, "linestyle": "", "label": "rows of the log"}
MEANS: Look = {"color": "#0072b2", "marker": "o", "markersize": 3.5, "linestyle": "", "label": "mean in a bin"}
TEXTBOOK: Look = {"color": INK, "linewidth": 0.8, "linestyle": (0, (3, 2)), "label": "textbook"}

PICTURES = ("identified_torque", "friction", "identified_map")
"""Names of the pictures; without friction or force over position there is no map."""

CLOSE_UP = 0.08
"""Length of the close-up over that of the log; around the fastest change of the torque."""


def plot_identification(found: LogIdentification, folder: str | Path | None = None) -> dict[str, Figure]:
    """Draw the report of an identified log.

    Parameters
    ----------
    found : LogIdentification
        The joint.
    folder : str or Path, optional
        Where to write each picture as ``NAME.png``; it is made where it is missing.

    Returns
    -------
    dict of Figure
        ``identified_torque``: torque over time, measured and identified; ``friction``: friction and residual over the
        velocity; ``identified_map``: friction and force over position, where the model has them.
    """
    with rc_context(STYLE):
        figures = {"identified_torque": _torque(found), "friction": _friction(found)}
        if any(name.startswith(("force_", "friction_")) and name != "friction_lag" for name in found.best.values):
            figures["identified_map"] = _map(found)
        stamp(figures.values(), found.name)
        write_into(figures, folder)
    return figures


def _torque(found: LogIdentification) -> Figure:
    figure, (whole, near, left) = make_panels(3, 7.0, shared=False)
    rows, unit = found.rows, found.units["torque"]
    gaps = np.diff(rows.time, prepend=rows.time[0]) > 3.0 * float(np.median(np.diff(rows.time)))
    fitted = np.where(gaps, np.nan, rows.fitted)
    for axes in (whole, near):
        draw_series(axes, rows.time, rows.torque, MEASURED)
        draw_series(axes, rows.time, fitted, MODEL)
    draw_series(left, rows.time, rows.torque - fitted, LEFT)
    length = CLOSE_UP * float(np.ptp(rows.time))
    middle = float(rows.time[int(np.argmax(np.abs(np.diff(rows.torque))))])
    near.set_xlim(middle - 0.5 * length, middle + 0.5 * length)
    label_above(whole, f"{Path(found.name).name}: torque ({unit}) in a band of {found.bandwidth:.3g} Hz, while sliding")
    label_above(near, f"torque ({unit}), close-up")
    label_above(left, f"residual ({unit})")
    left.set_xlabel("time (s)")
    explain_looks(figure, [MEASURED, MODEL, LEFT])
    return figure


def _friction(found: LogIdentification) -> Figure:
    figure, (curve, left) = make_panels(2, 6.4)
    rows = found.rows
    residual = rows.torque - rows.fitted
    friction = residual + found.friction(rows.velocity)
    every = max(1, rows.velocity.size // 5000)
    for axes, values in ((curve, friction), (left, residual)):
        axes.plot(rows.velocity[::every], values[::every], **ROWS)
    points = found.friction_points()
    curve.plot(points["velocity"], points["torque"], **MEANS)
    left.plot(points["velocity"], points["torque"] - found.friction(points["velocity"]), **MEANS)
    keys = [ROWS, MEANS, MODEL]
    textbook = found.textbook.values
    for side in (-1.0, 1.0):
        fastest = float(np.max(side * rows.velocity, initial=0.0))
        if fastest <= 0.0:
            continue
        speeds = side * (1e-3 * fastest + 0.999 * fastest * np.linspace(0.0, 1.0, 400) ** 2)
        curve.plot(speeds, found.friction(speeds), **{**MODEL, "zorder": 2.6})
        if found.refined is not None:
            line = side * textbook.get("coulomb", 0.0) + textbook.get("viscous", 0.0) * speeds
            curve.plot(speeds, line + textbook.get("offset", 0.0), **TEXTBOOK)
    if found.refined is not None:
        keys.append(TEXTBOOK)
    left.axhline(0.0, **MODEL)
    low, high = np.quantile(friction, (0.002, 0.998))
    margin = 0.15 * (high - low)
    curve.set_ylim(low - margin, high + margin)
    label_above(curve, f"{Path(found.name).name}: friction ({found.units['torque']}), offset included")
    label_above(left, f"measured − identified ({found.units['torque']})")
    left.set_xlabel(f"velocity ({found.units['velocity']})")
    explain_looks(figure, keys)
    return figure


def _map(found: LogIdentification) -> Figure:
    figure, (axes,) = make_panels(1, 3.2)
    place, rows = found.place, found.rows
    position = np.linspace(float(rows.position.min()), float(rows.position.max()), 400)
    keys = []
    for kind, look in (("friction", MODEL), ("force", LEFT)):
        parts = {name: found.value(f"{kind}_{name}") for name in place.names}
        if any(parts.values()):
            curve = sum(value * place.share(name, position) for name, value in parts.items())
            axes.plot(position, curve, **{**look, "label": f"{kind} over position"})
            keys.append({**look, "label": f"{kind} over position"})
    label_above(axes, f"{Path(found.name).name}: beside its mean ({found.units['torque']})")
    axes.set_xlabel(f"position ({found.units['velocity'].removesuffix('/s')})")
    explain_looks(figure, keys)
    return figure
