"""Named arrays in recorded messages: MCAP (ROS 2, Foxglove), bags of ROS 1 (.bag) and ROS 2 (.db3 in its folder).

A number of a message is called ``TOPIC.FIELD``, with dots for members of members and without the slash before the
topic: ``joint_states.effort[2]`` picks one of an array. ``TOPIC.log_time`` is the time at which the recorder had the
message, ``TOPIC.header.stamp`` that of its header, both in s since 1970. Series of different topics have clocks of
their own, so time, motion and torque must be of one topic.
"""

import json
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import is_dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from adaptive_ff.errors import InputError

NANO = 1e-9
"""Seconds in a nanosecond."""

Series = dict[str, NDArray[Any]]
Read = tuple[dict[str, tuple[int, ...]], Series]
"""Shapes of all series, and the wanted ones."""

Messages = Callable[[], Iterator[tuple[int, Any]]]
"""Gives time, ns, and content of each message of a topic."""

JSON = SimpleNamespace(decoder_for=lambda encoding, schema: json.loads if encoding == "json" else None)
"""Makes decoders of JSON messages, as the library asks for them."""


def read_mcap(path: Path, wanted: Collection[str], reader_module: Any, ros2_module: Any) -> Read:
    """Read an MCAP file by the modules ``mcap.reader`` and ``mcap_ros2.decoder``.

    Raises
    ------
    InputError
        No message can be decoded, or an array of a wanted series changes its length.
    """
    with path.open("rb") as stream:
        reader = reader_module.make_reader(stream, decoder_factories=[ros2_module.DecoderFactory(), JSON])
        summary = reader.get_summary()
        if summary is None:
            raise InputError(f"{path}: the file has no summary, as of a recording that broke off; run 'mcap recover'")
        encodings = {channel.topic: channel.message_encoding for channel in summary.channels.values()}
        usable = [topic for topic, encoding in encodings.items() if encoding in ("cdr", "json")]
        if not usable:
            found = ", ".join(sorted(set(encodings.values()))) or "no topic"
            raise InputError(f"{path}: messages are encoded as {found}; cdr (ROS 2) and json are read")
        counts = dict.fromkeys(encodings, 0)
        for number, channel in summary.channels.items():
            counts[channel.topic] += summary.statistics.channel_message_counts.get(number, 0)

        def messages(topic: str) -> Messages:
            return lambda: ((one[2].log_time, one[3]) for one in reader.iter_decoded_messages(topics=[topic]))

        return _collected(path, wanted, {topic: (counts[topic], messages(topic)) for topic in usable})


def read_bag(path: Path, wanted: Collection[str], anyreader: Any, typesys: Any) -> Read:
    """Read a bag by the modules ``rosbags.highlevel`` and ``rosbags.typesys``.

    Raises
    ------
    InputError
        A .db3 has no metadata beside it, or an array of a wanted series changes its length.
    """
    is_folder = path.suffix == ".db3"
    if is_folder and not (path.parent / "metadata.yaml").exists():
        raise InputError(f"{path}: there is no metadata.yaml beside it; run ros2 bag reindex on its folder")
    types = typesys.get_typestore(typesys.Stores.LATEST)
    with anyreader.AnyReader([path.parent if is_folder else path], default_typestore=types) as reader:

        def messages(connection: Any) -> Messages:
            return lambda: (
                (stamp, reader.deserialize(raw, link.msgtype))
                for link, stamp, raw in reader.messages(connections=[connection])
            )

        return _collected(path, wanted, {one.topic: (one.msgcount, messages(one)) for one in reader.connections})


def _collected(path: Path, wanted: Collection[str], topics: Mapping[str, tuple[int, Messages]]) -> Read:
    """Return shapes by the first message of each topic, and wanted series, which have one length throughout."""
    shapes: dict[str, tuple[int, ...]] = {}
    arrays: Series = {}
    for topic, (count, messages) in topics.items():
        prefix = topic.lstrip("/").replace("/", ".")
        first = next((_named(*message, prefix) for message in messages()), {})
        shapes |= {name: (count, *value.shape) for name, value in first.items()}
        rows: dict[str, list[NDArray[Any]]] = {name: [] for name in wanted if name in first}
        for message in messages() if rows else ():
            content = _named(*message, prefix)
            for name, values in rows.items():
                value = content.get(name)
                if value is None or value.shape != first[name].shape:
                    raise InputError(f"{path}: {name} is not the same in all messages; it must have one length")
                values.append(value)
        arrays |= {name: np.array(values) for name, values in rows.items()}
    return shapes, arrays


def _named(stamp: int, content: Any, prefix: str) -> Series:
    return {f"{prefix}.log_time": np.asarray(stamp * NANO), **dict(_numbers(content, prefix))}


def _numbers(content: Any, prefix: str) -> Iterator[tuple[str, NDArray[Any]]]:
    """Yield all numbers in a message, and arrays of them, by name."""
    slots = getattr(type(content), "__slots__", ())
    members: Mapping[str, Any] = {name: getattr(content, name) for name in slots}
    if isinstance(content, Mapping) or is_dataclass(content):
        members = content if isinstance(content, Mapping) else vars(content)
    if {"sec", "nanosec"} <= set(members):
        yield prefix, np.asarray(members["sec"] + NANO * members["nanosec"])
    elif members:
        for name, member in members.items():
            yield from _numbers(member, f"{prefix}.{name}")
    else:
        values = np.asarray("" if isinstance(content, str | bytes) else content)
        if values.dtype.kind in "iufb" and values.ndim <= 1:
            yield prefix, values
