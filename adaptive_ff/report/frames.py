"""A comparison as tables of pandas and xarray, with units (extra ``pandas``)."""

from dataclasses import asdict
from typing import Any

from adaptive_ff.comparison.comparison import Comparison
from adaptive_ff.errors import library
from adaptive_ff.scenario.axis_units import axis_unit
from adaptive_ff.simulation.metrics import METRIC_UNITS

SERIES_UNITS = {
    **dict.fromkeys(("reference", "velocity", "measured"), "rad/s"),
    **dict.fromkeys(("torque", "feedforward", "friction"), "N m"),
}
"""Units of the series at the samples."""


def figures_frame(comparison: Comparison) -> Any:
    """Return the figures of merit as a ``pandas.DataFrame``, a row a controller."""
    pandas = library("pandas")
    frame = pandas.DataFrame({name: asdict(run.metrics) for name, run in comparison.runs.items()}).T
    frame["improvement"] = pandas.Series(comparison.improvement)
    frame.index.name = "controller"
    frame.attrs["units"] = {
        name: axis_unit(comparison.scenario.joint.axis, unit) for name, unit in METRIC_UNITS.items()
    } | {"improvement": "1"}
    return frame


def series_dataset(comparison: Comparison) -> Any:
    """Return the series at the samples as an ``xarray.Dataset`` by controller and time."""
    xarray = library("xarray")
    columns = [run.columns() for run in comparison.runs.values()]
    data: dict[str, Any] = {}
    for series, unit in SERIES_UNITS.items():
        common = series == "reference"
        values = columns[0][series] if common else [one[series] for one in columns]
        data[series] = (
            "time" if common else ("controller", "time"),
            values,
            {"units": axis_unit(comparison.scenario.joint.axis, unit)},
        )
    time = ("time", columns[0]["time"], {"units": "s"})
    return xarray.Dataset(data, {"controller": list(comparison.runs), "time": time})
