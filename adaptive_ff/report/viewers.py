"""Series of a result as an MCAP file of JSON messages with a schema, and a layout of PlotJuggler that shows them.

A topic holds objects of numbers: ``/adaptive`` has ``torque.feedforward``, which PlotJuggler lists as
``/adaptive/torque/feedforward`` and Foxglove addresses as ``/adaptive.torque.feedforward``. Times count from zero.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from functools import singledispatch
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from adaptive_ff.comparison.comparison import Comparison
from adaptive_ff.comparison.run import Run
from adaptive_ff.errors import library
from adaptive_ff.friction.model import unit_of
from adaptive_ff.identify.result import LogIdentification
from adaptive_ff.replay.replay import Replay
from adaptive_ff.report.table import DEVIATIONS
from adaptive_ff.scenario.axis_units import axis_unit
from controllers.arrays import NDArray

Array = NDArray[np.float64]

NANO = 1e9  # nanoseconds in a second


class Part(NamedTuple):
    """Series of one unit that are shown in one plot."""

    unit: str
    series: Mapping[str, Array]


class Topic(NamedTuple):
    """Series at the same times (s), in parts by name."""

    name: str
    time: Array
    parts: dict[str, Part]


@singledispatch
def topics(result: Any) -> list[Topic]:
    """Return the series of a comparison, an identification or a replay."""
    raise TypeError(f"{type(result).__name__} has no series")


@topics.register
def _(result: Comparison) -> list[Topic]:
    return [topic for run in result.runs.values() for topic in _of_run(run)]


def _of_run(run: Run) -> Iterator[Topic]:
    speed, torque = (axis_unit(run.scenario.joint.axis, unit) for unit in ("rad/s", "N m"))
    columns = run.columns()
    error = columns["reference"] - columns["velocity"]
    motion = {name: columns[name] for name in ("reference", "velocity", "measured")} | {"error": error}
    torques = {
        "applied": run.torque,
        "feedforward": run.feedforward,
        "feedback": run.torque - run.feedforward,
        "friction": run.friction,
    }
    parts = {"motion": Part(speed, motion), "torque": Part(torque, torques)}
    for name, series in run.estimates.items():
        parts[name] = Part(unit_of(name), {"estimate": series})
    if run.monitors:
        parts["monitors"] = Part("", run.monitors)
    yield Topic(f"/{run.name}", run.time, parts)
    if run.uncertainties:
        at = run.uncertainty_time
        bounds = {}
        for name, spread in run.uncertainties.items():
            value = np.interp(at, run.time, run.estimates[name])
            ends = {"lower": value - DEVIATIONS * spread, "upper": value + DEVIATIONS * spread}
            bounds[name] = Part(unit_of(name), ends)
        yield Topic(f"/{run.name}/bounds", at, bounds)


@topics.register
def _(result: LogIdentification) -> list[Topic]:
    rows, torque = result.data, result.units["torque"]
    left = {"measured": rows.torque, "model": result.fitted, "left": rows.torque - result.fitted}
    parts = {"motion": Part(result.units["velocity"], {"velocity": rows.velocity}), "torque": Part(torque, left)}
    found = {
        name: Part(result.units[name], {end: np.array([getattr(one, end)]) for end in ("value", "lower", "upper")})
        for name, one in result.parameters.items()
    }
    return [Topic("/log", rows.time, parts), Topic("/parameters", rows.time[:1], found)]


@topics.register
def _(result: Replay) -> list[Topic]:
    series = result.series
    found = [Topic("/log", series.time, {"torque": Part(result.unit, {"needed": series.needed})})]
    for name, feedforward in series.feedforward.items():
        torque = {"feedforward": feedforward, "left": series.needed - feedforward}
        parts = {"torque": Part(result.unit, torque)}
        for parameter, values in series.estimates.get(name, {}).items():
            parts[parameter] = Part(result.units[parameter], {"estimate": values})
        found.append(Topic(f"/{name}", series.time, parts))
    return found


def schema(topic: Topic) -> dict[str, Any]:
    """Return the JSON schema of a topic's messages, units as descriptions."""
    parts = {}
    for name, part in topic.parts.items():
        numbers = {one: {"type": "number", "description": part.unit} for one in part.series}
        parts[name] = {"type": "object", "properties": numbers}
    return {"type": "object", "title": topic.name, "properties": parts}


def write_mcap(file: Path, result: Any) -> None:
    """Write the series of a result as MCAP; values that are not finite are left out of their messages."""
    writing = library("mcap.writer", f"{file.name}: to write it")
    with file.open("wb") as stream:
        writer = writing.Writer(stream)
        writer.start(profile="", library="adaptive-ff")
        messages = []
        for topic in topics(result):
            known = writer.register_schema(
                name=f"adaptive_ff{topic.name.replace('/', '.')}",
                encoding="jsonschema",
                data=json.dumps(schema(topic)).encode(),
            )
            channel = writer.register_channel(topic=topic.name, message_encoding="json", schema_id=known)
            messages += [(moment, channel, topic, place) for place, moment in enumerate(topic.time)]
        for number, (moment, channel, topic, place) in enumerate(sorted(messages, key=lambda one: one[0])):
            stamp = max(0, round(float(moment) * NANO))
            values = {
                name: {one: float(series[place]) for one, series in part.series.items() if np.isfinite(series[place])}
                for name, part in topic.parts.items()
            }
            data = json.dumps(values).encode()
            writer.add_message(channel, log_time=stamp, publish_time=stamp, sequence=number, data=data)
        writer.finish()


def layout(result: Any) -> str:
    """Return a layout of PlotJuggler: a tab each for the motion, the torques and the estimates of all topics."""
    root = ElementTree.Element("root")
    tabs = ElementTree.SubElement(root, "tabbed_widget", {"name": "Main Window", "parent": "main_window"})
    found = topics(result)
    for part in ("motion", "torque"):
        _tab(tabs, part, [(topic, part) for topic in found if part in topic.parts])
    for topic in found:
        others = [name for name in topic.parts if name not in ("motion", "torque", "monitors")]
        beside = [one for one in found if one.name == f"{topic.name}/bounds"]
        if others and not topic.name.endswith("/bounds"):
            _tab(tabs, topic.name.strip("/"), [(topic, name) for name in others], beside)
    ElementTree.indent(root, " ")
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _tab(tabs: ElementTree.Element, title: str, plots: list[tuple[Topic, str]], beside: Sequence[Topic] = ()) -> None:
    if not plots:
        return
    container = ElementTree.SubElement(ElementTree.SubElement(tabs, "Tab", tab_name=title, containers="1"), "Container")
    sizes = ";".join([f"{1.0 / len(plots):.6f}"] * len(plots))
    splitter = ElementTree.SubElement(container, "DockSplitter", orientation="-", count=str(len(plots)), sizes=sizes)
    for topic, name in plots:
        area = ElementTree.SubElement(splitter, "DockArea", name="...")
        plot = ElementTree.SubElement(area, "plot", style="Lines", mode="TimeSeries", flip_x="false", flip_y="false")
        for one in (topic, *beside):
            for series in one.parts[name].series if name in one.parts else ():
                ElementTree.SubElement(plot, "curve", name=f"{one.name}/{name}/{series}")
