"""Named arrays in MCAP files, as recorded by ROS 2 and Foxglove: messages in CDR (ROS 2) or JSON.

A number of a message is called ``TOPIC.FIELD``, with dots for members of members and without the slash before the
topic: ``joint_states.effort[2]`` picks one of an array. ``TOPIC.log_time`` is the time at which the recorder had the
message, ``TOPIC.header.stamp`` that of its header, both in s since 1970. Series of different topics have clocks of
their own, so time, motion and torque must be of one topic.
"""

import json
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.errors import InputError

NANO = 1e-9
"""Seconds in a nanosecond."""

LOG_TIME = "log_time"
"""Field that every topic has."""

STAMP = {"sec", "nanosec"}
"""Members of a time."""

Series = dict[str, NDArray[Any]]


class JsonDecoders:
    """Makes decoders of JSON messages, as the library asks for them."""

    def decoder_for(self, message_encoding: str, schema: Any) -> Callable[[bytes], Any] | None:
        """Return the decoder of an encoding; None for one that is not JSON."""
        return json.loads if message_encoding == "json" else None


def read_mcap(
    path: Path, wanted: Collection[str], reader_module: Any, ros2_module: Any
) -> tuple[dict[str, tuple[int, ...]], Series]:
    """Return the shapes of all series of a file, and the wanted ones.

    Parameters
    ----------
    path : Path
        The file.
    wanted : collection of str
        Names of series.
    reader_module, ros2_module : module
        ``mcap.reader`` and ``mcap_ros2.decoder``.

    Raises
    ------
    InputError
        No message can be decoded, or an array of a wanted series changes its length.
    """
    with path.open("rb") as stream:
        reader = reader_module.make_reader(stream, decoder_factories=[ros2_module.DecoderFactory(), JsonDecoders()])
        summary = reader.get_summary()
        if summary is None:
            raise InputError(f"{path}: the file has no summary, as of a recording that broke off; run 'mcap recover'")
        counts = dict.fromkeys((_bare(channel.topic) for channel in summary.channels.values()), 0)
        for number, channel in summary.channels.items():
            counts[_bare(channel.topic)] += summary.statistics.channel_message_counts.get(number, 0)
        encodings = {_bare(channel.topic): channel.message_encoding for channel in summary.channels.values()}
        usable = [topic for topic, encoding in encodings.items() if encoding in ("cdr", "json")]
        if not usable:
            found = ", ".join(sorted(set(encodings.values()))) or "no topic"
            raise InputError(f"{path}: messages are encoded as {found}; cdr (ROS 2) and json are read")
        whole = {_bare(channel.topic): channel.topic for channel in summary.channels.values()}
        shapes: dict[str, tuple[int, ...]] = {}
        for topic in usable:
            first = next(_messages(reader, whole[topic]), None)
            if first is not None:
                shapes.update({name: (counts[topic], *value.shape) for name, value in first.items()})
        arrays: Series = {}
        for topic in usable:
            names = [name for name in wanted if name in shapes and name.startswith(f"{topic}.")]
            if names:
                arrays.update(collect(path, _messages(reader, whole[topic]), names))
    return shapes, arrays


def _bare(topic: str) -> str:
    return topic.lstrip("/").replace("/", ".")


def _messages(reader: Any, topic: str) -> Iterator[Series]:
    """Return the numbers of each message of a topic, by name."""
    for _, channel, message, content in reader.iter_decoded_messages(topics=[topic]):
        prefix = _bare(channel.topic)
        yield {f"{prefix}.{LOG_TIME}": np.asarray(message.log_time * NANO), **dict(numbers(content, prefix))}


def numbers(content: Any, prefix: str) -> Iterator[tuple[str, NDArray[Any]]]:
    """Return all numbers in a message, and arrays of them, by name."""
    members = _members(content)
    if members is None:
        values = np.asarray(content) if not isinstance(content, str | bytes) else np.asarray("")
        if values.dtype.kind in "iufb" and values.ndim <= 1:
            yield prefix, values
    elif set(members) >= STAMP:
        yield prefix, np.asarray(members["sec"] + NANO * members["nanosec"])
    else:
        for name, member in members.items():
            yield from numbers(member, f"{prefix}.{name}")


def _members(content: Any) -> Mapping[str, Any] | None:
    """Return the members of a message; None where it has none."""
    if isinstance(content, Mapping):
        return content
    if is_dataclass(content):
        return {field.name: getattr(content, field.name) for field in fields(content)}
    slots = getattr(type(content), "__slots__", None)
    return {name: getattr(content, name) for name in slots} if slots else None


def collect(path: Path, messages: Iterator[Series], names: list[str]) -> Series:
    """Return the wanted series of messages, which must have one length throughout."""
    rows: dict[str, list[NDArray[Any]]] = {name: [] for name in names}
    for message in messages:
        for name in names:
            value = message.get(name)
            if value is None or (rows[name] and rows[name][0].shape != value.shape):
                raise InputError(f"{path}: {name} is not the same in all messages; it must have one length")
            rows[name].append(value)
    return {name: np.array(values) for name, values in rows.items()}
